"""A short run of chaos.py: nothing that was accepted is lost or done twice while the service is killed at random."""
import unittest

import chaos
from chaos_ledger import ENDINGS
from harness import Case


class Chaos(Case):
    def test_nothing_is_lost_and_nothing_done_twice(self):
        seed = 20181
        print(f"seed {seed}", flush=True)
        figures = chaos.run(60, seed, 1, 1, self.folder)
        print(figures, flush=True)
        self.assertEqual(sum(figures[end] for end in ENDINGS), figures["accepted"])
        self.assertEqual(figures["lost ten times"], 0)
        self.assertGreaterEqual(figures["accepted"], chaos.CLIENTS)
        self.assertGreater(figures["succeeded"], figures["accepted"] / 2)
        for what, times in figures["killed"].items():
            self.assertGreater(times, 0, what)


if __name__ == "__main__":
    unittest.main()
