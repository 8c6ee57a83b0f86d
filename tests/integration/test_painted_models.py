"""The bundled models that wear colours: from the sample to a print in which every landmark is in its place."""
import json
import struct
import subprocess
import unittest

from harness import Case, vacuform
from test_colours import pixels

DPI = 200
BLUE = (0x15, 0x3A, 0x8A)  # of the landmarks' crosses

# Landmarks by their places on the plan of the model, mm: those where the sheet touches.
MASK = {"F": (0, 66), "N": (0, 28), "T": (0, -12), "C1": (-40, -16), "C2": (40, -16), "M1": (-28, -47), "M2": (28, -47), "G": (0, -76)}


def formed_sheet(path):
    """Vertices as (x, y, z, s, t) and triangles of formed.ply."""
    data = path.read_bytes()
    head, _, body = data.partition(b"end_header\n")
    count = {line.split()[1]: int(line.split()[2]) for line in head.decode().splitlines() if line.startswith("element")}
    vertices = [v[:5] for v in struct.iter_unpack("<9fB", body[:37 * count["vertex"]])]
    return vertices, [f[1:] for f in struct.iter_unpack("<B3i", body[37 * count["vertex"]:])]


def sheet_point_above(vertices, triangles, x, y):
    """(s, t) of the formed sheet over a place of the plan."""
    for triangle in triangles:
        a, b, c = (vertices[v] for v in triangle)
        if not min(a[0], b[0], c[0]) <= x <= max(a[0], b[0], c[0]) or not min(a[1], b[1], c[1]) <= y <= max(a[1], b[1], c[1]):
            continue
        area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        if area == 0:
            continue
        u = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / area
        v = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / area
        if u >= 0 and v >= 0 and u + v <= 1:
            return [a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]) for k in (3, 4)]
    raise AssertionError(f"no sheet over {x}, {y}")


class PaintedModels(Case):
    def printed(self, model, *words):
        """The folder of a print of the model."""
        done = vacuform("sample", "--model", model, "--out", self.folder)
        self.assertEqual((done.returncode, done.stdout), (0, f"wrote {model}.glb into {self.folder}\n"))
        out = self.folder / model
        done = vacuform("run", "--scan", self.folder / f"{model}.glb", "--set", "pattern.source=scan", "--out", out, *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        return out

    def centre_of_cross(self, rows, s, t):
        """Where the cross near (s, t) is, mm: the middle of each bar, on both sides of the other."""
        def blue(s, t):
            """How blue the pixel is: 1 like the cross, 0 like anything that is no bluer than red."""
            r, _, b = rows[round(len(rows) / 2 - t * DPI / 25.4 - 0.5)][round(len(rows) / 2 + s * DPI / 25.4 - 0.5)]
            return max(0, b - r) / (BLUE[2] - BLUE[0])
        steps = [k * 0.05 for k in range(-36, 37)]
        def middle(weight):
            found = [(weight(d), d) for d in steps]
            total = sum(w for w, _ in found)
            self.assertGreater(total, 3, f"no cross at {s}, {t}")
            return sum(w * d for w, d in found) / total
        along = [k * 0.1 for k in (-17, -15, -13, -11, 11, 13, 15, 17)]
        return (s + sum(middle(lambda d: blue(s + d, t + a)) for a in along) / len(along),
                t + sum(middle(lambda d: blue(s + a, t + d)) for a in along) / len(along))

    def test_landmarks_of_the_mask_come_to_lie_in_their_places(self):
        out = self.printed("mask", "--set", f"print.dpi={DPI}", "--set", "print.marks=false")
        report = json.loads((out / "report.json").read_text())
        self.assertTrue(report["forming"]["converged"])
        self.assertLess(report["pattern"]["colours"]["faded_share"], 0.1)
        self.assertNotIn("undercuts", [w["code"] for w in report["warnings"]])
        sheet, rows = formed_sheet(out / "formed.ply"), pixels((out / "print.png").read_bytes())
        for label, (x, y) in MASK.items():
            s, t = sheet_point_above(*sheet, x, y)
            found = self.centre_of_cross(rows, s, t)
            self.assertLess(((found[0] - s) ** 2 + (found[1] - t) ** 2) ** 0.5, 0.1, label)  # mm; a pixel is 0.127

    def test_a_mask_compressed_by_draco_is_printed_like_the_mask(self):
        # Rounding errors of the places, without the ink: compensation multiplies differences of colour by the area ratio.
        plainly = ("--preview", "--set", "print.marks=false", "--set", "print.compensate_colours=false")
        plain = self.printed("mask", *plainly)
        compressed, out = self.folder / "compressed.glb", self.folder / "compressed"
        subprocess.run(["draco_transcoder", "-i", self.folder / "mask.glb", "-o", compressed, "-qp", "20", "-qt", "16"],
                       check=True, stdout=subprocess.DEVNULL)
        self.assertIn(b"KHR_draco_mesh_compression", compressed.read_bytes())
        done = vacuform("run", "--scan", compressed, "--set", "pattern.source=scan", "--out", out, *plainly)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [pixels((folder / "print.png").read_bytes()) for folder in (plain, out)]
        differences = sorted(max(abs(a - b) for a, b in zip(p, q)) for one, two in zip(*rows) for p, q in zip(one, two))
        self.assertLessEqual(differences[len(differences) * 99 // 100], 3)  # of 255

    def test_the_figurine_is_printed(self):
        out = self.printed("figurine", "--preview")
        colours = json.loads((out / "report.json").read_text())["pattern"]["colours"]
        self.assertGreater(colours["full_mm2"], 20000)
        reds = sum(1 for row in pixels((out / "print.png").read_bytes()) for r, g, b in row if r > 150 and g < 90 and b < 100)
        self.assertGreater(reds, 500)  # the scarf

    def test_an_unknown_model_is_refused(self):
        done = vacuform("sample", "--model", "hat", "--out", self.folder / "hat")
        self.assertEqual(done.returncode, 2)
        self.assertIn("--model: hat not in {head,mask,figurine}", done.stderr)


if __name__ == "__main__":
    unittest.main()
