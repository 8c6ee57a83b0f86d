"""Heat from the command line and through the service: measured temperatures, heaters, and what is refused."""
import hashlib
import json
import math
import struct
import unittest
import zlib

import meshes
from harness import Case, Server, vacuform

RING = ('<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="-30 -30 60 60">'
        '<circle r="20" fill="none" stroke="black" stroke-width="5"/></svg>')
COARSE = {"scan": {"units": "mm", "up": "+z"}, "sheet": {"resolution_mm": 7.5}, "print": {"dpi": 72, "marks": False}}
# A camera's picture of a sheet that was hot in the middle: 5 x 5 cells of 60 mm, warmer in the upper half.
ROWS = [[126, 133, 136, 133, 126], [133, 142, 146, 142, 133], [134, 144, 149, 144, 134],
        [130, 139, 143, 139, 130], [122, 129, 132, 129, 122]]


def png(width, height, colour, rows):
    """An 8-bit PNG of gray (colour 0) or RGB (colour 2)."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", width, height, 8, colour, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) +
            chunk(b"IDAT", zlib.compress(b"".join(b"\0" + bytes(row) for row in rows))) + chunk(b"IEND", b""))


def bilinear(s, t):
    """ROWS on a sheet of 300 x 300 mm, between the middles of its cells."""
    def locate(along):
        along = min(max(along / 60 + 2, 0), 4)
        before = min(int(along), 3)
        return before, along - before
    (i, u), (j, v) = locate(s), locate(-t)
    return ((1 - v) * ((1 - u) * ROWS[j][i] + u * ROWS[j][i + 1]) +
            v * ((1 - u) * ROWS[j + 1][i] + u * ROWS[j + 1][i + 1]))


def hashes(folder):
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.iterdir()}


class Heat(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scan, cls.pattern = cls.folder / "dome.stl", cls.folder / "ring.svg"
        cls.scan.write_bytes(meshes.stl(meshes.hemisphere(70, 40, 80)))
        cls.pattern.write_text(RING)
        cls.rows = cls.folder / "camera.csv"
        cls.rows.write_text("\n".join(",".join(map(str, row)) for row in ROWS))
        cls.even = cls.run_with("even", {})
        cls.measured = cls.run_with("measured", {}, "--temperature", cls.rows)

    @classmethod
    def run_with(cls, name, settings, *words):
        (cls.folder / f"{name}.json").write_text(json.dumps(COARSE | settings))
        done = vacuform("run", "--scan", cls.scan, "--pattern", cls.pattern, "--settings", cls.folder / f"{name}.json",
                        "--out", cls.folder / name, *words)
        assert done.returncode == 0, done.stderr
        return cls.folder / name

    def report(self, folder):
        return json.loads((folder / "report.json").read_text())

    def test_measured_temperatures_are_those_of_the_sheet(self):
        ply = meshes.Ply((self.measured / "formed.ply").read_bytes())
        for s, t, celsius in zip(ply.vertices["s"], ply.vertices["t"], ply.vertices["temperature"]):
            self.assertAlmostEqual(celsius, bilinear(s, t), delta=1e-3)
        report = self.report(self.measured)
        self.assertEqual(report["settings"]["heat"]["source"], "measured")
        self.assertEqual(report["sha256"]["temperature"], hashlib.sha256(self.rows.read_bytes()).hexdigest())
        heat = report["heat"]
        self.assertEqual(heat["source"], "measured")
        self.assertAlmostEqual(heat["most_c"], 149, delta=0.05)
        self.assertAlmostEqual(heat["least_c"], 122, delta=0.05)
        self.assertGreater(heat["mean_c"], 130)
        self.assertIn("preview-temperature.png", [a["name"] for a in report["artifacts"]])
        self.assertTrue((self.measured / "preview-temperature.png").read_bytes().startswith(b"\x89PNG"))

    def test_an_even_sheet_is_at_its_forming_temperature(self):
        heat = self.report(self.even)["heat"]
        self.assertEqual((heat["source"], heat["least_c"], heat["most_c"]), ("uniform", 140.5, 140.5))
        self.assertFalse((self.even / "preview-temperature.png").exists())

    def test_a_colder_rim_moves_the_print(self):
        """A stiffer rim keeps its plastic: what lands on the head comes from nearer its middle."""
        even, cold = (meshes.Ply((f / "formed.ply").read_bytes()) for f in (self.even, self.measured))
        places = dict(zip(zip(cold.vertices["s"], cold.vertices["t"]), cold.points))
        moved = [math.dist(p, places[st]) for st, p, c in zip(zip(even.vertices["s"], even.vertices["t"]), even.points,
                                                    even.vertices["contact"]) if c == 1 and st in places]
        self.assertGreater(len(moved), 300)
        self.assertGreater(max(moved), 1)
        self.assertLess(max(moved), 25)

    def test_a_gray_picture_is_the_same_field(self):
        picture = self.folder / "camera.png"
        picture.write_bytes(png(5, 5, 0, [[round((c - 100) * 255 / 51) for c in row] for row in ROWS]))
        out = self.run_with("gray", {"heat": {"black_c": 100, "white_c": 151}}, "--temperature", picture)
        self.assertEqual((out / "formed.ply").read_bytes(), (self.measured / "formed.ply").read_bytes())

    def test_the_service_makes_the_same(self):
        with Server(self.folder, workers=1) as server:
            out = self.folder / "submitted"
            settings = self.folder / "even.json"
            done = vacuform("submit", "--server", server.url, "--scan", self.scan, "--pattern", self.pattern, "--temperature",
                            self.rows, "--settings", settings, "--wait", "--out", out)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(hashes(out), hashes(self.measured))

            bad = self.folder / "bad.csv"
            bad.write_text("140,hot\n")
            job = server.wait(server.post(self.scan, self.pattern, COARSE, "-F", f"temperature=@{bad}").json["id"])
            self.assertEqual((job["state"], job["problem"]["type"]), ("failed", "/problems/corrupt-file"), job)
            self.assertIn("line 1", job["problem"]["where"])

    def test_heaters(self):
        heaters = [{"x_mm": x, "y_mm": y, "z_mm": 100, "width_mm": 100, "height_mm": 100, "celsius": 450,
                    "zone": "rim" if x or y else ""} for x in (-100, 0, 100) for y in (-100, 0, 100)]
        machine = {"heaters": heaters, "reflector_mm": 40, "lip_mm": 5}
        plain = self.report(self.run_with("heaters", {"machine": machine, "heat": {"source": "heaters", "gains": {"rim": 1.1}}}))
        heat = plain["heat"]
        self.assertAlmostEqual(heat["mean_c"], 140.5, delta=0.3)
        self.assertGreater(heat["most_c"], heat["least_c"] + 20)
        self.assertTrue(10 < heat["seconds"] < 120, heat)
        codes = {w["code"]: w["what"] for w in plain["warnings"]}
        self.assertIn("too-cold", codes)
        self.assertRegex(codes["too-cold"], r"colder than PETG forms \(121 to 160 C\): \d+ C at x = -?\d+ mm, y = -?\d+ mm, z = ")

    def test_refusals(self):
        colour, cut = self.folder / "colour.png", self.folder / "cut.png"
        colour.write_bytes(png(2, 2, 2, [[200, 0, 0, 0, 200, 0]] * 2))
        cut.write_bytes(png(5, 5, 0, ROWS)[:60])
        points = self.folder / "points.csv"
        points.write_text("s,t,celsius\n0,0,140\n400,0,130\n")
        empty = self.folder / "empty.csv"
        empty.write_text("")
        scale = ["--set", "heat.black_c=20", "--set", "heat.white_c=200"]
        for words, says in [
                (["--temperature", colour, *scale], ["in colour", "colour.png", "as gray"]),
                (["--temperature", cut, *scale], ["PNG is damaged", "cut.png"]),
                (["--temperature", cut], ["black and white", "heat.black_c"]),
                (["--temperature", points], ["off the sheet", "points.csv, line 3"]),
                (["--temperature", empty], ["no temperature", "empty.csv"]),
                (["--temperature", self.scan], ["dome.stl"]),
                (["--temperature", self.folder / "none.csv"], ["none.csv"]),
                (["--set", "heat.source=measured"], ["heat.source", "--temperature FILE"]),
                (["--set", "heat.source=heaters"], ["machine.heaters", "no heaters"]),
                (["--set", "heat.source=heaters", "--set", 'machine.heaters=[{"celsius": 90}]'],
                 ["does not become warmer", "machine.heaters"])]:
            with self.subTest(words):
                done = vacuform("run", "--scan", self.scan, "--pattern", self.pattern, "--out", self.folder / "refused", *words)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertRegex(done.stderr, r"\Avacuform: [^\n]+\n\Z")
                for word in says:
                    self.assertIn(word, done.stderr)


if __name__ == "__main__":
    unittest.main()
