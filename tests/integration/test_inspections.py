"""A scan looked at before anything is formed: once uploaded, inspected by a worker, then printed without uploading it again."""
import json
import struct
import unittest

import made_scans
import meshes
from harness import PATTERNS, Case, Server, curl, vacuform
from test_jobs import COARSE, log_of

RINGS, HEAD, BROKEN = PATTERNS / "rings-7x40mm.svg", made_scans.newborn(), made_scans.corrupt()


class Inspections(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = Server(cls.folder, workers=1)
        cls.server.__enter__()
        cls.addClassCleanup(cls.server.__exit__, None, None, None)

    def ask(self, **wish):
        return curl("-H", "Content-Type: application/json", "-d", json.dumps(wish), self.server.api + "/jobs")

    def scan(self, path):
        answer = curl("-F", f"scan=@{path}", self.server.api + "/scans")
        self.assertEqual(answer.status, 201, answer)
        return answer.json["id"]

    def artifact(self, job, name):
        return curl(f"{self.server.api}/jobs/{job}/artifacts/{name}")

    def test_from_an_inspection_to_the_print(self):
        scan = self.scan(HEAD)
        answer = self.ask(kind="inspection", scan_id=scan, settings={"sheet": COARSE["sheet"]})
        self.assertEqual(answer.status, 202, answer)
        job = self.server.wait(answer.json["id"])
        self.assertEqual(job["state"], "succeeded", job["problem"])
        self.assertEqual([a["name"] for a in job["artifacts"]], ["preview-findings.png", "mold.stl", "findings.json"])
        self.assertEqual(job["progress"], 1)

        # The findings stand with the scan, and are those of the command line.
        inspection = curl(f"{self.server.api}/scans/{scan}").json["inspection"]
        self.assertEqual((inspection["job"], inspection["state"], inspection["problem"]), (job["id"], "succeeded", None))
        told = vacuform("inspect", HEAD, "--json")
        self.assertEqual(told.returncode, 0, told.stderr)
        self.assertEqual(inspection["findings"], json.loads(told.stdout))
        self.assertTrue(inspection["findings"]["fits"])
        picture = self.artifact(job["id"], "preview-findings.png").body
        self.assertEqual((picture[:8], struct.unpack(">I", picture[16:20])), (b"\x89PNG\r\n\x1a\n", (1000,)))
        top = inspection["findings"]["mold"]["top_mm"][2]
        self.assertAlmostEqual(max(p[2] for t in meshes.read_stl(self.artifact(job["id"], "mold.stl").body) for p in t), top, 1)

        # The print made from it skips the scan stage.
        answer = curl("-F", f"from={job['id']}", "-F", f"pattern=@{RINGS}", "-F", f"settings={json.dumps(COARSE)}",
                      self.server.api + "/jobs")
        self.assertEqual(answer.status, 202, answer)
        printed = self.server.wait(answer.json["id"])
        self.assertEqual((printed["kind"], printed["state"]), ("print", "succeeded"), printed["problem"])
        self.assertIn("stage scan cached", log_of(self.server, printed["id"]))
        self.assertEqual(self.artifact(printed["id"], "mold.stl").body, self.artifact(job["id"], "mold.stl").body)

    def test_a_mold_that_does_not_fit_is_a_finding(self):
        settings = {"machine": {"window_width_mm": 100, "window_height_mm": 100}}
        answer = self.ask(kind="inspection", scan_id=self.scan(HEAD), settings=settings)
        job = self.server.wait(answer.json["id"])
        self.assertEqual(job["state"], "succeeded", job["problem"])
        findings = self.artifact(job["id"], "findings.json").json
        self.assertEqual((findings["fits"], findings["problem"]["code"]), (False, "does-not-fit"))
        self.assertIn(findings["problem"]["what"], curl(f"{self.server.url}/jobs/{job['id']}").body.decode())

    def refused(self, scan, settings):
        """The job of a print that is refused, and its findings."""
        answer = curl("-F", f"scan=@{scan}", "-F", f"pattern=@{RINGS}", "-F", f"settings={json.dumps(settings)}", self.server.api + "/jobs")
        job = self.server.wait(answer.json["id"])
        self.assertEqual(job["state"], "failed")
        self.assertEqual([file["name"] for file in job["artifacts"]], ["preview-findings.png", "mold.stl", "findings.json"])
        self.assertGreater(len(meshes.read_stl(self.artifact(job["id"], "mold.stl").body)), 0)
        findings = self.artifact(job["id"], "findings.json").json
        for key in "what", "where", "fix":
            self.assertEqual(findings["problem"][key], job["problem"][key])
        return job["problem"]["type"], findings

    def test_a_print_whose_mold_does_not_fit_keeps_the_findings(self):
        problem, findings = self.refused(HEAD, {"machine": {"window_width_mm": 100, "window_height_mm": 100}})
        self.assertEqual((problem, findings["fits"], findings["problem"]["place_mm"]), ("/problems/does-not-fit", False, None))

    def test_a_print_whose_sheet_tears_names_the_place(self):
        tower = self.folder / "tower.obj"
        tower.write_text("".join(f"v {x} {y} {z}\n" for z in (0, 240) for y in (-10, 10) for x in (-10, 10)) +
                         "".join(f"f {f}\n" for f in ("1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6")))
        problem, findings = self.refused(tower, {
            "scan": {"units": "mm", "up": "+z"}, "sheet": {"resolution_mm": 4}, "forming": {"law": "neo_hookean"}})
        self.assertEqual((problem, findings["fits"]), ("/problems/forming-failed", True))
        x, y, z = findings["problem"]["place_mm"]
        self.assertTrue(abs(x) < 140 and abs(y) < 140 and 0 <= z <= 240, findings["problem"])
        self.assertIn(f"x = {x:.0f} mm, y = {y:.0f} mm, z = {z:.0f} mm", findings["problem"]["where"])

    def test_a_scan_that_makes_no_mold_is_the_job_s_problem(self):
        scan = self.scan(BROKEN)
        job = self.server.wait(self.ask(kind="inspection", scan_id=scan).json["id"])
        self.assertEqual((job["state"], job["attempt"]), ("failed", 1))
        shown = curl(f"{self.server.api}/scans/{scan}").json["inspection"]
        self.assertEqual(shown["problem"], job["problem"])
        self.assertIsNone(shown["findings"])

    def test_empty_fields_and_the_plain_page(self):
        """An empty field or file counts as missing. The plain page shows what was found."""
        empty = self.folder / "none"
        empty.touch()
        answer = curl("-F", f"scan=@{HEAD}", "-F", f"pattern=@{RINGS}", "-F", f'temperature=@{empty};filename=""', "-F", "profile=",
                      "-F", "print.dpi=", "-F", "kind=inspection", self.server.api + "/jobs")
        self.assertEqual(answer.status, 202, answer)
        job = self.server.wait(answer.json["id"])
        self.assertEqual((job["kind"], job["state"], list(job["inputs"])), ("inspection", "succeeded", ["scan", "pattern"]))
        page = curl(f"{self.server.url}/jobs/{job['id']}").body.decode()
        for words in "Fits the machine", "preview-findings.png":
            self.assertIn(words, page)
        answer = self.ask(**{"from": job["id"], "settings": COARSE})  # the pattern waited with it
        self.assertEqual((answer.status, answer.json["kind"]), (202, "print"))


if __name__ == "__main__":
    unittest.main()
