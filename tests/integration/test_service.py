"""The real server and its workers, driven by curl: scans of many kinds, downloads, cancelling, deleting, the page."""
import concurrent.futures
import hashlib
import html
import io
import json
import re
import time
import unittest
import zipfile

import hostile
import made_scans
from harness import ARRAY_ARTIFACTS, PATTERNS, Case, Server, curl, vacuform, wait_for

NEWBORN, CORRUPT, RINGS = made_scans.newborn(), made_scans.corrupt(), PATTERNS / "rings-7x40mm.svg"
COARSE = {"sheet": {"resolution_mm": 5}, "print": {"dpi": 100}}
FINE = {"sheet": {"resolution_mm": 1}}  # long enough to be interrupted


def coarse(**groups):
    return {**COARSE, **groups}


class Service(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = cls.enterClass(Server(cls.folder))
        cls.newborn = cls.server.submit(NEWBORN, RINGS, COARSE)

    def finished(self):
        job = self.server.wait(self.newborn)
        self.assertEqual(job["state"], "succeeded", job["problem"])
        return job

    def artifact(self, name, *words):
        return curl(*words, f"{self.server.api}/jobs/{self.newborn}/artifacts/{name}")

    def test_job_says_what_was_asked_and_what_came_out(self):
        job = self.finished()
        self.assertEqual([a["name"] for a in job["artifacts"]], ARRAY_ARTIFACTS)
        self.assertEqual((job["progress"], job["attempt"], job["problem"]), (1, 1, None))
        self.assertEqual(job["settings"]["sheet"]["resolution_mm"], 5)
        self.assertEqual(job["settings"]["print"]["marks"], True)
        self.assertLessEqual(job["created"], job["started"])
        self.assertLessEqual(job["started"], job["ended"])
        scan = NEWBORN.read_bytes()
        nameless = b" " * 80 + scan[80:]  # the header of an STL file is free text
        self.assertEqual(job["inputs"]["scan"]["sha256"], hashlib.sha256(nameless).hexdigest())
        self.assertEqual(job["inputs"]["scan"]["bytes"], len(scan))
        self.assertEqual(curl(f"{self.server.api}/jobs/{self.newborn}/artifacts").json["artifacts"], job["artifacts"])

    def test_artifacts_are_those_of_the_command_line_byte_for_byte(self):
        out = self.folder / "run"
        done = vacuform("run", "--scan", NEWBORN, "--pattern", RINGS, "--out", out, "--set",
                        "sheet.resolution_mm=5", "--set", "print.dpi=100")
        self.assertEqual(done.returncode, 0, done.stderr)
        for a in self.finished()["artifacts"]:
            with self.subTest(a["name"]):
                answer = self.artifact(a["name"])
                self.assertEqual(answer.status, 200)
                self.assertEqual(answer.headers["content-type"], a["media_type"])
                self.assertEqual(len(answer.body), a["bytes"])
                self.assertEqual(hashlib.sha256(answer.body).hexdigest(), a["sha256"])
                self.assertEqual(answer.headers["etag"], f'"{a["sha256"]}"')
                self.assertEqual(answer.body, (out / a["name"]).read_bytes())

    def test_ranges_and_etags(self):
        self.finished()
        whole = self.artifact("mold.stl")
        part = self.artifact("mold.stl", "-r", "80-83")
        self.assertEqual((part.status, part.body), (206, whole.body[80:84]))
        self.assertEqual(part.headers["content-range"], f"bytes 80-83/{len(whole.body)}")
        self.assertEqual(self.artifact("mold.stl", "-r", "-7").body, whole.body[-7:])
        self.assertEqual(self.artifact("mold.stl", "-r", f"{len(whole.body) - 3}-").body, whole.body[-3:])
        self.assertEqual(self.artifact("mold.stl", "-r", f"{len(whole.body)}-").status, 416)
        etag = whole.headers["etag"]
        known = self.artifact("mold.stl", "-H", f"If-None-Match: {etag}")
        self.assertEqual((known.status, known.body), (304, b""))
        same = self.artifact("mold.stl", "-r", "0-3", "-H", f"If-Range: {etag}")
        self.assertEqual((same.status, len(same.body)), (206, 4))
        other = self.artifact("mold.stl", "-r", "0-3", "-H", 'If-Range: "other"')
        self.assertEqual((other.status, len(other.body)), (200, len(whole.body)))
        head = self.artifact("mold.stl", "-I")
        self.assertEqual((head.status, head.headers["content-length"]), (200, str(len(whole.body))))

    def test_zip_holds_the_same_bytes(self):
        job = self.finished()
        answer = curl(f"{self.server.api}/jobs/{self.newborn}/artifacts.zip")
        self.assertEqual((answer.status, answer.headers["content-type"]), (200, "application/zip"))
        with zipfile.ZipFile(io.BytesIO(answer.body)) as archive:
            self.assertIsNone(archive.testzip())
            self.assertEqual({i.filename.rpartition("/")[2]: hashlib.sha256(archive.read(i)).hexdigest()
                              for i in archive.infolist()}, {a["name"]: a["sha256"] for a in job["artifacts"]})

    def test_submit_does_the_same_through_the_server(self):
        out = self.folder / "submitted"
        done = vacuform("submit", "--server", self.server.url, "--scan", NEWBORN, "--pattern", RINGS,
                        "--set", "sheet.resolution_mm=5", "--set", "print.dpi=100", "--wait", "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, rf"\A{re.escape(self.server.api)}/jobs/\w+\nPrint \w+, for the outer face")
        self.assertTrue(done.stdout.endswith(f"Files: {out} (print.svg, print.pdf and print.png; begin with report.html)\n"), done.stdout)
        self.assertEqual({p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in out.iterdir()},
                         {a["name"]: a["sha256"] for a in self.finished()["artifacts"]})
        again = self.folder / "again"
        done = vacuform("submit", "--server", self.server.url, "--token-file", self.server.token_file, "--job", self.newborn, "--wait", "--out", again)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(sorted(p.name for p in again.iterdir()), sorted(ARRAY_ARTIFACTS))

    def test_submit_passes_a_refusal_on(self):
        done = vacuform("submit", "--server", self.server.url, "--scan", CORRUPT, "--pattern", RINGS,
                        "--wait", "--out", self.folder / "refused")
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr.splitlines()[-1], r"\Avacuform: .+; .+")
        self.assertFalse((self.folder / "refused").exists())

    def test_names_in_files_are_kept_nowhere(self):
        name = b"JaneDoe1984"
        scans = {"stl": hostile.stl(hostile.dome_triangles(), header=b"scan of " + name),
                 "obj": b"# " + name + b"\no " + name + b"\n" + hostile.obj()}
        jobs = []
        for extension, scan in scans.items():
            file = self.folder / f"{name.decode()}.{extension}"
            file.write_bytes(scan)
            pattern = self.folder / f"{name.decode()}.png"
            rows = b"".join(b"\0" + (b"\xf0" * 13 if y % 20 < 10 else b"\xff" * 13) for y in range(100))
            pattern.write_bytes(hostile.png(100, 100, rows=rows, extra=hostile.chunk(b"tEXt", b"Author\0" + name)))
            jobs.append(self.server.submit(file, pattern, {**COARSE, "pattern": {"width_mm": 60}}))
        for job in jobs:
            self.assertEqual(self.server.wait(job)["state"], "succeeded", self.server.job(job)["problem"])
        for path in [p for p in self.server.data.rglob("*") if p.is_file()]:
            self.assertNotIn(name, path.read_bytes(), path)
        for job in jobs:
            with zipfile.ZipFile(io.BytesIO(curl(f"{self.server.api}/jobs/{job}/artifacts.zip").body)) as archive:
                for artifact in archive.namelist():
                    self.assertNotIn(name, archive.read(artifact), artifact)
        self.assertNotIn(name.decode(), self.server.program.says())

    def test_cancel_ends_forming_within_two_seconds(self):
        job = self.server.submit(NEWBORN, RINGS, FINE)
        self.server.wait(job, lambda j: j["stage"] == "forming" and j["stage_progress"] > 0, "forming")
        asked = time.monotonic()
        self.assertIn(curl("-X", "POST", f"{self.server.api}/jobs/{job}/cancel").json["state"], ("cancelling", "cancelled"))
        ended = wait_for(lambda: self.server.job(job)["state"] == "cancelled", "the end of a cancelled job")
        self.assertTrue(ended)
        self.assertLess(time.monotonic() - asked, 2.0)
        self.assertEqual(self.server.job(job)["artifacts"], [])
        again = curl("-X", "POST", f"{self.server.api}/jobs/{job}/cancel")
        self.assertEqual((again.status, again.json["state"]), (200, "cancelled"))

    def files_kept(self, sha256):
        return [p for p in self.server.data.rglob("*") if sha256 in p.name]

    def test_delete_takes_everything_away(self):
        scan = self.folder / "of-this-test-alone.stl"
        scan.write_bytes(hostile.stl(hostile.dome_triangles(1.03)))
        job = self.server.submit(scan, RINGS, COARSE)
        ended = self.server.wait(job)
        self.assertEqual(ended["state"], "succeeded")
        # Neither the pattern nor files made from it alone: other jobs have the same.
        shared = {"formed.mtl", "preview-pattern.png"}
        files = [file["sha256"] for file in [*ended["artifacts"], ended["inputs"]["scan"]] if file.get("name") not in shared]
        self.assertEqual(len(files), len(ARRAY_ARTIFACTS) - 1)
        for sha256 in files:
            self.assertEqual(len(self.files_kept(sha256)), 1)
        self.assertEqual(curl("-X", "DELETE", f"{self.server.api}/jobs/{job}").status, 204)
        for tail in "", "/artifacts", "/artifacts/report.json", "/artifacts.zip":
            answer = curl(f"{self.server.api}/jobs/{job}{tail}")
            self.assertEqual((answer.status, answer.json["type"]), (404, "/problems/not-found"))
        self.assertNotIn(job, [j["id"] for j in self.server.jobs()])
        for sha256 in files:
            self.assertEqual(self.files_kept(sha256), [])

    def test_running_job_is_not_deleted(self):
        job = self.server.submit(NEWBORN, RINGS, FINE)
        self.server.wait(job, lambda j: j["state"] == "running", "a worker")
        answer = curl("-X", "DELETE", f"{self.server.api}/jobs/{job}")
        self.assertEqual((answer.status, answer.json["type"]), (409, "/problems/conflict"))
        self.assertTrue(answer.json["fix"])
        curl("-X", "POST", f"{self.server.api}/jobs/{job}/cancel")
        self.assertEqual(self.server.wait(job)["state"], "cancelled")

    def test_list_is_paged_newest_first(self):
        made = [self.server.submit(CORRUPT, RINGS) for _ in range(5)]
        ids, cursor = [], ""
        while True:
            page = curl(f"{self.server.api}/jobs?limit=2{cursor}").json
            self.assertLessEqual(len(page["jobs"]), 2)
            ids += [j["id"] for j in page["jobs"]]
            if not page["next"]:
                break
            cursor = "&cursor=" + page["next"]
        self.assertEqual(len(ids), len(set(ids)))
        self.assertEqual([i for i in ids if i in made], made[::-1])
        self.assertIn(self.newborn, ids)
        for limit in "0", "101", "many":
            answer = curl(f"{self.server.api}/jobs?limit={limit}")
            self.assertEqual((answer.status, answer.json["type"]), (400, "/problems/bad-usage"))

    def test_plain_pages_work_without_javascript(self):
        answer = curl(f"-Fscan=@{NEWBORN}", f"-Fpattern=@{RINGS}", "-F", "sheet.resolution_mm=5", "-F", "print.dpi=100", self.server.api + "/jobs")
        self.assertEqual(answer.status, 202, answer)
        front = curl(self.server.url + "/jobs")
        self.assertEqual(front.status, 200)
        page = front.body.decode()
        self.assertNotIn("<script", page)
        self.assertIn(f'href="/jobs/{answer.json["id"]}"', page)
        where = f"{self.server.url}/jobs/{answer.json['id']}"

        def finished():
            text = curl(where).body.decode()
            return None if 'http-equiv="refresh"' in text else text  # the page updates automatically
        text = wait_for(finished, "the job's last page")
        pictures = [html.unescape(src) for src in re.findall(r'<img[^>]*src="([^"]+)"', text)]
        self.assertEqual(len([p for p in pictures if "/preview-" in p]), 11)
        self.assertTrue(all(re.search(r'alt="[^"]+"', img) for img in re.findall(r"<img[^>]*>", text)))
        for picture in pictures:
            self.assertEqual(curl(self.server.url + picture).body[:8], b"\x89PNG\r\n\x1a\n")
        for name in ARRAY_ARTIFACTS:
            self.assertIn(f"/artifacts/{name}\"", text)

    def test_refusal_says_what_was_wrong(self):
        answer = curl(f"-Fscan=@{NEWBORN}", f"-Fpattern=@{RINGS}", "-F", "print.dpi=7", self.server.api + "/jobs")
        self.assertEqual((answer.status, answer.json["what"], answer.json["where"]), (422, "out of range: 7", "print.dpi"))
        self.assertIn("72 to 1200", answer.json["fix"])


class Scans(Case):
    """Every scan is either formed, or refused with a message that says what to do; the test then does that."""

    SCANS = {"newborn.stl": made_scans.newborn, "adult.stl": made_scans.adult, "bust.obj": made_scans.bust,
             "damaged": made_scans.damaged, "figurine.stl": made_scans.figurine, "corrupt-head.glb": made_scans.corrupt}
    # The expected ends of the first attempt at default scan settings: no problem, or these types of problem in turn.
    REFUSALS = {"bust.obj": ["ambiguous-units"],  # it is implausible in every unit
                "corrupt-head.glb": ["corrupt-file"]}
    HEADS = {"newborn.stl", "adult.stl"}  # meet the gap limit with triangles of 5 mm; a figurine does not

    def follow(self, server, scan, settings):
        """Submits, follows the first proposal of each refusal, and returns the last job with the slugs of the refusals."""
        slugs = []
        while True:
            job = server.wait(server.submit(scan, RINGS, settings))
            if job["state"] == "succeeded":
                return job, slugs
            problem = job["problem"]
            self.assertEqual(job["state"], "failed", scan)
            self.assertTrue(problem["what"] and problem["where"] and problem["fix"], problem)
            slugs.append(problem["type"].removeprefix("/problems/"))
            kept = ["preview-findings.png", "mold.stl", "findings.json"] if slugs[-1] == "forming-failed" else []
            self.assertEqual([a["name"] for a in job["artifacts"]], kept)
            if slugs[-1] == "ambiguous-units":
                self.assertNotIn("scan.size_mm=", problem["fix"])  # only a person can measure it
                settings.setdefault("scan", {})["size_mm"] = 200
            elif problem["proposals"] and len(slugs) <= 3:
                for group, values in problem["proposals"][0]["set"].items():
                    settings.setdefault(group, {}).update(values)
            else:
                return job, slugs

    def test_every_scan(self):
        scans = {}
        for name, scan in self.SCANS.items():
            with self.subTest(name):
                scans[name] = scan()
        with Server(self.folder) as server, concurrent.futures.ThreadPoolExecutor(2) as pool:
            ends = dict(zip(scans, pool.map(lambda s: self.follow(server, s, json.loads(json.dumps(COARSE))), scans.values())))
            for scan, (job, slugs) in ends.items():
                with self.subTest(scan):
                    self.assertEqual(slugs, self.REFUSALS.get(scan, []), job["problem"])
                    if scan == "corrupt-head.glb":
                        self.assertIn("text-mode copy", job["problem"]["what"])
                        continue
                    self.assertEqual([a["name"] for a in job["artifacts"]], ARRAY_ARTIFACTS)
                    report = curl(f"{server.api}/jobs/{job['id']}/artifacts/report.json").json
                    self.assertTrue(report["forming"]["converged"])
                    self.assertLessEqual(report["forming"]["vertex_gap_mm"], 0.2)
                    fit = report["forming"]
                    if scan in self.HEADS:
                        self.assertLessEqual(fit["gap_mm"]["p99"], 0.2)
                    self.assertEqual("pierced" in {w["code"] for w in report["warnings"]}, fit["penetration_mm"]["max"] > 0.5)
                    for figure in "shape", "area":
                        self.assertLess(report["figures"]["with"][figure]["mean"],
                                        report["figures"]["without"][figure]["mean"])
            self.assertNotIn("head", server.program.says())  # the log names no file


if __name__ == "__main__":
    unittest.main()
