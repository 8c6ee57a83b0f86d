"""The real scans, which are not in the repository: scans.json describes them, tests/fetch-scans downloads them.

A test is skipped if its scan is missing, or fails if VACUFORM_REQUIRE_REAL_SCANS=1.
"""
import json
import os
import pathlib
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "integration"))

SHARED = pathlib.Path(os.environ.get("VACUFORM_SHARED_DATA") or HERE.parents[2] / "shared" / "data")
FILES = [entry["file"] for entry in json.loads((HERE / "scans.json").read_text())]


def scan(file):
    """The path of a real scan."""
    path = SHARED / "scans" / file
    if not path.exists():
        message = f"{path} is missing. Run tests/fetch-scans, or set VACUFORM_SHARED_DATA to the folder above scans/."
        if os.environ.get("VACUFORM_REQUIRE_REAL_SCANS") == "1":
            raise AssertionError(message)
        raise unittest.SkipTest(message)
    return path


class OnRealScan:
    """A class decorator: runs the tests of a test case on the real scan FILE, with the settings GIVEN if it has any."""

    FILE, GIVEN = "", None

    @classmethod
    def scan(cls):
        path = scan(cls.FILE)
        return path if cls.GIVEN is None else (path, *cls.GIVEN)
