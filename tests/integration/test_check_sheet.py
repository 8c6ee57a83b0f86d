"""The second opinion on formed sheets finds what it is there to find: a sound sheet passes, each damaged one does not."""
import json
import math
import struct
import subprocess
import unittest

import meshes
import scan_shapes
from harness import BIN, Case

GRID, SIDE, RADIUS, THICKNESS = 2.0, 120, 30.0, 1.0
MOLD = meshes.hemisphere(RADIUS, 24, 96)
FREE, ON_MOLD, ON_PLATFORM, IN_CLAMP = range(4)


def dome(s, t):
    """Where a flat point goes: the part over the mold onto the half ball, the rest onto the platform, close to the foot."""
    r = math.hypot(s, t)
    if r == 0:
        return 0.0, 0.0, RADIUS
    reach, foot = 38.0, RADIUS + 1
    if r <= reach:
        angle = r / reach * math.pi / 2
        out, z = RADIUS * math.sin(angle), RADIUS * math.cos(angle)
    else:
        out, z = foot + (r - reach) * (SIDE / 2 * math.sqrt(2) - foot) / (SIDE / 2 * math.sqrt(2) - reach), 0.0
    return out * s / r, out * t / r, z


class Sheet:
    """A formed sheet that lies on the half ball; the tests damage it before it is written."""

    def __init__(self, place=dome):
        n = round(SIDE / GRID)
        self.rest = [(GRID * i - SIDE / 2, GRID * j - SIDE / 2) for j in range(n + 1) for i in range(n + 1)]
        self.points = [place(*p) for p in self.rest]
        self.faces = []
        for j in range(n):
            for i in range(n):
                a, b, c, d = (k * (n + 1) + m for k, m in ((j, i), (j, i + 1), (j + 1, i + 1), (j + 1, i)))
                self.faces += [(a, b, c), (a, c, d)]
        self.contact = [IN_CLAMP if max(map(abs, p)) > SIDE / 2 - 1 else ON_MOLD if q[2] > 0 else ON_PLATFORM
                        for p, q in zip(self.rest, self.points)]
        self.warnings, self.penetration, self.thickness_factor = [], 0.0, 1.0

    def thicknesses(self):
        before, after = [0.0] * len(self.rest), [0.0] * len(self.rest)
        for face in self.faces:
            flat = meshes.flat_area(*(self.rest[v] for v in face))
            formed = meshes.area(*(self.points[v] for v in face))
            for v in face:
                before[v] += flat
                after[v] += formed
        return [THICKNESS * self.thickness_factor * b / a if a else 0.0 for b, a in zip(before, after)]

    def write(self, folder):
        folder.mkdir()
        names = ("x", "y", "z", "s", "t", "u", "v", "thickness", "temperature")
        head = "ply\nformat binary_little_endian 1.0\n" + f"element vertex {len(self.points)}\n"
        head += "".join(f"property float {name}\n" for name in names)
        head += f"property uchar contact\nelement face {len(self.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
        rows = zip(self.points, self.rest, self.thicknesses(), self.contact)
        body = b"".join(struct.pack("<9fB", *p, *q, math.nan, math.nan, h, 140, c) for p, q, h, c in rows)
        body += b"".join(struct.pack("<B3i", 3, *face) for face in self.faces)
        (folder / "formed.ply").write_bytes(head.encode() + body)
        (folder / "mold.stl").write_bytes(meshes.stl(MOLD))
        report = {"settings": {"sheet": {"resolution_mm": GRID, "thickness_mm": THICKNESS},
                               "machine": {"drape_height_mm": 0}},
                  "forming": {"penetration_mm": {"max": self.penetration}}, "warnings": self.warnings}
        (folder / "report.json").write_text(json.dumps(report))


class CheckSheet(Case):
    def check(self, sheet):
        """The exit code, and the kinds of the places that no warning marks and of those that one does."""
        folder = self.folder / self.id()
        while folder.exists():
            folder = folder.with_name(folder.name + "-")
        sheet.write(folder)
        done = subprocess.run([BIN / "check_sheet", folder], capture_output=True, text=True, timeout=60)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        places = json.loads(done.stdout)["places"]
        return (done.returncode, {p["kind"] for p in places if not p["marked_by"]},
                {p["kind"] for p in places if p["marked_by"]})

    def warning(self, code, place, size=1.0):
        return {"code": code, "marks": [{"place_mm": list(place), "size_mm": size}]}

    def test_sound_sheet_passes(self):
        self.assertEqual(self.check(Sheet()), (0, set(), set()))

    def test_finds_a_hole(self):
        sheet = Sheet()
        del sheet.faces[len(sheet.faces) // 2]
        self.assertEqual(self.check(sheet), (1, {"torn"}, set()))

    def test_finds_a_crack(self):
        """The two sides of a slit are at one place of the flat sheet and at two of the formed one."""
        sheet = Sheet()
        middle = len(sheet.points) // 2
        x, y, z = sheet.points[middle]
        for values, value in ((sheet.rest, sheet.rest[middle]), (sheet.points, (x, y, z + 0.4)), (sheet.contact, ON_MOLD)):
            values.append(value)
        half = [k for k, face in enumerate(sheet.faces) if middle in face][:3]
        for k in half:
            sheet.faces[k] = tuple(len(sheet.points) - 1 if v == middle else v for v in sheet.faces[k])
        self.assertEqual(self.check(sheet)[1], {"torn"})

    def test_finds_stretch_beyond_the_plastic(self):
        def pulled(s, t):  # all plastic of the dome's side comes from a ring of 4 mm
            r = math.hypot(s, t)
            return dome(s, t) if r == 0 else dome(s * bent(r) / r, t * bent(r) / r)

        def bent(r):
            if r <= 20:
                return r / 4
            return 5 + (r - 20) * 8 if r <= 24 else 37 + (r - 24) * (SIDE / math.sqrt(2) - 37) / (SIDE / math.sqrt(2) - 24)
        sheet = Sheet(pulled)
        exit_code, unmarked, _ = self.check(sheet)
        self.assertEqual(exit_code, 1)
        self.assertIn("torn", unmarked)
        marked = Sheet(pulled)
        marked.warnings = [self.warning("thin", (0, 0, RADIUS), 2 * RADIUS)]
        self.assertNotIn("torn", self.check(marked)[1])

    def test_finds_a_mold_that_stands_out(self):
        sheet = Sheet(lambda s, t: (*dome(s, t)[:2], min(dome(s, t)[2], RADIUS - 2)))
        sheet.penetration = 2.0
        exit_code, unmarked, _ = self.check(sheet)
        self.assertEqual((exit_code, "penetrated" in unmarked), (1, True))
        sheet.warnings = [self.warning("pierced", (0, 0, RADIUS), 30)]
        self.assertNotIn("penetrated", self.check(sheet)[1])
        sheet.warnings = [self.warning("pierced", (0, -RADIUS, 0), 1)]  # a mark at another place does not count
        self.assertIn("penetrated", self.check(sheet)[1])

    def test_finds_a_report_that_plays_penetration_down(self):
        sheet = Sheet(lambda s, t: (*dome(s, t)[:2], min(dome(s, t)[2], RADIUS - 2)))
        sheet.penetration = 0.4
        self.assertIn("misreported", self.check(sheet)[1])

    def test_finds_contact_that_is_none(self):
        def lifted(s, t):
            x, y, z = dome(s, t)
            return (x * 1.05, y * 1.05, z + 1.5) if z > 5 else (x, y, z)
        self.assertIn("off the mold", self.check(Sheet(lifted))[1])

    def test_finds_a_sheet_that_floats(self):
        sheet = Sheet(lambda s, t: (s, t, 2 * RADIUS * max(0.0, 1 - math.hypot(s, t) / (SIDE / 2))))
        sheet.contact = [c if c == IN_CLAMP else FREE for c in sheet.contact]
        exit_code, unmarked, _ = self.check(sheet)
        self.assertEqual((exit_code, unmarked), (1, {"off the mold"}))
        sheet.warnings = [self.warning("not-reached", (0, 0, 2 * RADIUS), 5 * RADIUS)]
        self.assertEqual(self.check(sheet), (0, set(), {"off the mold"}))

    def test_finds_a_fold(self):
        def folded(s, t):
            x, y, z = dome(s, t)
            return (2 * 46 - x, y, 0.3) if 46 < s < 50 and abs(t) < 20 else (x, y, z)
        self.assertIn("folded", self.check(Sheet(folded))[1])

    def test_finds_thickness_out_of_nothing(self):
        sheet = Sheet()
        sheet.thickness_factor = 1.2
        self.assertEqual(self.check(sheet), (1, {"misreported"}, set()))

    def test_refuses_a_folder_without_a_sheet(self):
        done = subprocess.run([BIN / "check_sheet", self.folder], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertIn("formed.ply", done.stderr)


class Bodies(unittest.TestCase):
    """The made-up bodies are what they are said to be."""

    def test_are_closed_and_face_outwards(self):
        import random
        for name, make in scan_shapes.KINDS.items():
            vertices, triangles = make(random.Random(name))
            corners = [tuple(vertices[v] for v in t) for t in triangles]
            self.assertTrue(meshes.edges_closed(corners), name)
            volume = sum(meshes.dot(a, meshes.cross(b, c)) for a, b, c in corners) / 6
            self.assertGreater(volume, 0, name)
            self.assertAlmostEqual(min(p[2] for p in vertices), 0, delta=0.2)


if __name__ == "__main__":
    unittest.main()
