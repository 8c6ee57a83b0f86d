"""A real figurine with horns: findings, segments and the painted chart."""
import unittest

import real_scans
import test_findings
import test_segments


class Goat(real_scans.OnRealScan):
    FILE, GIVEN = "figurine-goathead.obj", ("--set", "scan.up=-x", "--set", "scan.trim_mm=60")


class Findings(Goat, test_findings.Figurine):
    pass


class Segments(Goat, test_segments.Segments):
    pass


if __name__ == "__main__":
    unittest.main()
