"""vacuform chart: a test sheet of the inks, and their curve from measured patches; by the real program."""
import json
import math
import random
import unittest

from harness import Case, vacuform
from test_colours import pixels

DPI = 150
COARSE = ("--set", "sheet.resolution_mm=3", "--set", f"print.dpi={DPI}", "--set", "print.marks=false")
FULL = {"cyan": (0, 255, 255), "magenta": (255, 0, 255), "yellow": (255, 255, 0)}
INKS = list(FULL)


def ink_of(printer, ink, coverage):
    """What a printer lays whose dots grow; each ink by another curve."""
    return (1 + 0.1 * INKS.index(ink)) * (1 - math.exp(-printer * coverage)) / (1 - math.exp(-printer))


class Chart(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.out = cls.folder / "chart"
        cls.done = vacuform("chart", "--out", cls.out, *COARSE)
        assert cls.done.returncode == 0, cls.done.stderr
        cls.patches = json.loads((cls.out / "chart.json").read_text())["patches"]

    def fit(self, csv, *words):
        table = self.folder / "measured.csv"
        table.write_text(csv)
        return vacuform("chart", "--fit", table, "--chart", self.out / "chart.json", *words)

    def test_writes_the_print_the_mold_and_the_patches(self):
        self.assertEqual({p.name for p in self.out.iterdir()},
                         {"print.png", "print.svg", "print.pdf", "preview-with.png", "mold.stl", "chart.json", "measured.csv"})
        self.assertEqual(len(self.patches), 64)
        self.assertEqual(len({p["id"] for p in self.patches}), 64)
        means = [sum(p["area_ratio"] for p in self.patches if p["step"] == step) / 16 for step in (1, 2, 3, 4)]
        for lower, higher in zip(means, means[1:]):
            self.assertGreater(higher, 1.08 * lower, means)
        self.assertGreater(means[3], 1.6)
        for patch in self.patches:
            self.assertLess(patch["gap_mm"], 0.5, patch)  # the sheet lies on the step
            self.assertLess(patch["most_area_ratio"] / patch["least_area_ratio"], 1.25, patch)
        for step in "abcd":
            self.assertIn(f"step {step}: stretched", self.done.stdout)
        self.assertEqual((self.out / "measured.csv").read_text().count(",,,\n"), 64)

    def test_the_print_has_each_patch_in_its_place_and_smaller_by_its_area_ratio(self):
        rows = pixels((self.out / "print.png").read_bytes())
        middle, mm = len(rows) // 2, 25.4 / DPI
        checked = 0
        for patch in self.patches:
            if patch["coverage"] != 1:
                continue
            s, t = patch["sheet_mm"]
            x, y = round(middle + s / mm - 0.5), round(middle - t / mm - 0.5)
            self.assertEqual(rows[y][x], FULL[patch["ink"]], patch)
            # The area on the flat sheet, edges by their coverage; its neighbours have other inks or are further away.
            empty = FULL[patch["ink"]].index(0)
            reach = round(6.2 / mm)
            covered = sum(rows[j][i][empty] < 128 and min(rows[j][i][k] for k in range(3) if k != empty) > 200
                          for j in range(y - reach, y + reach + 1) for i in range(x - reach, x + reach + 1))
            self.assertAlmostEqual(covered * mm * mm * patch["area_ratio"] / 100, 1, delta=0.06, msg=str(patch))
            checked += 1
        self.assertEqual(checked, 12)

    def test_the_same_bytes_twice(self):
        again = self.folder / "again"
        self.assertEqual(vacuform("chart", "--out", again, *COARSE).returncode, 0)
        for file in self.out.iterdir():
            self.assertEqual(file.read_bytes(), (again / file.name).read_bytes(), file.name)

    def test_a_printer_is_found_again_and_its_curve_is_a_setting(self):
        noise = random.Random(3)
        csv = "patch,coverage\n"
        for p in self.patches:
            if p["ink"] != "none":
                shown = min(1, ink_of(1.5, p["ink"], p["coverage"]) / p["area_ratio"])
                csv += f"{p['id']},{max(0, shown + noise.gauss(0, 0.01)):.4f}\n"
        profile = self.folder / "ink.json"
        done = self.fit(csv, "--out", profile)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        found = json.loads(profile.read_text())
        for printed, *inks in found["print"]["ink_curve"]:
            for ink, value in zip(INKS, inks):
                self.assertAlmostEqual(value, ink_of(1.5, ink, printed), delta=0.04)
        for ink in INKS:
            said = found["calibration"]["inks"][ink]
            self.assertEqual(said["patches"], 20)
            self.assertLess(said["rms"], 0.02)
            self.assertGreater(said["rms_linear"], 2 * said["rms"])
        setting = done.stdout.splitlines()[-1]
        self.assertTrue(setting.startswith("--set 'print.ink_curve=[[0,0,0,0],"), setting)
        assignment = setting[len("--set '"):-1]
        self.assertEqual(json.loads(assignment.split("=", 1)[1]), found["print"]["ink_curve"])
        # Both forms are settings: the chart itself leaves them out.
        other = vacuform("chart", "--out", self.folder / "with", *COARSE, "--settings", profile, "--set", assignment)
        self.assertEqual(other.returncode, 0, other.stderr)
        self.assertEqual((self.folder / "with/print.png").read_bytes(), (self.out / "print.png").read_bytes())
        as_json = json.loads(self.fit(csv, "--json").stdout)
        self.assertEqual(as_json, found)

    def test_nonsense_is_refused_in_plain_words(self):
        for csv, says in (("", "no patch is measured"), ("patch,L,a,b\nC1z,50,0,0\n", 'no patch "C1z"'),
                          ("patch,coverage\nC1a,55\n", "coverage is 55"), ("patch,L,a,b\nC1a,50,0,0\n", "no bare patch")):
            done = self.fit(csv)
            self.assertNotEqual(done.returncode, 0)
            self.assertEqual(done.stdout, "")
            self.assertIn(says, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        done = vacuform("chart", *COARSE)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--out", done.stderr)
        done = vacuform("chart", "--out", self.folder / "small", "--set", "machine.window_width_mm=100")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("a window of at least 168.0 mm", done.stderr)
        self.assertFalse((self.folder / "small").exists())


if __name__ == "__main__":
    unittest.main()
