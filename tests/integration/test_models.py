"""The models of the sheet beside the membrane, through vacuform run: what they report, and that both integrators of the
mass-spring model form the same part."""
import json
import math
import unittest

import made_scans
import meshes
from harness import PATTERNS, Case, vacuform

RINGS = PATTERNS / "rings-19x40mm.svg"


class Models(Case):
    scan = staticmethod(made_scans.newborn)

    def formed(self, model, *assignments):
        """The report and the formed sheet."""
        out = self.folder / "-".join((model, *assignments))
        words = [w for a in (f"forming.model={model}", "sheet.resolution_mm=8", "print.dpi=72", *assignments)
                 for w in ("--set", a)]
        done = vacuform("run", "--scan", self.scan(), "--pattern", RINGS, "--out", out, *words)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return json.loads((out / "report.json").read_text())["forming"], meshes.Ply((out / "formed.ply").read_bytes())

    def test_verlet_and_implicit_euler_form_the_same_part(self):
        sheets = []
        for integrator in ("verlet", "implicit_euler"):
            report, sheet = self.formed("mass_spring", f"forming.integrator={integrator}")
            self.assertTrue(report["converged"])
            self.assertLess(report["residual"], 1e-4)
            self.assertLess(report["kinetic_mj"], 1e-3)
            self.assertLess(report["force_error"], 1e-5)
            self.assertEqual(report["pressure_kpa"], 85)
            sheets.append(sheet)
        # The vertices of the grid, which come first; where those on rims of the mold lie depends on the sheet.
        places = [list(zip(sheet.vertices["s"], sheet.vertices["t"])) for sheet in sheets]
        grid = [i for i, (a, b) in enumerate(zip(*places)) if a == b]
        self.assertGreater(len(grid), 1000)
        self.assertLess(max(math.dist(sheets[0].points[i], sheets[1].points[i]) for i in grid), 0.1)

    def test_a_time_step_too_long_for_verlet(self):
        out = self.folder / "out"
        done = vacuform("run", "--scan", self.scan(), "--pattern", RINGS, "--out", out, "--set", "sheet.resolution_mm=8",
                        "--set", "forming.model=mass_spring", "--set", "forming.time_step_ms=2",
                        "--set", "forming.integrator=verlet")
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, r"\Avacuform: the net of springs blows up [^\n]+forming.time_step_ms[^\n]+\n\Z")
        self.assertEqual({file.name for file in out.iterdir()}, {"preview-findings.png", "mold.stl", "findings.json"})

    def test_projection_goes_straight_down_and_claims_no_forces(self):
        report, sheet = self.formed("projection")
        self.assertTrue(report["converged"])
        self.assertEqual(report["pressure_kpa"], 0)
        self.assertIsNone(report["residual"])
        self.assertIsNone(report["force_error"])
        v = sheet.vertices
        self.assertLess(max(map(abs, [a - b for a, b in zip(v["x"], v["s"])] + [a - b for a, b in zip(v["y"], v["t"])])),
                        1e-4)


if __name__ == "__main__":
    unittest.main()
