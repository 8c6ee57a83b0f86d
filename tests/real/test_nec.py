"""Arrays laid on real heads, judged by the moment method: NEC2 (Debian's nec2c) and the report agree on inductance and
coupling. NEC gets the centre lines that the independent checker reads from formed.ply and print.svg, as wires."""
import json
import math
import subprocess
import tempfile
import unittest
from pathlib import Path

import real_scans
from harness import BIN, Case, vacuform

MHZ = 20  # a loop is short against the wave, and NEC's double precision still holds
LEAST_APART_MM = 3  # NEC models thin wires: nearer ones are thick for their distance, and none may cross


def currents(loops):
    """Of loops of wires, the first driven by one volt: the current of each, A."""
    cards = ["CE"]
    for number, loop in enumerate(loops):
        points = [[mm / 1000 for mm in point] for point in loop["line"]]
        for a, b in zip(points, points[1:] + points[:1]):
            # A strip is as inductive as a wire of a quarter of its width as radius.
            radius = loop["trace_mm"] / 4000
            cards.append(f"GW {number + 1} 1 " + " ".join(f"{x:.7f}" for x in a + b) + f" {radius:.7f}")
    cards += ["GE 0", f"FR 0 1 0 0 {MHZ} 0", "EX 0 1 1 0 1 0", "XQ", "EN"]
    with tempfile.TemporaryDirectory() as folder:
        deck, said = Path(folder) / "deck", Path(folder) / "said"
        deck.write_text("\n".join(cards) + "\n")
        subprocess.run(["nec2c", "-i", deck, "-o", said], check=True, capture_output=True)
        table = said.read_text().split("CURRENTS AND LOCATION")[1].splitlines()
    first = {}
    for line in table:
        words = line.split()
        if len(words) == 10 and words[0].isdigit():
            first.setdefault(int(words[1]), complex(float(words[6]), float(words[7])))
    return [first[number + 1] for number in range(len(loops))]


def inductance_nh(loop):
    return (1 / currents([loop])[0]).imag / (2 * math.pi * MHZ * 1e6) * 1e9


def coupling(driven, other):
    """M / sqrt(L1 L2): what is induced in a closed loop is -M / L2 of the current of the driven one."""
    one, two = currents([driven, other])
    return -(two / one).real * math.sqrt(other["nh"] / driven["nh"])


def apart_mm(a, b):
    return min(math.dist(p, q) for p in a["line"] for q in b["line"])


class LaidArray:
    COUNT = 0
    PAIRS = 24  # that NEC judges: the strongest of those that are far enough apart

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        layout, out = cls.folder / "layout", cls.folder / "out"
        common = ["--scan", cls.scan(), "--set", "sheet.resolution_mm=3"]
        for words in (["layout", "--count", str(cls.COUNT), "--out", layout],
                      ["run", "--pattern", layout / "pattern.svg", "--out", out, "--set", "print.dpi=150"]):
            done = vacuform(words[0], *common, *words[1:])
            assert done.returncode == 0, done.stderr
        done = subprocess.run([BIN / "measure_coils", out / "formed.ply", out / "print.svg", layout / "pattern.svg",
                               "--lines"], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        cls.report = json.loads((out / "report.json").read_text())
        cls.loops = {coil["id"]: coil for coil in json.loads(done.stdout)["coils"]}
        for loop in cls.loops.values():
            loop["nh"] = inductance_nh(loop)

    def test_inductances(self):
        self.assertEqual(len(self.report["coils"]), self.COUNT)
        for coil in self.report["coils"]:
            self.assertAlmostEqual(coil["with"]["inductance_nh"] / self.loops[coil["id"]]["nh"], 1, delta=0.015,
                                   msg=coil["id"])

    def test_couplings(self):
        ids, k = self.report["couplings"]["coils"], self.report["couplings"]["k"]
        pairs = [(k[a][b], one, ids[b]) for a, one in enumerate(ids) for b in range(a + 1, len(ids))]
        pairs = [p for p in pairs if apart_mm(self.loops[p[1]], self.loops[p[2]]) >= LEAST_APART_MM]
        pairs.sort(key=lambda pair: -abs(pair[0]))
        self.assertGreaterEqual(len(pairs), self.PAIRS)
        self.assertGreater(abs(pairs[0][0]), 0.01)
        for said, one, other in pairs[:self.PAIRS]:
            self.assertAlmostEqual(said, coupling(self.loops[one], self.loops[other]), delta=0.0025,
                                   msg=f"{one} and {other}")


class OnAnAdult(LaidArray, real_scans.OnRealScan, Case):
    FILE, COUNT = "adult-scalp-ascii.ply", 12


class OnANewborn(LaidArray, real_scans.OnRealScan, Case):
    FILE, COUNT = "neonate-40w.stl", 16


if __name__ == "__main__":
    unittest.main()
