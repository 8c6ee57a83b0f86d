"""`vacuform-server copy-store`: a service with a finished job moves to PostgreSQL and an object store and back, a copy is
cancelled, and refusals."""
import json
import os
import signal
import subprocess
import time
import unittest

import made_scans
from harness import BIN, Case, Server, curl, wait_for
from object_store import Swift
from postgres import Postgres


class CopyStore(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.postgres = cls.enterClass(Postgres())
        cls.objects = cls.enterClass(Swift())

    def words(self, *words):
        return [BIN / "vacuform-server", *map(str, words)]

    def command(self, *words):
        return subprocess.run(self.words(*words), capture_output=True, text=True, env={**os.environ, **self.objects.environment})

    def inspection(self, server, key):
        return curl("-H", f"Idempotency-Key: {key}", "-F", f"scan=@{made_scans.newborn()}", "-F", "kind=inspection",
                    server.api + "/jobs")

    def service(self, name, workers=0, options=()):
        (self.folder / name).mkdir(exist_ok=True)
        return Server(self.folder / name, workers, options)

    def findings(self, server, job):
        found = curl(f"{server.api}/jobs/{job}/artifacts/findings.json")
        self.assertEqual(found.status, 200, found)
        return found.body

    def test_a_service_moves_to_postgresql_and_an_object_store_and_back(self):
        key = self.folder / "key"
        secret = self.objects.environment
        key.write_text(f"aws_access_key_id = {secret['AWS_ACCESS_KEY_ID']}\n"
                       f"aws_secret_access_key = {secret['AWS_SECRET_ACCESS_KEY']}\n")
        key.chmod(0o600)
        places = ["--store", self.postgres.url, "--blobs", self.objects.url, "--blobs-credentials", key]
        there = ["--to-store", self.postgres.url, "--to-blobs", self.objects.url, "--to-blobs-credentials", key]
        with self.service("old", workers=1) as old:
            done = self.inspection(old, "the-first-job").json["id"]
            self.assertEqual(old.wait(done)["state"], "succeeded")
            before = self.findings(old, done)
            refused = self.command("copy-store", "--data", old.data, "--to", self.folder / "new" / "data", *there)
            self.assertEqual(refused.returncode, 1, refused.stdout)
            self.assertIn("another server uses this data folder", refused.stderr)
            self.assertIn("stop it", refused.stderr)
        new = self.service("new", 1, places)
        copied = self.command("copy-store", "--data", old.data, "--to", new.data, *there)
        self.assertEqual(copied.returncode, 0, copied.stderr)
        report = json.loads(copied.stdout)
        self.assertEqual((report["jobs"], report["damaged"]), (1, []))
        objects = [key for key in self.objects.keys() if "/" not in key]
        self.assertEqual(len(objects), report["files"] + 1)  # and the mark of the bucket
        with new:
            self.assertEqual(self.findings(new, done), before)
            self.assertEqual(self.inspection(new, "the-first-job").json["id"], done)  # the same client's request
            later = self.inspection(new, "the-second-job").json["id"]
            self.assertGreater(later, done)
            self.assertEqual(new.wait(later)["state"], "succeeded")
            tokens = curl(new.api + "/tokens").json["tokens"]
            self.assertEqual(sum(t["scopes"] == ["admin"] and not t["revoked"] for t in tokens), 1)
            self.assertEqual(sum(t["scopes"] == ["work"] and not t["revoked"] for t in tokens), 2)
        again = self.command("copy-store", "--data", old.data, "--to", new.data, *there)
        self.assertEqual(again.returncode, 2)
        self.assertIn("the target is not empty: it has rows in the table job", again.stderr)
        back = self.service("back")
        returned = self.command(*places, "copy-store", "--data", new.data, "--to", back.data)
        self.assertEqual(returned.returncode, 0, returned.stderr)
        self.assertEqual(json.loads(returned.stdout)["jobs"], 2)
        with back:
            self.assertEqual(self.findings(back, done), before)
            self.assertEqual({j["id"] for j in back.jobs()}, {done, later})

    def test_a_copy_that_is_cancelled_ends_soon_and_can_be_repeated(self):
        with self.service("source") as source:
            self.assertEqual(self.inspection(source, "a-job-that-waits").status, 202)
        target = self.folder / "target"
        words = ["copy-store", "--data", source.data, "--to", target, "--to-blobs", self.objects.url.replace("?", "/cancelled?")]
        for process in self.objects.processes:  # an object store that does not answer
            os.killpg(process.pid, signal.SIGSTOP)
        copy = subprocess.Popen(self.words(*words), stderr=subprocess.PIPE, text=True,
                                env={**os.environ, **self.objects.environment})
        wait_for(target.exists, "the begin of the copy")
        time.sleep(1)
        started = time.monotonic()
        copy.terminate()
        said = copy.communicate()[1]
        seconds = time.monotonic() - started
        for process in self.objects.processes:
            os.killpg(process.pid, signal.SIGCONT)
        self.assertEqual(copy.returncode, 130, said)
        self.assertIn("the copy was cancelled; nothing was changed at the target", said)
        self.assertLess(seconds, 4)
        repeated = self.command(*words)
        self.assertEqual(repeated.returncode, 0, repeated.stderr)
        self.assertEqual(json.loads(repeated.stdout)["jobs"], 1)


if __name__ == "__main__":
    unittest.main()
