"""The service with its files in a real object store: from a scan to its findings, parts of a download, deletion, an object
store that dies in mid-job, and refusals."""
import hashlib
import json
import os
import signal
import subprocess
import time
import unittest

import made_scans
from faulty_relay import FaultyRelay
from harness import ARRAY_ARTIFACTS, BIN, PATIENCE, PATTERNS, Case, Server, curl, wait_for
from object_store import KEY_ID, SECRET, Swift


class OnObjects(Case):
    """A server whose files are in a real object store."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.store = cls.enterClass(Swift())
        cls.key = cls.folder / "key"
        cls.key.write_text(f"[default]\naws_access_key_id = {KEY_ID}\naws_secret_access_key = {SECRET}\n")
        cls.key.chmod(0o600)
        cls.server = cls.enterClass(Server(cls.folder, workers=1, options=["--blobs", cls.address(), "--blobs-credentials", cls.key]))

    @classmethod
    def address(cls):
        return cls.store.url

    def command(self, *words, environment=None):
        return subprocess.run([BIN / "vacuform-server", *map(str, words)], capture_output=True, text=True,
                              env={**os.environ, **(environment or {})})

    def objects(self):
        return {key for key in self.store.keys() if "." in key and "/" not in key}

    def hashes(self):
        return {key.partition(".")[0] for key in self.objects()}

    def download(self, job, artifact, *words):
        return curl(*words, f"{self.server.api}/jobs/{job}/artifacts/{artifact}")

    def refused_artifacts(self):
        return [line for line in self.server.program.says().splitlines()
                if '"request-failed"' in line and '"PUT"' in line and "/artifacts/" in line]

    def assert_whole(self, job):
        """Every artifact of the job is in the bucket, and a download has its bytes."""
        artifacts = {a["name"]: a for a in self.server.job(job)["artifacts"]}
        self.assertLessEqual({*ARRAY_ARTIFACTS}, set(artifacts))
        for name, artifact in artifacts.items():
            got = self.download(job, name)
            self.assertEqual(got.status, 200, got)
            self.assertEqual(hashlib.sha256(got.body).hexdigest(), artifact["sha256"], name)
        self.assertLessEqual({a["sha256"] for a in artifacts.values()}, self.hashes())


class InAnObjectStore(OnObjects):
    def test_a_job_runs_and_its_files_are_objects(self):
        job = self.server.submit(made_scans.newborn(), PATTERNS / "rings-7x40mm.svg")
        self.assertEqual(self.server.wait(job)["state"], "succeeded", self.server.job(job))
        self.assert_whole(job)
        self.assertFalse((self.server.data / "blobs").exists())
        self.assertEqual(list((self.server.data / "incoming").iterdir()), [])
        whole = self.download(job, "formed.ply").body
        self.assertGreater(len(whole), 1 << 20)  # read by ranges
        for first, last in ((0, 0), (1000, 70_000), (len(whole) - 10, len(whole) - 1)):
            part = self.download(job, "formed.ply", "-r", f"{first}-{last}")
            self.assertEqual((part.status, part.body), (206, whole[first:last + 1]))
        self.assertEqual(curl("-X", "DELETE", f"{self.server.api}/jobs/{job}").status, 204)
        self.assertEqual(self.download(job, "formed.ply").status, 404)

    def test_a_job_survives_an_object_store_that_dies(self):
        job = self.server.submit(made_scans.newborn(), PATTERNS / "rings-7x40mm.svg", {"print": {"dpi": 200}})
        self.server.wait(job, lambda j: j["state"] == "running" and j["progress"] > 0.1, "a job that has its inputs")
        self.store.kill()
        refused = self.server.post(made_scans.newborn(), PATTERNS / "rings-7x40mm.svg", {"print": {"dpi": 201}})
        self.assertEqual(refused.status, 503, refused)
        self.assertIn("the object store cannot be reached", refused.json["what"])
        wait_for(lambda: self.refused_artifacts(), "an artifact that cannot be stored")
        self.assertEqual(self.server.job(job)["state"], "running")
        self.store.start()
        self.assertEqual(self.server.wait(job)["state"], "succeeded", self.server.job(job))
        self.assert_whole(job)
        self.server.stop(signal.SIGKILL)
        self.server.start()
        self.assert_whole(job)

    def test_a_backup_is_a_store_of_files(self):
        sent = curl("-H", "Idempotency-Key: for-the-backup", "-F", f"scan=@{made_scans.newborn()}", "-F", "kind=inspection",
                    self.server.api + "/jobs")
        job = sent.json["id"]
        self.assertEqual(self.server.wait(job)["state"], "succeeded")
        copy = self.folder / "copy"
        saved = self.command("backup", "--data", self.server.data, "--to", copy)
        self.assertEqual(saved.returncode, 0, saved.stderr)
        folder = self.folder / "restored"
        folder.mkdir()
        copy.rename(folder / "data")
        with Server(folder, workers=0) as restored:
            found = curl(f"{restored.api}/jobs/{job}/artifacts/findings.json")
            self.assertEqual(found.status, 200, found)
        again = curl(f"{self.server.api}/jobs/{job}/artifacts/findings.json")
        self.assertEqual(found.body, again.body)

    def test_orphans_are_listed_and_deleted_while_the_server_runs(self):
        words = ["orphans", "--data", self.server.data]
        sent = curl("-H", "Idempotency-Key: beside-orphans", "-F", f"scan=@{made_scans.newborn()}", "-F", "kind=inspection",
                    self.server.api + "/jobs")
        self.assertEqual(self.server.wait(sent.json["id"])["state"], "succeeded")
        kept, orphan = self.objects(), hashlib.sha256(b"nobody knows it").hexdigest() + ".0123456789abcdef"
        self.store.request("PUT", "/" + orphan, "a lost scan")
        listed = self.command(*words)
        self.assertEqual(listed.returncode, 0, listed.stderr)
        self.assertEqual(json.loads(listed.stdout), {"objects": len(kept) + 1, "orphans": 0, "bytes": 0, "oldest": None,
                                                     "deleted": 0})
        time.sleep(2)  # the object store rounds times up to seconds
        found = curl("-H", "Content-Type: application/json", "-d", '{"older_than_hours": 0}', self.server.api + "/orphans")
        self.assertEqual((found.status, found.json["orphans"], found.json["bytes"]), (200, 1, 11), found)
        deleted = self.command(*words, "--older-than", "0", "--delete")
        self.assertEqual(json.loads(deleted.stdout)["deleted"], 1, deleted.stderr)
        self.assertIn('"event":"orphans-deleted"', self.server.program.says())
        self.assertEqual(self.objects(), kept)

    def test_orphans_are_deleted_while_no_server_runs(self):
        url = self.store.url.replace("?", "/at-rest?")
        places = ["--data", self.folder / "at-rest", "--blobs", url, "--blobs-credentials", self.key]
        made = self.command(*places, "token", "create", "--owner", "a", "--scopes", "read")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.store.request("PUT", f"/at-rest/{'a' * 64}.0123456789abcdef", "a lost scan")
        time.sleep(2)
        deleted = self.command(*places, "orphans", "--older-than", "0", "--delete")
        self.assertEqual(deleted.returncode, 0, deleted.stderr)
        report = json.loads(deleted.stdout)
        self.assertEqual((report["objects"], report["orphans"], report["deleted"]), (1, 1, 1))
        self.assertEqual([key for key in self.store.keys() if key.startswith("at-rest/")], ["at-rest/vacuform-store"])
        files = self.folder / "files"
        self.command("--data", files, "token", "create", "--owner", "a", "--scopes", "read")
        refused = self.command("orphans", "--data", files)
        self.assertEqual(refused.returncode, 2, refused.stdout)
        self.assertIn("there is no bucket", refused.stderr)

    def test_a_wrong_secret_is_refused_at_the_start_and_not_shown(self):
        data = self.folder / "refused"
        words = ["--data", data, "--listen", "127.0.0.1:0", "--blobs", self.store.url]
        done = self.command(*words, environment={"AWS_ACCESS_KEY_ID": KEY_ID, "AWS_SECRET_ACCESS_KEY": "open-sesame"})
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("the object store refuses the access key (SignatureDoesNotMatch)", done.stderr)
        self.assertNotIn("open-sesame", done.stdout + done.stderr)
        self.assertNotIn(SECRET, self.server.program.says())
        without = self.command(*words, environment={"AWS_ACCESS_KEY_ID": "", "AWS_SECRET_ACCESS_KEY": ""})
        self.assertEqual(without.returncode, 2)
        self.assertIn("there is no access key for the object store", without.stderr)

    def test_an_address_that_is_not_safe_is_refused(self):
        for url, what in (("s3://a?endpoint=http://s3.example.org", "refusing plain HTTP"),
                          ("s3://a?secret=open-sesame", "not a parameter of an object store: secret"),
                          ("/var/lib/blobs", "not a place for files")):
            done = self.command("--data", self.folder / "refused", "--blobs", url, "--check-config")
            self.assertEqual(done.returncode, 2, done.stdout)
            self.assertIn(what, done.stderr)
            self.assertNotIn("open-sesame", done.stdout + done.stderr)


class BehindARelay(OnObjects):
    """The object store is reached through a relay, which answers in its place while a fault lasts."""

    @classmethod
    def address(cls):
        cls.relay = cls.enterClass(FaultyRelay(cls.store.ports["proxy"]))
        return cls.store.url.replace(cls.store.endpoint, cls.relay.endpoint)

    def test_a_job_survives_faults_of_the_object_store(self):
        for number, (fault, what) in enumerate((("busy", "the object store"), ("refusing", "the object store refuses"),
                                                ("silent", "the object store"))):
            with self.subTest(fault):
                settings = {"print": {"dpi": 210 + number}}
                job = self.server.submit(made_scans.newborn(), PATTERNS / "rings-7x40mm.svg", settings)
                self.server.wait(job, lambda j: j["state"] == "running" and j["progress"] > 0.1, "a job that has its inputs")
                before = len(self.refused_artifacts())
                self.relay.begin(fault)
                started = time.monotonic()
                refused = self.server.post(made_scans.newborn(), PATTERNS / "rings-7x40mm.svg", {"print": {"dpi": 220 + number}})
                self.assertEqual(refused.status, 503, refused)
                self.assertIn(what, refused.json["what"])
                self.assertLess(time.monotonic() - started, PATIENCE)
                wait_for(lambda: len(self.refused_artifacts()) > before, "an artifact that cannot be stored")  # noqa: B023
                self.assertEqual(curl(self.server.api + "/jobs").status, 200)  # what needs no files goes on
                self.relay.end()
                self.assertEqual(self.server.wait(job)["state"], "succeeded", self.server.job(job))
                self.assert_whole(job)
                self.assertNotIn(SECRET, self.server.program.says())


if __name__ == "__main__":
    unittest.main()
