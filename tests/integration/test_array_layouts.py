"""Layouts: a pattern of coils made for the sample head by the service, then printed on the head that is still formed."""
import json
import unittest

import made_scans
from harness import Case, Server, curl, vacuform, wait_for
from test_coils import checked
from test_jobs import log_of

COARSE = {"sheet": {"resolution_mm": 5}}
ARRAY = {"count": 9, "diameter_mm": 40}


class ArrayLayouts(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = cls.enterClass(Server(cls.folder, workers=1))
        sample = cls.folder / "sample"
        assert vacuform("sample", "--out", sample).returncode == 0
        cls.head = sample / "head.stl"

    def post(self, *parts, **settings):
        return curl("-F", f"scan=@{self.head}", "-F", f"settings={json.dumps({**COARSE, **settings})}", *parts, self.server.api + "/jobs")

    def artifact(self, job, name):
        return curl(f"{self.server.api}/jobs/{job}/artifacts/{name}").body

    def test_from_a_layout_to_the_print(self):
        answer = self.post("-F", "kind=layout", layout=ARRAY)
        self.assertEqual(answer.status, 202, answer)
        job = self.server.wait(answer.json["id"])
        self.assertEqual((job["kind"], job["state"]), ("layout", "succeeded"), job["problem"])
        self.assertEqual(([a["name"] for a in job["artifacts"]], job["progress"]), (["pattern.svg", "layout.json"], 1))
        self.assertIn("stage forming", log_of(self.server, job["id"]))
        pattern, layout = self.artifact(job["id"], "pattern.svg"), json.loads(self.artifact(job["id"], "layout.json"))
        self.assertEqual((layout["count"], layout["diameter_mm"], layout["off_head"]), (9, 40, 0))
        ids = {f"coil-{i}" for i in range(1, 10)}
        for pair in layout["strongest_neighbours"], layout["strongest"]:
            self.assertLess({pair["a"], pair["b"]}, ids)
        self.assertLess(abs(layout["strongest_neighbours"]["k"]), 0.01)
        self.assertEqual(job["serious_warnings"], sum(w["severity"] == "serious" for w in layout["warnings"]))

        # The command line makes the same bytes.
        out = self.folder / "by-hand"
        done = vacuform("layout", "--scan", self.head, "--set", "sheet.resolution_mm=5", "--count", "9", "--diameter_mm", "40", "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((out / "pattern.svg").read_bytes(), pattern)
        self.assertEqual((out / "layout.json").read_bytes(), self.artifact(job["id"], "layout.json"))

        # The page shows the figures.
        page = curl(f"{self.server.url}/jobs/{job['id']}").body.decode()
        for words in "The coils", "40.0 mm", layout["strongest"]["a"] + " and ":
            self.assertIn(words, page)

        # The print forms no head again, and its coils are round and where the layout has them.
        drawing = self.folder / "pattern.svg"
        drawing.write_bytes(pattern)
        settings = {"coils": {"decouple": True}, "print": {"dpi": 72}}
        answer = curl("-F", f"from={job['id']}", "-F", f"pattern=@{drawing}", "-F", f"settings={json.dumps(settings)}", self.server.api + "/jobs")
        self.assertEqual(answer.status, 202, answer)
        printed = self.server.wait(answer.json["id"])
        self.assertEqual((printed["kind"], printed["state"]), ("print", "succeeded"), printed["problem"])
        said = log_of(self.server, printed["id"])
        self.assertIn("stage scan cached", said)
        self.assertIn("stage forming cached", said)
        self.assertNotIn("stage forming", said)
        folder = self.folder / "printed"
        folder.mkdir()
        for name in "formed.ply", "print.svg":
            (folder / name).write_bytes(self.artifact(printed["id"], name))
        measured = checked(folder, drawing)
        self.assertEqual({c["id"] for c in measured["coils"]}, ids)
        for coil in measured["coils"]:
            self.assertLess(coil["circularity"], 0.02, coil)
        self.assertLess(max(abs(p["k"]) for p in measured["pairs"]), 0.01)
        report = json.loads(self.artifact(printed["id"], "report.json"))
        self.assertNotIn("coils-moved", [w["code"] for w in report["warnings"]])

    def test_a_layout_is_cancelled_like_any_job(self):
        job = self.post("-F", "kind=layout", sheet={"resolution_mm": 1}).json["id"]
        wait_for(lambda: self.server.job(job)["stage"] == "forming", "the forming of the head")
        self.assertLess(self.server.job(job)["progress"], 0.6)
        self.assertIn(curl("-X", "POST", f"{self.server.api}/jobs/{job}/cancel").json["state"], ("cancelling", "cancelled"))
        self.assertEqual(self.server.wait(job)["state"], "cancelled")

    def test_too_many_coils_are_the_problem_of_the_job(self):
        job = self.server.wait(self.post("-F", "kind=layout", layout={"count": 64, "diameter_mm": 120}).json["id"])
        self.assertEqual((job["state"], job["attempt"]), ("failed", 1))
        self.assertEqual((job["problem"]["type"], job["problem"]["where"]), ("/problems/unusable-surface", "layout.count"))
        self.assertRegex(job["problem"]["fix"], r"about \d+ of this diameter fit")

    def test_a_print_refuses_the_settings_of_a_layout(self):
        answer = self.post("-F", f"pattern=@{self.head.parent / 'pattern.svg'}", layout=ARRAY)
        self.assertEqual((answer.status, answer.json["type"], answer.json["where"]), (422, "/problems/bad-settings", "layout.count"))
        answer = self.post("-F", "kind=layout", layout={"overlap": 0.3})
        self.assertEqual((answer.status, answer.json["where"]), (422, "layout.overlap"))

    def test_coils_off_the_head_are_a_serious_warning(self):
        out = self.folder / "large"
        done = vacuform("layout", "--scan", made_scans.newborn(), "--set", "sheet.resolution_mm=8", "--set", "layout.count=12",
                        "--set", "layout.diameter_mm=48", "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        layout = json.loads((out / "layout.json").read_text())
        self.assertGreater(layout["off_head"], 0)
        warning = next(w for w in layout["warnings"] if w["code"] == "coil-off-head")
        self.assertEqual((warning["severity"], warning["figure"]["value"]), ("serious", layout["off_head"]))
        self.assertEqual(warning["what"], f"{layout['off_head']} of 12 coils do not lie wholly on the formed part.")

    def test_the_command_line_submits_one(self):
        out = self.folder / "submitted"
        done = vacuform("submit", "--server", self.server.url, "--kind", "layout", "--scan", self.head, "--set", "sheet.resolution_mm=5",
                        "--set", "layout.count=7", "--set", "layout.diameter_mm=30", "--set", "layout.overlap=1.1", "--wait", "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        layout = json.loads((out / "layout.json").read_text())
        self.assertEqual((layout["count"], layout["diameter_mm"], layout["off_head"]), (7, 30, 0))
        self.assertAlmostEqual(layout["spacing_mm"] / 30, 1.1, delta=0.03)
        self.assertEqual((out / "pattern.svg").read_text().count("<circle"), 7)


if __name__ == "__main__":
    unittest.main()
