"""A short run of chaos.py: nothing that was accepted is lost or done twice while the service is killed at random."""
import unittest

import chaos
from harness import Case


class Chaos(Case):
    def test_nothing_is_lost_and_nothing_done_twice(self):
        seed = 20181
        print(f"seed {seed}", flush=True)
        figures = chaos.run(15, seed, 2, self.folder)
        print(figures, flush=True)
        self.assertEqual(figures["succeeded"] + figures["failed"], figures["accepted"])
        self.assertGreaterEqual(figures["accepted"], chaos.CLIENTS)
        self.assertGreater(figures["server"], 0)
        self.assertGreater(figures["worker"] + figures["child"], 0)


if __name__ == "__main__":
    unittest.main()
