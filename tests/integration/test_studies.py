"""vacuform converge, run --sensitivity and calibrate, by the real program on a small dome."""
import csv
import json
import math
import random
import re
import signal
import subprocess
import time
import unittest

import meshes
from harness import BIN, Case, vacuform

COILS = ('<svg xmlns="http://www.w3.org/2000/svg" width="80mm" height="40mm" viewBox="-40 -20 80 40">'
         '<g id="left"><circle cx="-18" r="14" fill="none" stroke="black"/></g>'
         '<g id="right"><circle cx="18" r="14" fill="none" stroke="black"/></g></svg>')
MACHINE = {"scan": {"units": "mm", "up": "+z"}, "sheet": {"width_mm": 190, "height_mm": 190, "resolution_mm": 8},
           "machine": {"window_width_mm": 170, "window_height_mm": 170}, "print": {"dpi": 72}}


class Studies(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scan = cls.folder / "dome.stl"
        cls.scan.write_bytes(meshes.stl(meshes.hemisphere(50, 40, 80)))
        (cls.folder / "coils.svg").write_text(COILS)
        (cls.folder / "settings.json").write_text(json.dumps(MACHINE))
        cls.given = ["--scan", cls.scan, "--settings", cls.folder / "settings.json"]

    def form(self, name, *words):
        done = vacuform("run", *self.given, "--pattern", self.folder / "coils.svg", "--out", self.folder / name, *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_converge(self):
        out = self.folder / "convergence.json"
        done = vacuform("converge", *self.given, "--twice", "--out", out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        found = json.loads(out.read_text())
        self.assertEqual([(r["coarse_mm"], r["fine_mm"]) for r in found["refinements"]], [(16, 8), (8, 4)])
        for r in found["refinements"]:
            for part in "head_mm", "sheet_mm":
                self.assertLessEqual(r[part]["mean"], r[part]["p95"])
                self.assertLessEqual(r[part]["p95"], r[part]["max"])
            row = re.search(rf"{r['coarse_mm']:g} -> {r['fine_mm']:g} mm +head +(\S+) +(\S+) +(\S+) +(\S+)", done.stdout)
            for said, key in zip(row.groups(), ("mean", "p95", "p99", "max")):
                self.assertAlmostEqual(float(said), r["head_mm"][key], delta=0.00056, msg=key)
            self.assertAlmostEqual(math.hypot(*r["worst_on_head"]["formed_mm"]), 50, delta=0.5)
        means = [r["head_mm"]["mean"] for r in found["refinements"]]
        self.assertAlmostEqual(found["order"], math.log2(means[0] / means[1]), delta=0.02)
        self.assertIn("order of convergence", done.stdout)

    def test_a_grid_too_fine_is_refused_before_anything_is_formed(self):
        done = vacuform("converge", *self.given, "--set", "sheet.resolution_mm=0.8")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("sheet.resolution_mm", done.stderr)

    def test_sensitivity(self):
        says = self.form("plain")
        self.assertNotIn("how far the coils", says)
        says = self.form("sensitive", "--sensitivity")
        plain, report = (json.loads((self.folder / name / "report.json").read_text()) for name in ("plain", "sensitive"))
        found = report.pop("sensitivity")
        self.assertEqual(plain, report, "the study adds to the report and changes nothing else")
        self.assertEqual(found["coils"], ["left", "right"])
        for centre, coil in zip(found["centres_mm"], report["coils"]):
            self.assertEqual(coil["with"]["on_head"], True)
            self.assertLess(math.dist(centre, coil["with"]["centre_mm"]), 1.2, "where the coil is laid, on the mold's face")
        changes = {c["id"]: c for c in found["changes"]}
        self.assertEqual(set(changes), {"window", "drape-height", "edge-stiffness", "edge-temperature", "law", "modulus", "resolution"})
        for change in changes.values():
            self.assertIn(change["text"], says)
            self.assertAlmostEqual(change["mean_mm"], sum(change["coils_mm"]) / 2, delta=0.002)
            self.assertEqual(change["max_mm"], max(change["coils_mm"]))
            self.assertAlmostEqual(*change["coils_mm"], delta=0.05)  # one is the other's mirror image
        self.assertLess(changes["modulus"]["max_mm"], 0.05)
        self.assertLess(changes["modulus"]["max_mm"], changes["edge-temperature"]["max_mm"])

    def measure(self, name, rows):
        with open(self.folder / name, "w", newline="") as out:
            csv.writer(out).writerows([["s", "t", "x", "y", "z"], *rows])
        return self.folder / name

    def test_calibrate_recovers_what_the_part_was_formed_with(self):
        self.form("real", "--set", "machine.drape_height_mm=9", "--set", "machine.window_width_mm=166",
                  "--set", "forming.edge_stiffness=1.4", "--set", "sheet.resolution_mm=3")
        truth = {"machine.drape_height_mm": 9, "machine.window_width_mm": 166, "machine.window_height_mm": 170,
                 "forming.edge_stiffness": 1.4}
        v = meshes.Ply((self.folder / "real/formed.ply").read_bytes()).vertices
        noise = random.Random(5)
        turn = math.radians(30)  # the measuring machine's own frame
        rows = []
        for s, t, x, y, z, contact in zip(*(v[k] for k in ("s", "t", "x", "y", "z", "contact"))):
            if contact != 3 and max(abs(s), abs(t)) < 80:
                x, y, z = (c + noise.gauss(0, 0.2) for c in (x, y, z))
                rows.append([s, t, x * math.cos(turn) - y * math.sin(turn) + 500, x * math.sin(turn) + y * math.cos(turn), z - 70])
        profile = self.folder / "profile.json"
        # formed.ply has the face that touches the mold.
        done = vacuform("calibrate", *self.given, "--set", "sheet.resolution_mm=5", "--set", "pattern.inked_face=inner", "--json",
                        "--measured", self.measure("grid.csv", rows), "--out", profile)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        done_json = json.loads(done.stdout)
        found = json.loads(profile.read_text())
        self.assertAlmostEqual(found["machine"]["drape_height_mm"], 9, delta=1)
        self.assertAlmostEqual(found["machine"]["window_width_mm"], 166, delta=2)
        self.assertAlmostEqual(found["machine"]["window_height_mm"], 170, delta=2)
        self.assertAlmostEqual(found["forming"]["edge_stiffness"], 1.4, delta=0.15)
        says = found["calibration"]
        self.assertEqual(says["formings"], done_json["calibration"]["formings"])
        for name, real in truth.items():
            p = says["parameters"][name]
            self.assertLessEqual(p["interval_95"][0], real, name)
            self.assertGreaterEqual(p["interval_95"][1], real, name)
            self.assertLessEqual(p["standard_error"], p["standard_error_by_points_alone"] or math.inf)
        self.assertEqual(says["parameters"]["machine.window_width_mm"]["prior"]["standard_deviation"], 5)
        self.assertEqual(len(says["correlation"]["matrix"]), 4)
        self.assertLess(says["residual_mm"]["mean"], 0.5)
        self.assertLess(says["residual_mm"]["mean"], says["residual_before_mm"]["mean"] / 2)
        self.assertIn("machine.drape_height_mm", done.stdout)
        # The profile is one for --settings, beside the others.
        self.form("calibrated", "--settings", profile)
        used = json.loads((self.folder / "calibrated/report.json").read_text())["settings"]
        self.assertEqual(used["machine"]["drape_height_mm"], found["machine"]["drape_height_mm"])

    def test_a_bad_prior_is_one_message(self):
        rows = [[10 * i, 3 * i * i % 50, 0, 0, 0] for i in range(8)] + [[0, 40, 0, 0, 0], [5, -40, 0, 0, 0]]
        for prior, word in [("machine.vacuum_kpa=1", "machine.vacuum_kpa"), ("machine.window_width_mm", "--prior"),
                            ("machine.window_width_mm=-1", "must be positive")]:
            done = vacuform("calibrate", *self.given, "--measured", self.measure("few.csv", rows), "--prior", prior, "--out",
                            self.folder / "no.json")
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertIn(word, done.stderr)
        self.assertFalse((self.folder / "no.json").exists())

    def test_a_bad_table_is_one_message_with_its_line(self):
        for rows, words in [([[1, 2, 3, 4]], ["line 2", "none for z"]), ([[1, 2, 3, 4, "x"]], ["line 2", '"x"']),
                            ([[500, 0, 0, 0, 0]], ["line 2", "off the sheet"]), ([[1, 2, 3, 4, 5]], ["only 1 measured points"])]:
            done = vacuform("calibrate", *self.given, "--measured", self.measure("bad.csv", rows), "--out", self.folder / "no.json")
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertRegex(done.stderr, r"\Avacuform: [^\n]+bad.csv[^\n]*\n\Z")
            for word in words:
                self.assertIn(word, done.stderr)
        self.assertFalse((self.folder / "no.json").exists())

    def test_a_study_can_be_cancelled(self):
        study = subprocess.Popen([BIN / "vacuform", "converge", *self.given, "--set", "sheet.resolution_mm=1"],
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        time.sleep(1)
        study.send_signal(signal.SIGTERM)
        out, err = study.communicate(timeout=60)
        self.assertEqual((study.returncode, out), (130, ""))
        self.assertTrue(re.fullmatch(r"vacuform: cancelled[^\n]*\n", err), err)


if __name__ == "__main__":
    unittest.main()
