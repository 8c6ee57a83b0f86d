"""Jobs after the first: derived jobs that reuse stored stages, their log, and a backup of a service in use."""
import concurrent.futures
import json
import shutil
import subprocess
import unittest

import made_scans
from harness import BIN, PATTERNS, Case, Server, curl, vacuform, wait_for

RINGS = PATTERNS / "rings-7x40mm.svg"
SCAN = made_scans.newborn()
COARSE = {"sheet": {"resolution_mm": 6}, "print": {"dpi": 72}}
MOVED = {"pattern": {"offset_mm": [5, -3]}}


def log_of(server, job):
    """The whole log of a job, read in pages."""
    texts, after = [], 0
    while True:
        page = curl(f"{server.api}/jobs/{job}/log?limit=4&after={after}").json
        texts += [line["text"] for line in page["lines"]]
        if not page["lines"]:
            return texts
        after = page["next"]


class DerivedJobs(Case):
    def derive(self, server, job, settings):
        return curl("-H", "Content-Type: application/json", "-d", json.dumps({"from": job, "settings": settings}),
                    server.api + "/jobs")

    def test_a_moved_pattern_forms_no_head_again(self):
        server = Server(self.folder, workers=1)
        with server:
            first = server.submit(SCAN, RINGS, COARSE)
            self.assertEqual(server.wait(first)["state"], "succeeded")
            said = log_of(server, first)
            self.assertEqual(said[:2] + said[-1:], ["queued", "attempt 1 begins", "succeeded"])
            for stage in "scan", "forming", "flattening", "printing", "inspection":
                self.assertIn(f"stage {stage}", said)
            self.assertNotIn("stage scan cached", said)
            self.assertTrue(all(w.startswith("warning ") for w in said[said.index("stage inspection") + 1:-1]), said)
        with server:  # stored stages survive the service and its workers
            answer = self.derive(server, first, MOVED)
            self.assertEqual(answer.status, 202, answer)
            second = server.wait(answer.json["id"])
            self.assertEqual(second["state"], "succeeded", second["problem"])
            self.assertEqual(second["derived_from"], first)
            said = log_of(server, second["id"])
            self.assertIn("stage scan cached", said)
            self.assertIn("stage forming cached", said)
            self.assertNotIn("stage forming", said)
            self.assertIn("stage printing", said)
            sheets = [next(a["sha256"] for a in server.job(j)["artifacts"] if a["name"] == "print.png")
                      for j in (first, second["id"])]
            self.assertNotEqual(*sheets)

            # The command line does the same, and its results equal those of a run without stored stages.
            done = vacuform("submit", "--server", server.url, "--from", first, "--set", "pattern.offset_mm=[5,-3]",
                            "--wait", "--out", self.folder / "kept")
            self.assertEqual(done.returncode, 0, done.stderr)
            fresh = vacuform("run", "--scan", SCAN, "--pattern", RINGS, "--out", self.folder / "fresh",
                             *[w for k in ("sheet.resolution_mm=6", "print.dpi=72", "pattern.offset_mm=[5,-3]") for w in ("--set", k)])
            self.assertEqual(fresh.returncode, 0, fresh.stderr)
            self.assertEqual((self.folder / "kept" / "print.svg").read_bytes(), (self.folder / "fresh" / "print.svg").read_bytes())

            # A head is stored as long as a job names its scan, for its owner only.
            kept = list((server.data / "workers" / "cache").iterdir())
            self.assertEqual(len(kept), 1)
            self.assertRegex(kept[0].name, "^[0-9a-f]{64}$")
            self.assertNotEqual(kept[0].name, second["inputs"]["scan"]["sha256"])  # reveals neither scan nor owner
            self.assertEqual(kept[0].stat().st_mode & 0o777, 0o700)

            # A job of another owner with the same scan finds none of these stages, and adds none to them.
            made = curl("-d", '{"owner":"other","scopes":["submit","read"]}', "-H", "Content-Type: application/json", f"{server.api}/tokens").json
            other = ["-H", "Authorization: Bearer " + made["token"]]
            third = server.post(SCAN, RINGS, {"sheet": {"resolution_mm": 6}, "print": {"dpi": 72}}, *other).json["id"]
            self.assertEqual(server.wait(third)["state"], "succeeded")
            self.assertNotIn("stage scan cached", log_of(server, third))
            self.assertEqual(len(list((server.data / "workers" / "cache").iterdir())), 2)
            self.assertEqual(curl("-X", "DELETE", f"{server.api}/jobs/{third}").status, 204)
            wait_for(lambda: list((server.data / "workers" / "cache").iterdir()) == kept, "the end of what was kept for the other owner")
            jobs = [j["id"] for j in server.jobs()]
            for job in jobs:
                self.assertTrue(kept[0].exists())
                self.assertEqual(curl("-X", "DELETE", f"{server.api}/jobs/{job}").status, 204)
            wait_for(lambda: not kept[0].exists(), "the end of what was kept")

    def test_a_job_of_nobody_is_no_beginning(self):
        with Server(self.folder, workers=0) as server:
            done = vacuform("submit", "--server", server.url, "--from", "01nobody")
            self.assertEqual(done.returncode, 2)
            self.assertIn("there is no such job", done.stderr)


class Backups(Case):
    def backup(self, server, to):
        return subprocess.run([BIN / "vacuform-server", "backup", "--data", server.data, "--to", to], capture_output=True, text=True)

    def test_a_copy_made_under_load_is_a_whole_service(self):
        (self.folder / "restored").mkdir()
        scan, pattern = self.folder / "a.stl", self.folder / "p.svg"
        scan.write_text("solid")
        pattern.write_text("<svg/>")
        with Server(self.folder, workers=0) as server:
            before = [server.submit(scan, pattern) for _ in range(5)]
            with concurrent.futures.ThreadPoolExecutor(4) as threads:
                def load(number):
                    job = server.submit(scan, pattern, {"pattern": {"rotate_deg": number}})
                    curl("-X", "POST", f"{server.api}/jobs/{job}/cancel")
                    curl("-X", "DELETE", f"{server.api}/jobs/{job}")
                    return {job, server.submit(scan, pattern)}
                running = [threads.submit(load, n) for n in range(24)]
                made = self.backup(server, self.folder / "restored" / "data")
                during = set().union(*(r.result() for r in running))
            self.assertEqual(made.returncode, 0, made.stderr)
            self.assertEqual(json.loads(made.stdout)["damaged"], [])
            again = self.backup(server, self.folder / "restored" / "data")
            self.assertEqual(again.returncode, 2)
            self.assertIn("not an empty private folder", again.stderr)
        # The copy contains tokens but no secrets: a client that has a token can use it on the copy.
        shutil.copy(server.token_file, self.folder / "restored" / "data")
        with Server(self.folder / "restored", workers=0) as copy:
            found = {j["id"]: j for j in copy.jobs()}
            self.assertEqual(len(found), json.loads(made.stdout)["jobs"])
            self.assertLessEqual(set(before), set(found))
            self.assertEqual({found[j]["state"] for j in before}, {"queued"})
            self.assertEqual(copy.job(before[0])["inputs"]["scan"]["bytes"], 5)
            self.assertLessEqual(set(found), during | set(before))
            later = copy.submit(scan, pattern)
            self.assertGreater(later, max(found))

    def test_a_service_at_rest_is_copied_too(self):
        (self.folder / "copy").mkdir()
        server = Server(self.folder, workers=0)
        with server:
            pass
        made = self.backup(server, self.folder / "copy" / "data")
        self.assertEqual(made.returncode, 0, made.stderr)


if __name__ == "__main__":
    unittest.main()
