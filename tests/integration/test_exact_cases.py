"""Forming against exact solutions, from a mold as STL to formed.ply: molds of known shape, read back without Vacuform's code.

A female mold is a block with a pit: the frame stops at its top, the sheet lies on the land around the pit and sticks there,
and the vacuum draws it in. The sheet is thin, so that the pressure of a vacuum presses it far into a corner; thickness is
compared as a ratio. Grid lines run along the rims, so that the free span of the sheet is the pit's.
"""
import json
import math
import unittest

import meshes
from harness import PATIENCE, Case, vacuform

DOT = ('<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="20mm" viewBox="-10 -10 20 20">'
       '<circle r="6" fill="none" stroke="black"/></svg>')
LAND, GAP, FLOOR = 4, 8, 21  # mm: around a pit, from there to the frame, and at least under a pit
IDEAL = {"thin_limit": 0, "law": "neo_hookean"}  # as the tables have it; the thin sheet around the block would tear
INSIDE = 0.01  # mm that a rim lies inside the grid line, so that the line's vertices lie on the land


class Formed:
    """The formed sheet of one run, and its report."""

    def __init__(self, folder, mold, **groups):
        folder.mkdir()
        (folder / "mold.stl").write_bytes(meshes.stl(mold))
        (folder / "pattern.svg").write_text(DOT)
        settings = {"scan": {"units": "mm", "up": "+z"}, "print": {"dpi": 72, "marks": False}, **groups}
        (folder / "settings.json").write_text(json.dumps(settings))
        done = vacuform("run", "--scan", folder / "mold.stl", "--pattern", folder / "pattern.svg",
                        "--settings", folder / "settings.json", "--out", folder / "out", patience=3 * PATIENCE)  # on fine grids
        assert done.returncode == 0, done.stderr
        self.report = json.loads((folder / "out/report.json").read_text())
        self.ply = meshes.Ply((folder / "out/formed.ply").read_bytes())
        self.points, self.faces, self.vertices = self.ply.points, self.ply.faces, self.ply.vertices
        self.rest = list(zip(self.vertices["s"], self.vertices["t"]))
        self.initial = self.report["settings"]["sheet"]["thickness_mm"]

    def triangles(self, within_s, within_t):
        """Rest area, corners in space and contacts of the triangles in the middle of the sheet."""
        for face in self.faces:
            rest = [self.rest[i] for i in face]
            if all(abs(s) <= within_s + 1e-6 and abs(t) <= within_t for s, t in rest):
                yield meshes.flat_area(*rest), [self.points[i] for i in face], [self.vertices["contact"][i] for i in face]

    def crossings(self, measure, value):
        """Where edges of the sheet that lies on the mold cross a level of measure(point): (landing radius, h/h0)."""
        at = [measure(p) for p in self.points]
        thickness, contact = self.vertices["thickness"], self.vertices["contact"]
        for face in self.faces:
            for i, j in zip(face, face[1:] + face[:1]):
                if contact[i] == contact[j] == 1 and (at[i] - value) * (at[j] - value) < 0:
                    w = (value - at[i]) / (at[j] - at[i])
                    yield ((1 - w) * math.hypot(*self.rest[i]) + w * math.hypot(*self.rest[j]),
                           ((1 - w) * thickness[i] + w * thickness[j]) / self.initial)


def mean(values):
    values = list(values)
    return sum(values) / len(values)


def frame(width, height, top, resolution, thickness, **more):
    """Settings of a rectangular frame that stops where a female mold has its top."""
    return {"sheet": {"width_mm": width, "height_mm": height, "resolution_mm": resolution, "thickness_mm": thickness},
            "machine": {"window_width_mm": width, "window_height_mm": height, "drape_height_mm": round(top - 0.01, 4), **more}}


class Groove(Case):
    """Plane strain: the middle of a groove that is much longer than wide, up to fifteen times where it is steep, or its ends tell.

    Any isotropic law gives the same.
    """
    half_width = 16

    def form(self, depth, length, floor_half_width=0.0, floor=FLOOR, resolution=1, thickness=1, law="neo_hookean", **machine):
        mold = meshes.groove(self.half_width - INSIDE, depth, length, LAND, floor_half_width, floor)
        width, height = 2 * (self.half_width + LAND + GAP), length + 2 * (LAND + GAP)
        return Formed(self.folder / self.id().rpartition(".")[2], mold, forming={**IDEAL, "law": law},
                      **frame(width, height, floor + depth, resolution, thickness, **machine))

    def check_wedge(self, degrees, deepest, length=240, resolution=2, **form):
        """h/h0 = (sin a / a) (1 - S/T)^(tan a / a - 1), by bands of S/T, each held to the mean of the formula over it."""
        a = math.radians(degrees)
        depth = (self.half_width - INSIDE) * math.tan(a)
        formed = self.form(depth, length, resolution=resolution, thickness=0.1, **form)
        bands = {}
        for rest, corners, contacts in formed.triangles(self.half_width, 10):
            if set(contacts) == {1}:
                share = (FLOOR + depth - mean(p[2] for p in corners)) / depth
                area = meshes.area(*corners)
                band = bands.setdefault(int(10 * share), [0, 0])
                band[0] += rest
                band[1] += area * math.sin(a) / a * (1 - share) ** (math.tan(a) / a - 1)
        for k in range(int(10 * deepest)):
            with self.subTest(f"S/T {k / 10} to {k / 10 + .1}"):
                self.assertAlmostEqual(bands[k][0] / bands[k][1], 1, delta=0.005)

    def test_wedge_of_30_degrees(self):
        self.check_wedge(30, 0.9, length=120, resolution=1)

    # On 2 mm a cell at S/T 0.5 is stretched to a tenth of the wall.
    def test_wedge_of_45_degrees(self):
        self.check_wedge(45, 0.5)

    def test_wedge_of_52_degrees(self):
        self.check_wedge(52, 0.4)

    def test_wedge_of_60_degrees_mooney_rivlin(self):
        self.check_wedge(60, 0.4, law="mooney_rivlin")

    def check_strip(self, kilopascals, **form):
        """Free inflation to the half angle f: p w / (mu h0) = sin f (l - l^-3), l = f / sin f, H/w = (1 - cos f) / sin f."""
        w, thickness = self.half_width, 0.8
        formed = self.form(30, 260, floor_half_width=w - INSIDE, thickness=thickness, vacuum_kpa=kilopascals, **form)
        forming = formed.report["forming"]
        wanted = forming["pressure_kpa"] * w / (forming["shear_modulus_kpa"] * thickness)
        low, high = 0.01, math.pi / 2
        while high - low > 1e-9:
            f = (low + high) / 2
            low, high = (f, high) if math.sin(f) * (f / math.sin(f) - (math.sin(f) / f) ** 3) < wanted else (low, f)
        self.assertGreater(f, 0.7)
        middle = list(formed.triangles(w, 5))
        stretch = sum(meshes.area(*corners) for _, corners, _ in middle) / sum(rest for rest, _, _ in middle)
        self.assertAlmostEqual(stretch / (f / math.sin(f)), 1, delta=0.005)
        lowest = min(p[2] for _, corners, _ in middle for p in corners)
        self.assertAlmostEqual((FLOOR + 30 - lowest) / (w * (1 - math.cos(f)) / math.sin(f)), 1, delta=0.005)

    def test_strip_little_inflated(self):
        self.check_strip(4)  # 45 degrees

    def test_strip_much_inflated_mooney_rivlin(self):
        self.check_strip(14, law="mooney_rivlin")  # 75 degrees


class Cone(Case):
    def test_female_cone_of_60_degrees(self):
        """Converged: S/T, landing radius over the rim's, h/h0 (neo-Hookean)."""
        radius, depth = 40, 40 * math.tan(math.radians(60))
        width = 2 * (radius + LAND + GAP)
        formed = Formed(self.folder / "cone", meshes.female_cone(radius, 60, LAND, FLOOR),
                        forming=IDEAL, **frame(width, width, FLOOR + depth, 1, 0.1))
        for place, landing, thickness in [(.02, .9659, .8367), (.10, .8331, .7509), (.25, .6010, .5888),
                                          (.50, .2767, .3011), (.75, .0695, .0765)]:
            with self.subTest(f"S/T {place}"):
                level = FLOOR + depth * (1 - place)
                found = list(formed.crossings(lambda p: p[2] if math.hypot(p[0], p[1]) < radius + 1 else math.inf, level))
                self.assertGreater(len(found), 50)
                self.assertAlmostEqual(mean(r for r, _ in found), landing * radius, delta=0.3)
                self.assertAlmostEqual(mean(h for _, h in found) / thickness, 1, delta=0.02)


class Hemisphere(Case):
    # Polar angle in degrees, landing radius over R, h/h0 (neo-Hookean): ring of 1.5 R lowered to the platform, then vacuum.
    reference = [(15, .2594, .974), (30, .5032, .885), (45, .7132, .719), (60, .8913, .698), (75, 1.0618, .668), (85, 1.1586, .560)]

    def test_lands_and_thins_as_the_reference(self):
        radius = 85
        formed = Formed(self.folder / "hemisphere", meshes.hemisphere(radius, 90, 180), forming=IDEAL,
                        sheet={"width_mm": 265, "height_mm": 265},
                        machine={"window": "circle", "window_width_mm": 3 * radius})
        for polar, landing, thickness in self.reference:
            with self.subTest(f"{polar} degrees"):
                found = list(formed.crossings(lambda p: math.degrees(math.atan2(math.hypot(p[0], p[1]), p[2])), polar))
                self.assertGreater(len(found), 50)
                for landed, _ in found:
                    self.assertAlmostEqual(landed, landing * radius, delta=0.5)
                self.assertAlmostEqual(mean(h for _, h in found) / thickness, 1, delta=0.01)


if __name__ == "__main__":
    unittest.main()
