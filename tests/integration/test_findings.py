"""What a maker is told, on a figurine with horns: findings with place and size, vents that lie on the mold, the plug."""
import json
import struct
import unittest

import made_scans
import meshes
from harness import PATTERNS, Case, vacuform

RINGS = PATTERNS / "rings-7x40mm.svg"
PLUG = 15


class Run:
    def __init__(self, out, *words):
        done = vacuform("run", "--pattern", RINGS, "--out", out, "--set", "sheet.resolution_mm=5", "--set", "print.dpi=72", *words)
        assert done.returncode == 0, done.stderr
        self.report = json.loads((out / "report.json").read_text())
        self.mold = meshes.read_stl((out / "mold.stl").read_bytes())
        self.picture = (out / "preview-findings.png").read_bytes()
        self.warnings = {warning["code"]: warning for warning in self.report["warnings"]}

    def top(self):
        return max(p[2] for t in self.mold for p in t)


class Figurine(Case):
    scan = staticmethod(lambda: (made_scans.figurine(), "--set", "scan.trim_mm=0"))

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.plain = Run(cls.folder / "plain", "--scan", *cls.scan())
        cls.raised = Run(cls.folder / "raised", "--scan", *cls.scan(), "--set", f"machine.plug_height_mm={PLUG}", "--set", "forming.thin_limit=0.9")

    def test_every_mark_lies_where_the_part_is(self):
        self.assertLessEqual({"undercut", "trapped-air", "webbing"}, self.plain.warnings.keys())
        for code in "undercut", "trapped-air", "webbing":
            marks = self.plain.warnings[code]["marks"]
            self.assertGreaterEqual(len(marks), 1, code)
            self.assertLessEqual(len(marks), 20, code)
            for mark in marks:
                x, y, z = mark["place_mm"]
                self.assertGreater(mark["size_mm"], 0)
                self.assertLessEqual(max(abs(x), abs(y)), 140)  # inside of the window
                self.assertTrue(-0.1 <= z <= self.plain.top() + 0.1)

    def test_vents_lie_on_the_mold(self):
        near = meshes.Near(self.plain.mold, 1)
        vents = self.plain.report["vents"]
        self.assertGreaterEqual(len(vents), 3)
        for vent in vents:
            self.assertEqual(vent["diameter_mm"], 1)
            self.assertLess(near(vent["place_mm"]), 0.2, vent)  # places are rounded to 0.1 mm
        self.assertEqual([v["place_mm"] for v in vents][:20],
                         [m["place_mm"] for m in self.plain.warnings["trapped-air"]["marks"]])

    def test_preview_is_a_picture_of_the_width_of_the_others(self):
        for run in self.plain, self.raised:
            self.assertEqual(run.picture[:8], b"\x89PNG\r\n\x1a\n")
            width, height = struct.unpack(">II", run.picture[16:24])
            self.assertEqual(width, 1000)
            self.assertGreaterEqual(height, 1000)

    def test_plug_raises_the_mold(self):
        self.assertTrue(meshes.edges_closed(self.raised.mold))
        self.assertAlmostEqual(self.raised.top(), self.plain.top() + PLUG, places=3)
        self.assertEqual(min(p[2] for t in self.raised.mold for p in t), 0)
        before, after = (run.warnings["undercut"]["marks"][0]["place_mm"] for run in (self.plain, self.raised))
        self.assertAlmostEqual(after[2], before[2] + PLUG, delta=0.11)

    def test_thin_limit_is_a_setting(self):
        self.assertNotIn("thin", self.plain.warnings)
        self.assertIn("below 90 %", self.raised.warnings["thin"]["what"])


if __name__ == "__main__":
    unittest.main()
