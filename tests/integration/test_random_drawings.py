"""One millimetre of a drawing is one millimetre on the part, whatever the drawing: random ones are printed on two heads, and the
length of every line on the formed sheet is read from formed.ply and print.svg by a reader of its own. Where a line is wrong by
more than the limit, a warning says so.

    VACUFORM_DRAWINGS=200 test_random_drawings.py
"""
import collections
import json
import math
import os
import re
import unittest
import xml.etree.ElementTree as ElementTree

import made_scans
import meshes
from drawing_generator import Generator
from harness import Case, vacuform

DRAWINGS = int(os.environ.get("VACUFORM_DRAWINGS", "24"))
LIMIT = 0.02  # pattern.length_limit
OFF = {"length-off", "length-far-off"}  # say that lines are not as long as drawn
# Not all of them is there, or, for the text in it, as a picture.
CUT = {"coil-cut", "coil-left-out", "coil-off-head", "ink-off-chart", "pattern-as-picture"}
SVG = "{http://www.w3.org/2000/svg}"


class FormedSheet:
    """Where a point of the flat sheet lies on the outer face of the formed one."""

    CELL = 4

    def __init__(self, ply):
        self.flat = list(zip(ply.vertices["s"], ply.vertices["t"]))
        normals = meshes.vertex_normals(ply.points, ply.faces)
        self.solid = [tuple(p + thickness * n for p, n in zip(point, normal))
                      for point, normal, thickness in zip(ply.points, normals, ply.vertices["thickness"])]
        self.cells = {}
        for face in ply.faces:
            corners = [self.flat[v] for v in face]
            low, high = ([math.floor(f(c[k] for c in corners) / self.CELL) for k in (0, 1)] for f in (min, max))
            for i in range(low[0], high[0] + 1):
                for j in range(low[1], high[1] + 1):
                    self.cells.setdefault((i, j), []).append(face)

    def place(self, x, y):
        best, least = None, -1e-4
        for face in self.cells.get((math.floor(x / self.CELL), math.floor(y / self.CELL)), []):
            (ax, ay), (bx, by), (cx, cy) = (self.flat[v] for v in face)
            whole = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
            b = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / whole
            c = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / whole
            if min(1 - b - c, b, c) > least:
                best, least = (face, (1 - b - c, b, c)), min(1 - b - c, b, c)
        assert best, f"({x}, {y}) lies off the sheet"
        face, weights = best
        return tuple(sum(w * self.solid[v][k] for v, w in zip(face, weights)) for k in range(3))

    def length(self, line):
        places = [self.place(x, -y) for x, y in line]
        return sum(math.dist(a, b) for a, b in zip(places, places[1:]))


def points_of(d, chords=8):
    """The polyline of a path of M, L, C and Z."""
    line, start = [], None
    words = re.findall(r"[MLCZ]|-?[\d.]+", d)
    command, at = None, 0
    while at < len(words):
        if words[at] in "MLCZ":
            command, at = words[at], at + 1
            if command == "Z":
                line += fine(line[-1], start)
                continue
        count = {"M": 2, "L": 2, "C": 6}[command]
        n = [float(word) for word in words[at:at + count]]
        at += count
        if command == "M":
            start = (n[0], n[1])
            line, command = [start], "L"
        elif command == "L":
            line += fine(line[-1], (n[0], n[1]))
        else:
            p, a, b, q = line[-1], n[0:2], n[2:4], n[4:6]
            for i in range(1, chords + 1):
                t = i / chords
                line.append(tuple((1 - t) ** 3 * p[k] + 3 * t * (1 - t) ** 2 * a[k] + 3 * t * t * (1 - t) * b[k] + t ** 3 * q[k] for k in (0, 1)))
    return line


def fine(a, b):
    parts = max(1, math.ceil(math.dist(a, b)))
    return [tuple(a[k] + (b[k] - a[k]) * i / parts for k in (0, 1)) for i in range(1, parts + 1)]


def printed_lines(svg):
    """By id of its group: the centre lines of the print."""
    out = []
    for group in ElementTree.fromstring(svg).iter(SVG + "g"):
        for path in group.findall(SVG + "path"):
            if path.get("class") == "centreline":
                out.append((group.get("id"), points_of(path.get("d"))))
    return out


class RandomDrawings(Case):
    def check(self, heads):
        generator = Generator(1)
        worst, worst_number, said = 0, 0, collections.Counter()
        for number in range(DRAWINGS):
            head, most_mm = heads[number % len(heads)]
            drawing = generator.drawing(most_mm)
            with self.subTest(number=number, head=head.name):
                pattern, out = self.folder / "pattern.svg", self.folder / "out"
                pattern.write_text(drawing.svg)
                done = vacuform("run", "--scan", head, "--pattern", pattern, "--preview", "--cache", self.folder / "cache", "--out", out)
                self.assertEqual(done.returncode, 0, done.stderr)
                report = json.loads((out / "report.json").read_text())
                self.assertEqual(report["pattern"]["format"], "SVG")
                for got, meant in zip(report["pattern"]["size_mm"], (generator.width_mm, generator.height_mm)):
                    self.assertAlmostEqual(got, meant, delta=0.01)
                codes = {warning["code"] for warning in report["warnings"]}
                said.update(codes & (OFF | CUT))
                if codes & CUT:
                    continue
                sheet = FormedSheet(meshes.Ply((out / "formed.ply").read_bytes()))
                printed = printed_lines((out / "print.svg").read_text())
                self.assertEqual(len(printed), len(drawing.lengths))
                pairs = self.pairs([(name, sheet.length(line)) for name, line in printed], drawing)
                off = max(abs(formed / drawn - 1) for formed, drawn in pairs)
                if not codes & OFF:
                    self.assertLessEqual(off, LIMIT + 0.002, pairs)
                # What the report calls the worst piece of a line is no better than the worst line.
                self.assertLess(off, abs(report["pattern"]["lengths"]["worst_error"]) + 0.003)
                worst, worst_number = max((worst, worst_number), (off, number))
        print(f"{DRAWINGS} drawings: warnings {dict(said)}; lines off by {100 * worst:.2f} % at worst, in number {worst_number}", flush=True)

    def pairs(self, formed, drawing):
        """(formed, drawn) lengths that belong together: of a coil with an id its own, in the order of their lengths."""
        if not drawing.ids:
            return list(zip(sorted(length for _, length in formed), sorted(drawing.lengths)))
        out = []
        for name, drawn in drawing.ids.items():
            own = sorted(length for label, length in formed if label == name)
            self.assertEqual(len(own), len(drawn), name)
            out += zip(own, sorted(drawn))
        return out

    def test_lines_are_as_long_as_they_are_drawn_or_a_warning_says_so(self):
        self.check([(made_scans.adult(), 150), (made_scans.newborn(), 90)])


if __name__ == "__main__":
    unittest.main()
