"""A few made-up scans through the whole program, judged by a second one. VACUFORM_GENERATED_SCANS says how many."""
import os
import unittest

import generated_scans
import scan_generator
from harness import BIN, PATIENCE, Case


class GeneratedScans(Case):
    def test_none_ends_wrong(self):
        count = int(os.environ.get("VACUFORM_GENERATED_SCANS", "10"))
        runner = generated_scans.Runner(BIN, self.folder, grid=5.0, patience=PATIENCE)
        results = generated_scans.run_all(runner, "scans", range(count))
        self.assertGreaterEqual(sum(r.ended == "succeeded" for r in results), 1)
        self.assertEqual([r.row() for r in results if r.failures], [])

    def test_a_pose_is_right_or_asked_about(self):
        """One head of each kind: plain, without a crown, with floating parts, pits or noise, upside down, tilted."""
        runner = generated_scans.PoseRunner(BIN, self.folder, grid=5.0, patience=PATIENCE)
        results = generated_scans.run_all(runner, "scans", range(len(scan_generator.POSES)))
        self.assertEqual([r.row() for r in results if r.failures], [])


if __name__ == "__main__":
    unittest.main()
