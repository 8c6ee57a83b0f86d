"""A picture on a figurine in segments: the distortion of each is below its limit, seams meet on the print, cuts follow
the request; and a weight image for the distortion of the chart."""
import json
import math
import struct
import unittest
import zlib

import made_scans
import meshes
from harness import Case, vacuform


def gray_png(side, shade):
    """A square picture of 8-bit gray; `shade` of a point in [-1, 1] squared, y up."""
    rows = bytearray()
    for j in range(side):
        rows.append(0)
        rows += bytes(shade((2 * i + 1) / side - 1, 1 - (2 * j + 1) / side) for i in range(side))

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(bytes(rows))) + chunk(b"IEND", b""))


class Segments(Case):
    scan = staticmethod(lambda: (made_scans.figurine(), "--set", "scan.trim_mm=0"))

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        grid = cls.folder / "grid.png"
        grid.write_bytes(gray_png(400, lambda x, y: 0 if math.cos(40 * x) > 0.9 or math.cos(40 * y) > 0.9 else 255))
        dark = cls.folder / "dark.png"
        dark.write_bytes(gray_png(64, lambda x, y: 0 if math.hypot(x, y) < 0.4 else 255))
        cls.grid, cls.dark = grid, dark
        cls.whole = cls.made("whole", "--set", "pattern.placement=segments")

    @classmethod
    def asked(cls, name, *words):
        return vacuform("run", "--scan", *cls.scan(), "--pattern", cls.grid, "--out", cls.folder / name, "--cache",
                        cls.folder / "cache", "--set",
                        "sheet.resolution_mm=5", "--set", "print.dpi=72", "--set", "pattern.width_mm=150", *words)

    @classmethod
    def made(cls, name, *words):
        done = cls.asked(name, *words)
        assert done.returncode == 0, done.stderr
        return json.loads((cls.folder / name / "report.json").read_text())

    def test_all_below_the_limit_or_named(self):
        found = self.whole["segments"]
        self.assertEqual(found["count"], len(found["segments"]))
        self.assertGreater(found["count"], 3)
        above = [s for s in found["segments"] if s["distortion"] is None or s["distortion"] > 1.1]
        self.assertEqual(bool(above), "segment-distorted" in {w["code"] for w in self.whole["warnings"]})
        self.assertLess(sum(s["area_mm2"] for s in above), 0.2 * sum(s["area_mm2"] for s in found["segments"]))

    def test_seams_meet_on_the_print_and_are_told(self):
        found = self.whole["segments"]
        self.assertLess(found["largest_gap_mm"], 0.1)
        for seam in found["seams"]:
            a, b = seam["segments"]
            self.assertTrue(1 <= a <= b <= found["count"])
            self.assertGreater(seam["length_mm"], 0)
            self.assertLess(seam["gap_mm"], 0.1)
            self.assertLessEqual(seam["mean_jump_mm"], seam["max_jump_mm"])
        page = (self.folder / "whole/report.html").read_text()
        self.assertIn("Seams: how far the drawing jumps", page)
        self.assertEqual((self.folder / "whole/preview-segments.png").read_bytes()[:4], b"\x89PNG")
        self.assertIn("preview-segments.png", [a["name"] for a in self.whole["artifacts"]])

    def test_the_formed_sheet_has_the_segments_coordinates(self):
        """The figures of the report, computed from formed.ply, whose faces have the coordinates of their own
        segment. It holds the face on the mold, so that is inked here."""
        report = self.made("inner", "--set", "pattern.placement=segments", "--set", "pattern.inked_face=inner")
        sheet = self.formed("inner")
        self.assertGreater(len(sheet.points), report["forming"]["vertices"])
        flat = list(zip(sheet.vertices["u"], sheet.vertices["v"]))
        faces = [f for f in sheet.faces if not any(math.isnan(flat[v][0]) for v in f)]
        found = meshes.distortion(flat, sheet.points, faces)
        told = report["figures"]["with"]
        for figure in "shape", "area":
            self.assertAlmostEqual(found[figure]["mean"], told[figure]["mean"], delta=0.001, msg=figure)

    def test_seams_meet_on_any_grid(self):
        """However little a segment overlaps itself: it would be printed twice there."""
        for grid in 4.4, 4.8, 6:
            found = self.made("grid", "--set", "pattern.placement=segments", "--set", f"sheet.resolution_mm={grid}")["segments"]
            self.assertLess(found["largest_gap_mm"], 0.1, grid)

    def formed(self, name="whole"):
        return meshes.Ply((self.folder / name / "formed.ply").read_bytes())

    def test_cuts_are_made_where_they_are_asked_for(self):
        """One cut over the whole part, and a limit that needs no further cut."""
        sheet = self.formed()
        on_mold = [p for p, u in zip(sheet.points, sheet.vertices["u"]) if not math.isnan(u)]
        middle = (min(p[1] for p in on_mold) + max(p[1] for p in on_mold)) / 2
        across = [p for p in on_mold if abs(p[1] - middle) < 5]
        low, high = min(across), max(across)  # by x
        row = [round(v, 2) for v in low + high]
        report = self.made("cut", "--set", "pattern.placement=segments", "--set", "pattern.distortion_limit=10", "--set",
                           f"pattern.seams={json.dumps([row])}")
        found = report["segments"]
        self.assertEqual(found["count"], 2)
        between = [s for s in found["seams"] if len(set(s["segments"])) == 2]
        self.assertEqual(len(between), 1)
        self.assertGreater(between[0]["length_mm"], high[0] - low[0])
        for slit in found["seams"]:  # where the cut begins beside the border
            self.assertTrue(slit in between or slit["length_mm"] < 10, slit)
        self.assertNotIn("seams-not-enough", {w["code"] for w in report["warnings"]})

    def test_cuts_without_segments_are_refused(self):
        done = self.asked("refused", "--set", "pattern.seams=[[0,0,50,10,0,50]]")
        self.assertEqual(done.returncode, 2)
        self.assertIn("give pattern.placement=segments", done.stderr)

    def test_paint_weighs_the_chart(self):
        even = self.made("even")
        painted = self.made("painted", "--weights", self.dark, "--set", "flattening.weight=10")
        self.assertNotIn("favoured_triangles", even["flattening"])
        self.assertGreater(painted["flattening"]["favoured_triangles"], 20)
        self.assertLess(painted["flattening"]["energy_favoured"], painted["flattening"]["energy_rest"])
        self.assertEqual(len(painted["sha256"]["weights"]), 64)
        self.assertNotEqual(painted["label"], even["label"])

    def test_paint_and_its_setting_come_together(self):
        done = self.asked("refused", "--set", "flattening.weights=painted")
        self.assertEqual(done.returncode, 2)
        self.assertIn("give the file as --weights FILE", done.stderr)
        done = self.asked("refused", "--weights", self.dark, "--set", "flattening.weights=ink")
        self.assertEqual(done.returncode, 2)
        self.assertIn("together with flattening.weights=painted", done.stderr)


if __name__ == "__main__":
    unittest.main()
