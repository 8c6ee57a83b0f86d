"""Two servers behind the real nginx, on one PostgreSQL with a standby and one bucket of a real object store: uploads, events and
long polls continue on the other server, and nothing that was accepted is lost or ends twice while servers and workers are
killed and the database fails over.

VACUFORM_KILLS changes how many times one of them is killed.
"""
import collections
import hashlib
import json
import os
import random
import signal
import subprocess
import threading
import time
import unittest

import hostile
from harness import BIN, Case, Server, children, curl, wait_for
from object_store import KEY_ID, SECRET, Swift
from postgres import PostgresPair
from tls_front import TlsFront
from tus_uploads import LargeScan, ZippedScan, send

KILLS = int(os.environ.get("VACUFORM_KILLS", "6"))
VICTIMS = {"server": 3, "worker": 3, "database": 2}  # with the weight of each
SMALL = {"sheet": {"resolution_mm": 8, "width_mm": 150, "height_mm": 150},
         "machine": {"window_width_mm": 140, "window_height_mm": 140}, "print": {"dpi": 72}}
TUS = ("-H", "Tus-Resumable: 1.0.0")


class Replicas(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.postgres = cls.enterClass(PostgresPair())
        cls.objects = cls.enterClass(Swift())
        key = cls.folder / "key"
        key.write_text(f"[default]\naws_access_key_id = {KEY_ID}\naws_secret_access_key = {SECRET}\n")
        key.chmod(0o600)
        cls.front = TlsFront(cls.folder)
        options = ["--store", cls.postgres.url, "--blobs", cls.objects.url, "--blobs-credentials", key, "--front", cls.front.url,
                   "--lease-seconds", 5]
        cls.servers = []
        for name in ("one", "two"):
            (cls.folder / name).mkdir()
            cls.servers.append(cls.enterClass(Server(cls.folder / name, 2, options)))
        cls.one, cls.two = cls.servers
        cls.options = options
        cls.enterClass(cls.front.serve(cls.servers))
        cls.scan, cls.pattern = cls.folder / "dome.stl", cls.folder / "good.svg"
        cls.scan.write_bytes(hostile.stl(hostile.dome_triangles()))
        cls.pattern.write_bytes(hostile.GOOD_SVG)

    def begin(self, server, scan, name):
        answer = curl("-X", "POST", *TUS, "-H", f"Upload-Length: {scan.size}", "-H", f"Upload-Metadata: filename {name}",
                      server.api + "/uploads")
        self.assertEqual(answer.status, 201, answer)
        return answer.headers["location"]

    def offset(self, server, place):
        def look():
            answer = curl("-I", *TUS, server.url + place)
            return answer.headers["upload-offset"] if answer.status == 200 else None
        return int(wait_for(look, "the offset of an upload"))

    def test_an_upload_continues_on_another_server(self):
        scan = LargeScan()
        place = self.begin(self.one, scan, "YS5zdGw=")
        half = scan.size // 2
        self.assertIsNone(send(self.one, place, 0, half, scan))
        wait_for(lambda: self.offset(self.two, place) == half, "what the first server has received")
        self.one.stop(signal.SIGKILL)
        try:
            self.assertEqual(self.offset(self.two, place), half)
            self.assertIsNone(send(self.two, place, half, scan.size - 100, scan))
        finally:
            self.one.start()
        wait_for(lambda: self.offset(self.one, place) == scan.size - 100, "what the second server has received")
        self.assertEqual(send(self.two, place, half, scan.size, scan), 409)
        self.assertEqual(send(self.one, place, scan.size - 100, scan.size, scan), 204)
        for server in self.servers:
            whole = curl(server.url + place).json
            self.assertEqual((whole["offset"], whole["sha256"]), (scan.size, scan.sha256(b" " * 80)))
            self.assertEqual(list((server.data / "incoming").iterdir()), [])
        self.assertEqual(curl("-X", "DELETE", *TUS, self.two.url + place).status, 204)
        self.assertEqual(curl("-I", *TUS, self.one.url + place).status, 404)

    def test_a_zip_continues_on_another_server(self):
        scan = ZippedScan()
        place, half = self.begin(self.one, scan, "YS56aXA="), scan.size // 2
        self.assertIsNone(send(self.one, place, 0, half, scan))
        wait_for(lambda: self.offset(self.two, place) == half, "what the first server has received")
        self.assertEqual(send(self.two, place, half, scan.size, scan), 204)
        self.assertEqual(self.offset(self.one, place), scan.size)

    def test_a_job_is_followed_on_another_server(self):
        job = self.one.submit(self.scan, self.pattern, SMALL)
        seen = curl("-N", f"{self.two.api}/jobs/{job}/events")
        events = [dict(line.split(": ", 1) for line in block.splitlines() if ": " in line)
                  for block in seen.body.decode().split("\n\n") if "event: " in block]
        states = [json.loads(e["data"])["state"] for e in events if e["event"] == "job"]
        self.assertEqual(states[-1], "succeeded")
        lines = [json.loads(e["data"])["number"] for e in events if e["event"] == "log"]
        self.assertEqual(lines, list(range(lines[0], lines[0] + len(lines))))
        middle = events[len(events) // 2]["id"]
        rest = curl("-N", "-H", f"Last-Event-ID: {middle}", f"{self.one.api}/jobs/{job}/events").body.decode()
        later = [json.loads(line[6:])["number"] for block in rest.split("\n\n") if "event: log" in block
                 for line in block.splitlines() if line.startswith("data: ")]
        self.assertEqual(later, [n for e in events[len(events) // 2 + 1:] if e["event"] == "log" for n in [json.loads(e["data"])["number"]]])
        for server in self.servers:
            for artifact in server.job(job)["artifacts"]:
                got = curl(f"{server.api}/jobs/{job}/artifacts/{artifact['name']}").body
                self.assertEqual(hashlib.sha256(got).hexdigest(), artifact["sha256"], artifact["name"])

    def test_a_long_poll_hears_of_a_change_on_another_server(self):
        job = self.one.post(self.scan, self.pattern, SMALL, "-F", "priority=0").json["id"]
        self.one.wait(job, lambda j: j["state"] != "queued", "a lease")
        version = self.two.job(job)["version"]
        changed = curl("-H", f'If-None-Match: "{version}"', f"{self.two.api}/jobs/{job}?wait=60")
        self.assertEqual(changed.status, 200, changed)  # after 60 s without a change it is 304
        self.assertGreater(changed.json["version"], version)
        self.two.wait(job)

    def test_the_tables_are_brought_up_to_date_beside_servers_that_run(self):
        done = subprocess.run([BIN / "vacuform-server", *map(str, self.options), "migrate", "--data", self.folder / "migrate"],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        version = int(self.postgres.answer("SELECT version FROM vacuform_tables"))
        self.assertEqual(json.loads(done.stdout), {"schema": version})
        self.assertEqual(self.one.wait(self.two.submit(self.scan, self.pattern, SMALL))["state"], "succeeded")

    def test_both_servers_say_that_the_database_is_away_and_recover(self):
        self.postgres.primary.end(signal.SIGKILL)
        for server in self.servers:
            self.assertEqual(curl(f"{server.api}/jobs").status, 503)
        self.assertEqual(self.front.ask("/api/v1/jobs").status, 503)
        self.postgres.primary.start()
        for server in self.servers:
            wait_for(lambda: curl(f"{server.api}/jobs").status == 200, "a server that has its database again")  # noqa: B023
        job = self.two.submit(self.scan, self.pattern, SMALL)
        self.assertEqual(self.one.wait(job)["state"], "succeeded")

    def kill_one(self, what):
        server = random.choice(self.servers)
        if what == "database":
            self.postgres.fail_over()
        elif what == "worker":
            os.kill(wait_for(lambda: children(server.program.pid), "a worker")[0], signal.SIGKILL)
        else:
            server.stop(signal.SIGKILL)
            time.sleep(random.uniform(0, 1))
            server.start()

    def test_nothing_accepted_is_lost_or_ends_twice_while_servers_workers_and_the_database_are_killed(self):
        accepted, refusals, ending = {}, set(), threading.Event()

        def submit():
            number = 0
            while not ending.is_set():
                number += 1
                key = f"replicas-job-{number}"
                while key not in accepted.values() and not ending.is_set():
                    try:
                        answer = self.front.ask("/api/v1/jobs", "-H", f"Idempotency-Key: {key}", "-F", f"reference={key}",
                                                "-F", f"scan=@{self.scan}", "-F", f"pattern=@{self.pattern}",
                                                "-F", "settings=" + json.dumps(SMALL))
                    except ConnectionError:
                        continue
                    if answer.status == 202:
                        accepted[answer.json["id"]] = key
                    else:
                        refusals.add(answer.status)
                        time.sleep(0.2)
                time.sleep(0.5)

        submitting = threading.Thread(target=submit)
        submitting.start()
        random.seed(1)
        killed = []
        for number in range(KILLS):
            time.sleep(random.uniform(0.5, 4))
            killed += [*VICTIMS][number:number + 1] or random.choices([*VICTIMS], VICTIMS.values())  # each at least once
            self.kill_one(killed[-1])
        ending.set()
        submitting.join()
        self.assertLessEqual(refusals, {429, 503})
        self.assertGreater(len(accepted), KILLS)
        made = [job["reference"] for job in self.two.jobs() if job["reference"].startswith("replicas-job-")]
        self.assertEqual(len(made), len(set(made)))
        self.assertLessEqual(set(made) - set(accepted.values()), {f"replicas-job-{len(accepted) + 1}"})  # not answered at the end
        for job in accepted:
            self.assertEqual(self.one.wait(job)["state"], "succeeded", self.one.job(job))
        for job in accepted:
            log = [line["text"] for line in curl(f"{self.two.api}/jobs/{job}/log?limit=1000").json["lines"]]
            self.assertEqual(sum("succeeded" in line for line in log), 1, log)
            for artifact in self.two.job(job)["artifacts"]:
                got = curl(f"{self.two.api}/jobs/{job}/artifacts/{artifact['name']}").body
                self.assertEqual(hashlib.sha256(got).hexdigest(), artifact["sha256"], artifact["name"])
        print(f"{len(accepted)} jobs through {dict(collections.Counter(killed))}", flush=True)


if __name__ == "__main__":
    unittest.main()
