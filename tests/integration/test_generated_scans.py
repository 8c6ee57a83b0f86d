"""A few made-up scans through the whole program, judged by a second one. VACUFORM_GENERATED_SCANS says how many."""
import os
import unittest

import generated_scans
from harness import BIN, PATIENCE, Case


class GeneratedScans(Case):
    def test_none_ends_wrong(self):
        count = int(os.environ.get("VACUFORM_GENERATED_SCANS", "10"))
        runner = generated_scans.Runner(BIN, self.folder, grid=5.0, patience=PATIENCE)
        results = generated_scans.run_all(runner, "scans", range(count))
        self.assertGreaterEqual(sum(r.ended == "succeeded" for r in results), 1)
        self.assertEqual([r.row() for r in results if r.failures], [])


if __name__ == "__main__":
    unittest.main()
