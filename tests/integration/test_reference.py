"""The reference of a job: on the print, in the report and in the names of downloads, and in no log."""
import html
import json
import pathlib
import re
import unittest
import zlib

from harness import PATTERNS, Case, Server, curl, vacuform
import made_scans

SCAN, RINGS = made_scans.newborn(), PATTERNS / "rings-7x40mm.svg"
COARSE = ["--set", "sheet.resolution_mm=6", "--set", "print.dpi=72"]
REFERENCE = "Köln (2) <&> [7]"
NOTE = "second scan\nurgent"


def drawn(pdf):
    """The texts of a PDF's pages, as Latin-1."""
    streams = re.findall(rb"/FlateDecode /Length \d+ >>\nstream\n(.*?)\nendstream", pdf, re.S)
    content = b"".join(zlib.decompress(s) for s in streams if s[:1] == b"\x78")
    return [re.sub(r"\\(.)", r"\1", t) for t in re.findall(r"\(((?:[^()\\]|\\.)*)\) Tj", content.decode("latin-1"))]


class Reference(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = cls.enterClass(Server(cls.folder, workers=1))
        cls.out = cls.folder / "out"
        done = vacuform("submit", "--server", cls.server.url, "--scan", SCAN, "--pattern", RINGS, *COARSE, "--set", "scan.front=+y",
                        "--set", "scan.left_side=plus_x", f"--reference={REFERENCE}", "--note", NOTE, "--wait", "--out", cls.out)
        assert done.returncode == 0, done.stderr
        cls.said = done.stdout
        cls.job = curl(f"{cls.server.api}/jobs?text=k%C3%96LN").json["jobs"][0]

    def report(self, folder):
        return json.loads((folder / "report.json").read_text())

    def test_the_job_has_it(self):
        self.assertEqual((self.job["reference"], self.job["note"]), (REFERENCE, NOTE))
        self.assertIn(f"reference {REFERENCE}, for the outer face", self.said)

    def test_print_and_report_show_it(self):
        self.assertEqual(self.report(self.out)["reference"], REFERENCE)
        self.assertIn("reference " + html.escape(REFERENCE, quote=False), (self.out / "report.html").read_text())
        legend = f"reference {REFERENCE}   ·   Vacuform {self.report(self.out)['label']}"
        self.assertIn(html.escape(legend, quote=False), (self.out / "print.svg").read_text())
        self.assertTrue(any(text.startswith(legend) for text in drawn((self.out / "print.pdf").read_bytes())))

    def test_the_command_line_makes_the_same_files(self):
        out = self.folder / "run"
        done = vacuform("run", "--scan", SCAN, "--pattern", RINGS, *COARSE, "--set", "scan.front=+y", "--set", "scan.left_side=plus_x",
                        f"--reference={REFERENCE}", "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        for file in self.out.iterdir():
            self.assertEqual(file.read_bytes(), (out / file.name).read_bytes(), file.name)

    def test_a_bad_reference_is_refused_before_any_work(self):
        for word, text in (("run", "x" * 65), ("run", "a\nb"), ("submit", "x" * 65)):
            server = ["--server", self.server.url] if word == "submit" else ["--out", self.folder / "none"]
            done = vacuform(word, *server, "--scan", SCAN, "--pattern", RINGS, "--reference", text)
            self.assertEqual(done.returncode, 2)
            self.assertIn("reference", done.stderr)
            self.assertNotIn(text, done.stderr)
        self.assertFalse((self.folder / "none").exists())

    def test_downloads_are_named_after_it(self):
        place = f"{self.server.api}/jobs/{self.job['id']}"
        self.assertEqual(curl(place + "/artifacts/print.pdf").headers["content-disposition"],
                         "inline; filename=\"K-ln-2-7-outer-print.pdf\"; "
                         "filename*=UTF-8''K%C3%B6ln%20%282%29%20-%26-%20%5B7%5D-outer-print.pdf")
        self.assertIn('filename="K-ln-2-7-artifacts.zip"', curl(place + "/artifacts.zip").headers["content-disposition"])

    def test_no_log_holds_it(self):
        log = pathlib.Path(self.folder / "server.log").read_text()
        self.assertIn("job-completed", log)
        lines = curl(f"{self.server.api}/jobs/{self.job['id']}/log").json["lines"]
        for text in (log, json.dumps(lines, ensure_ascii=False)):
            self.assertNotIn("ln (2)", text)
            self.assertNotIn("urgent", text)

    def test_the_confirmed_side_is_in_the_report(self):
        report = self.report(self.out)
        self.assertEqual(report["scan"]["left_side"], "plus_x")
        self.assertIn("left is at +x, confirmed by a person", (self.out / "report.html").read_text())
        warning = next(w for w in report["warnings"] if w["code"] == "mirrored-or-turned")
        self.assertEqual(warning["severity"], "warning")
        # It changes neither mold nor sheet: both are kept for the next job.
        body = json.dumps({"from": self.job["id"], "settings": {"scan": {"left_side": "minus_x"}}})
        other = self.server.wait(curl("-H", "Content-Type: application/json", "-d", body, self.server.api + "/jobs").json["id"])
        self.assertEqual((other["state"], other["reference"], other["note"]), ("succeeded", REFERENCE, ""))
        lines = [line["text"] for line in curl(f"{self.server.api}/jobs/{other['id']}/log").json["lines"]]
        self.assertIn("stage forming cached", lines)
        self.assertNotIn("warning mirrored-or-turned", lines)


if __name__ == "__main__":
    unittest.main()
