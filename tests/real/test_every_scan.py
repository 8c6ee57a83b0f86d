"""Every real scan ends as it should: through `vacuform inspect` and through the service."""
import functools
import unittest

import real_scans
import test_command_line
import test_service

SCANS = {file: functools.partial(real_scans.scan, file) for file in real_scans.FILES}


class Inspect(test_command_line.Inspect):
    SCANS = SCANS
    REFUSED = {"bust-demosthenes.obj": "the scan's unit is not clear",
               "bust-gutenberg-ascii.stl": "the scan's unit is not clear",
               "corrupt-head.glb": "replaced by the mark for unreadable text"}


class Service(test_service.Scans):
    SCANS = SCANS
    REFUSALS = {"bust-demosthenes.obj": ["ambiguous-units"],  # no unit makes it plausible
                "bust-gutenberg-ascii.stl": ["ambiguous-units", "unusable-scan"],  # nor this; then automatic trim keeps too little
                "corrupt-head.glb": ["corrupt-file"]}
    HEADS = {"adult-fsaverage-metres.obj", "adult-scalp-ascii.ply", "child-headform-metres.stl", "neonate-40w.stl"}


if __name__ == "__main__":
    unittest.main()
