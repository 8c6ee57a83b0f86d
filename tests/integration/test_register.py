"""The layers of a print lie on each other: crosses that are drawn at the same places on every layer are read back from print-*.svg
and mapped through the simulated forming."""
import collections
import itertools
import math
import re
import unittest
import xml.etree.ElementTree as ElementTree

from shapely.geometry import LineString

import made_scans
import meshes
from harness import Case, vacuform
from test_own_layers import FAST, group, svg
from test_random_drawings import SVG, FormedSheet, points_of

LAYERS = {"conductor outer": "print", "dielectric outer": "print-dielectric", "bridges outer": "print-bridges", "resist outer": "print-resist",
          "picture outer": "print-picture", "conductor inner": "print-reverse", "dielectric inner": "print-reverse-dielectric",
          "resist inner": "print-reverse-resist"}
# Without a symmetry, y down on a page of 170 x 120 mm; the first lies in the middle of a loop.
PLACES = [(66, 71), (22, 18), (140, 31), (101, 99), (36, 102), (150, 78), (88, 22)]
ARM, WIDTH = 2.5, 1
REGISTER = 0.02


def cross(at):
    x, y = at
    return (f'<path d="M{x - ARM} {y}H{x + ARM}" stroke="#000" stroke-width="{WIDTH}"/>'
            f'<path d="M{x} {y - ARM}V{y + ARM}" stroke="#000" stroke-width="{WIDTH}"/>')


def crosses(path):
    """Of each place that is printed: where the middle lines of the two arms of its cross meet, in sheet coordinates."""
    pattern = next(g for g in ElementTree.parse(path).getroot().iter(SVG + "g") if g.get("id") == "pattern")
    lines = [LineString(points_of(line.get("d"))) for line in pattern.iter(SVG + "path") if line.get("class") == "centreline"]
    arms = [line for line in lines if line.length < 3 * ARM]
    met = [a.intersection(b) for a, b in itertools.combinations(arms, 2) if a.intersects(b)]
    return [(p.x, p.y) for p in met]


class Register(Case):
    def test_layers_of_both_faces_lie_on_each_other(self):
        loop = '<circle cx="66" cy="71" r="20" fill="none" stroke="#000" stroke-width="3"/>'
        body = "".join(map(cross, PLACES)) + cross((66, 60)) + cross((80, 71))
        text = svg(*(group(name, body + (loop if name == "conductor outer" else "")) for name in LAYERS))
        (self.folder / "crosses.svg").write_text(text)
        for inked in "outer", "inner":
            with self.subTest(inked=inked):
                out = self.folder / inked
                done = vacuform("run", "--scan", made_scans.adult(), "--pattern", self.folder / "crosses.svg", *FAST, "--cache", self.folder / "cache",
                                "--set", f"pattern.inked_face={inked}", "--set", "sheet.thickness_mm=1", "--out", out)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.check_register(out, inked)
                self.check_marks(out)

    def check_register(self, out, inked):
        ply = meshes.Ply((out / "formed.ply").read_bytes())
        sheet = FormedSheet(ply)
        swapped = {"print": "print-reverse", "print-reverse": "print"}
        places = collections.defaultdict(list)  # on the outer face, by the file
        for label, name in LAYERS.items():
            if inked == "inner":
                name = re.sub("^print(-reverse)?", lambda m: swapped[m[0]], name)
            # The outer face lies on the inner one, by the thickness: there the two are compared.
            found = crosses(out / f"{name}.svg")
            self.assertEqual(len(found), len(PLACES) + 2, name)
            places[label] = [sheet.place(x, -y) for x, y in found]
        worst = 0
        for one, other in itertools.combinations(places, 2):
            for p in places[one]:
                worst = max(worst, min(math.dist(p, q) for q in places[other]))
        print(f"register of {inked}: {worst:.4f} mm")
        self.assertLess(worst, REGISTER)

    def check_marks(self, out):
        """All pages of a face have the same marks, and those of the other face lie on them through the sheet."""
        def marks(path):
            groups = [g for g in ElementTree.parse(path).getroot().iter(SVG + "g") if g.get("id", "").startswith("mark-")]
            return {g.get("id"): ElementTree.tostring(g) for g in groups}

        pages = {path.stem: marks(path) for path in out.glob("print*.svg")}
        for face in "print", "print-reverse":
            for name, page in pages.items():
                if name.startswith("print-reverse") == (face == "print-reverse"):
                    for mark in set(pages[face]) - {"mark-legend", "mark-gap-numbers"}:
                        self.assertEqual(page[mark], pages[face][mark], (name, mark))


if __name__ == "__main__":
    unittest.main()
