"""Front is front, left is left: a head with a nose, one ear and a letter on its crown, in all 24 poses of a file and mirrored,
through the command line and the service; and where its nose, ear and letter are in every picture and file."""
import json
import math
import re
import struct
import unittest

import meshes
import scan_files
import sided_head
from harness import Case, Server, curl, vacuform
from png_rows import rgb_rows

CAPTION_TOP, TILE_WIDTH, TILE_HEIGHT, TILE_LABEL = 104, 500, 400, 34
TILES = ["front", "back", "minus_x", "plus_x", "above"]
PIXEL = {"red": lambda r, g, b: r > 1.25 * g and r > 1.25 * b, "green": lambda r, g, b: g > 1.12 * r and g > 1.12 * b,
         "blue": lambda r, g, b: b > 1.7 * r and b > 1.7 * g and b > 60}


def shape(mold):
    """Extent, middle and skewness of a mold along x and y: no two poses of the head have the same."""
    points = [p for triangle in meshes.read_stl(mold) for p in triangle]
    out = []
    for axis in range(3):
        values = [p[axis] for p in points]
        mean = sum(values) / len(values)
        out += [min(values), max(values), 0.02 * mean, 0.1 * math.copysign(abs(sum((v - mean) ** 3 for v in values) / len(values)) ** (1 / 3), 1)]
    return out


def flags(settings):
    return [word for key, value in settings.items() for word in ("--set", f"scan.{key}={value}")]


def found(rows, box, wanted):
    """How many pixels of a colour are in a box of a picture, their mean place and their box."""
    left, top, right, bottom = box
    places = []
    for y in range(top, bottom):
        row = rows[y]
        places += [(x - left, y - top) for x in range(left, right) if wanted(*row[3 * x:3 * x + 3])]
    if not places:
        return 0, None, None
    xs, ys = [p[0] for p in places], [p[1] for p in places]
    return len(places), (sum(xs) / len(xs), sum(ys) / len(ys)), (min(xs), min(ys), max(xs), max(ys))


def tile(index, columns=2):
    left, top = index % columns * TILE_WIDTH, CAPTION_TOP + index // columns * TILE_HEIGHT
    return left, top + TILE_LABEL, left + TILE_WIDTH, top + TILE_HEIGHT


IDENTITY = sided_head.FRONT["+y"]
ODD = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]  # the crown at +x of the file, the face at -z, the left at +y


class Poses(Case):
    def inspected(self, pose, mirrored, name):
        scan, out = self.folder / (name + ".stl"), self.folder / name
        scan.write_bytes(scan_files.stl(sided_head.turned(pose, mirrored)))
        settings = sided_head.settings_for(pose, mirrored)
        done = vacuform("inspect", scan, *flags(settings), "--set", "scan.left_side=minus_x", "--set", "scan.trim_mm=10", "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        return out, settings

    def test_every_pose_of_a_file_makes_the_same_mold(self):
        out, _ = self.inspected(IDENTITY, False, "reference")
        reference = shape((out / "mold.stl").read_bytes())
        picture = rgb_rows((out / "preview-findings.png").read_bytes())
        # The nose is towards +y, the ear towards -x.
        self.assertGreater(reference[5], 90)
        self.assertGreater(-reference[0], reference[1] - 1)
        for mirrored in False, True:
            for i, pose in enumerate(sided_head.poses()):
                with self.subTest(pose=pose, mirrored=mirrored):
                    out, settings = self.inspected(pose, mirrored, f"pose-{mirrored}-{i}")
                    for value, expected in zip(shape((out / "mold.stl").read_bytes()), reference):
                        self.assertAlmostEqual(value, expected, delta=0.1)
                    findings = json.loads((out / "findings.json").read_text())
                    self.assertEqual((findings["scan"]["up"], findings["scan"]["front"], findings["scan"]["left_side"]),
                                     (settings["up"], settings["front"], "minus_x"))
                    self.assertFalse({"side-unconfirmed", "mirrored-or-turned"} & {w["code"] for w in findings["warnings"]})
        self.assertEqual(len(picture[0]), 3000)

    def test_without_an_answer_the_sides_are_asked_about(self):
        scan = self.folder / "asked.stl"
        scan.write_bytes(scan_files.stl(sided_head.turned(IDENTITY)))
        for left, front, code in (("unknown", "auto", "side-unconfirmed"), ("unknown", "+y", "side-unconfirmed"),
                                  ("plus_x", "auto", "mirrored-or-turned"), ("plus_x", "+y", "mirrored-or-turned")):
            out = self.folder / f"asked-{left}-{front}"
            done = vacuform("inspect", scan, "--set", f"scan.left_side={left}", "--set", f"scan.front={front}", "--set", "scan.trim_mm=10", "--out", out)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(code, [w["code"] for w in json.loads((out / "findings.json").read_text())["warnings"]])

    def test_a_yaw_may_not_turn_a_known_face_away(self):
        scan = self.folder / "yaw.stl"
        scan.write_bytes(scan_files.stl(sided_head.turned(IDENTITY)))
        done = vacuform("inspect", scan, "--set", "scan.front=+y", "--set", "scan.yaw_deg=90")
        self.assertEqual(done.returncode, 2)
        self.assertIn("scan.yaw_deg", done.stderr)
        self.assertIn("another scan.front", done.stderr)


class Pictures(Case):
    """One head, sent turned and mirrored through the service, printed with its colours."""
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = cls.enterClass(Server(cls.folder, workers=1))
        cls.artifacts = {}
        for name, pose, mirrored, face in ("straight", IDENTITY, False, "outer"), ("turned", ODD, True, "inner"):
            scan = cls.folder / (name + ".ply")
            scan.write_bytes(sided_head.painted_ply(pose, mirrored))
            settings = {"scan": {**sided_head.settings_for(pose, mirrored), "left_side": "minus_x", "trim_mm": 10},
                        "sheet": {"resolution_mm": 4}, "print": {"dpi": 72}, "pattern": {"source": "scan", "inked_face": face}}
            answer = curl("-F", f"scan=@{scan}", "-F", f"settings={json.dumps(settings)}", cls.server.api + "/jobs")
            assert answer.status == 202, answer
            job = cls.server.wait(answer.json["id"])
            assert job["state"] == "succeeded", job["problem"]
            cls.artifacts[name] = {a["name"]: curl(f"{cls.server.api}/jobs/{job['id']}/artifacts/{a['name']}").body for a in job["artifacts"]}

    def check_tiles(self, rows, index_of):
        middle = TILE_WIDTH / 2
        seen = {(side, hue): found(rows, index_of(i), PIXEL[hue]) for i, side in enumerate(TILES) for hue in PIXEL}
        self.assertGreater(seen["front", "red"][0], 200)
        self.assertLess(abs(seen["front", "red"][1][0] - middle), 25)
        self.assertGreater(seen["front", "green"][0], 20)
        self.assertGreater(seen["front", "green"][1][0], middle + 100)  # seen from the front, the left ear is on the right
        self.assertEqual(seen["back", "red"][0], 0)
        self.assertLess(seen["back", "green"][1][0], middle - 100)
        self.assertGreater(seen["minus_x", "green"][0], 200)
        self.assertLess(abs(seen["minus_x", "green"][1][0] - middle), 40)
        self.assertLess(seen["minus_x", "red"][1][0], middle - 100)  # the face is on the left
        self.assertEqual(seen["plus_x", "green"][0], 0)
        self.assertGreater(seen["plus_x", "red"][1][0], middle + 100)
        self.assertLess(seen["above", "red"][1][1], 120)
        self.assertLess(seen["above", "green"][1][0], middle - 60)
        x, y, *_ = index_of(TILES.index("above"))  # the letters of the sides are blue, too: only the middle counts
        count, mean, (left, top, right, bottom) = found(rows, (x + 190, y + 100, x + 330, y + 280), PIXEL["blue"])
        self.assertGreater(count, 100)
        self.assertLess(mean[0], (left + right) / 2 - 1)  # the F has its stroke on the left and its arms at the top
        self.assertLess(mean[1], (top + bottom) / 2 - 1)

    def test_the_views_show_the_side_that_they_name(self):
        for name, files in self.artifacts.items():
            with self.subTest(name):
                self.check_tiles(rgb_rows(files["preview-views.png"]), tile)
                original = rgb_rows(files["preview-original.png"])
                self.check_tiles(original, lambda i: tile(2 * i))
                self.check_tiles(original, lambda i: tile(2 * i + 1))

    def test_pictures_of_the_part_are_taken_from_its_front(self):
        for name, files in self.artifacts.items():
            with self.subTest(name):
                rows = rgb_rows(files["preview-with.png"])
                whole = (0, CAPTION_TOP, 1000, 900)
                count, mean, _ = found(rows, whole, PIXEL["red"])
                self.assertGreater(count, 200)
                self.assertGreater(mean[1], 500)  # the nose is below the crown, and the left ear on the right
                self.assertGreater(found(rows, whole, PIXEL["green"])[1][0], 500)

    def test_the_print_names_its_sides(self):
        for name, inner in ("straight", False), ("turned", True):
            svg = self.artifacts[name]["print.svg"].decode()
            places = {}
            for mark, x, y, letter in re.findall(r'id="mark-side-([a-z-]+)">\s*<text transform="translate\((-?[\d.]+),(-?[\d.]+)\)[^>]*>([^<]+)<', svg):
                places[letter] = (float(x), float(y))
            self.assertEqual(set(places), set("LRAP"))
            self.assertLess(places["A"][1], -130)  # y is down: +t, the front, is at the top
            self.assertGreater(places["P"][1], 120)
            self.assertEqual(places["L"][0] < 0, not inner)
            self.assertEqual(places["R"][0] > 0, not inner)

    def test_the_model_faces_the_front_of_gltf(self):
        for name, files in self.artifacts.items():
            with self.subTest(name):
                data = files["formed.glb"]
                size, = struct.unpack("<I", data[12:16])
                gltf = json.loads(data[20:20 + size])
                binary = data[28 + size:]
                matrix = gltf["nodes"][0]["matrix"]
                accessor = gltf["accessors"][gltf["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
                view = gltf["bufferViews"][accessor["bufferView"]]
                start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
                points = struct.unpack(f"<{3 * accessor['count']}f", binary[start:start + 12 * accessor["count"]])
                world = [[sum(matrix[4 * k + r] * points[3 * i + k] for k in range(3)) for r in range(3)] for i in range(accessor["count"])]
                # The nose is at +Z and the left ear at +X, since glTF has the right at -X: both are narrow, the other ends not.
                high = [p for p in world if p[1] > 0.012]

                def width(axis, sign, across, depth):
                    far = max(sign * p[axis] for p in high)
                    end = [p[across] for p in high if sign * p[axis] > far - depth]
                    return max(end) - min(end)
                self.assertLess(width(2, 1, 0, 0.006), 0.038)
                self.assertGreater(width(2, -1, 0, 0.006), 0.042)
                self.assertLess(width(0, 1, 2, 0.004), 0.038)
                self.assertGreater(width(0, -1, 2, 0.004), 0.042)


if __name__ == "__main__":
    unittest.main()
