"""A real newborn's head, smooth from MRI: the claims about coils, models and a run at default settings hold there too."""
import unittest

import real_scans
import test_coils
import test_command_line
import test_models


class Neonate(real_scans.OnRealScan):
    FILE = "neonate-40w.stl"


class Coils(Neonate, test_coils.Coils):
    pass


class Decoupled(Neonate, test_coils.Decoupled):
    strongest = r"-0\.0[1-5]\d+"


class Models(Neonate, test_models.Models):
    pass


class DefaultSettings(Neonate, test_command_line.Newborn):
    pass


if __name__ == "__main__":
    unittest.main()
