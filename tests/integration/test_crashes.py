"""What a killed or frozen worker and a killed server leave behind: nothing lost, nothing done twice, nothing half done."""
import hashlib
import json
import os
import pathlib
import signal
import socket
import unittest

import made_scans
from harness import ARRAY_ARTIFACTS, BIN, PATTERNS, Case, Program, Server, children, curl, runs, wait_for

NEWBORN, RINGS = made_scans.newborn(), PATTERNS / "rings-7x40mm.svg"
COARSE = {"sheet": {"resolution_mm": 5}, "print": {"dpi": 100}}
LONG = {"sheet": {"resolution_mm": 1.2}, "print": {"dpi": 100}}  # some seconds of forming: more than two heartbeats
LEASE = 4


class Crashes(Case):
    def setUp(self):
        self.here = self.folder / self._testMethodName
        self.here.mkdir()

    def server(self, workers=0, lease=LEASE):
        server = Server(self.here, workers, ["--lease-seconds", lease]).start()
        self.addCleanup(server.stop)
        return server

    def worker(self, server, name):
        worker = Program([BIN / "vacuform-worker", "--server", server.url, "--token-file", server.data / "worker-token",
                          "--name", name, "--work", self.here / "work", "--poll-seconds", "0.1"], self.here / f"{name}.log")
        self.addCleanup(worker.end)
        return worker

    def wait_forming(self, server, job, attempt=1):
        return server.wait(job, lambda j: j["attempt"] == attempt and j["stage"] == "forming" and j["stage_progress"] > 0,
                           "forming")

    def assert_one_whole_set(self, server, job):
        """Every artifact once, whole, and as the hash says."""
        found = server.job(job)
        names = [a["name"] for a in found["artifacts"]]
        self.assertEqual(sorted(names), sorted(ARRAY_ARTIFACTS))
        for a in found["artifacts"]:
            body = curl(f"{server.api}/jobs/{job}/artifacts/{a['name']}").body
            self.assertEqual(hashlib.sha256(body).hexdigest(), a["sha256"], a["name"])

    def blobs(self, server):
        """The files that hold uploads, whole or half, each with its digest."""
        return sorted((str(p), hashlib.sha256(p.read_bytes()).hexdigest())
                      for folder in ("blobs", "incoming") for p in (server.data / folder).rglob("*") if p.is_file())

    def events(self, program, event):
        return [e for e in map(json.loads, program.says().splitlines()) if e["event"] == event]

    def test_killed_worker_s_job_is_done_by_another_once(self):
        server = self.server()
        first = self.worker(server, "first")
        job = server.submit(NEWBORN, RINGS, LONG)
        self.wait_forming(server, job)
        (child,) = children(first.pid)
        first.end(signal.SIGKILL)
        wait_for(lambda: not runs(child), "the child's end")
        second = self.worker(server, "second")
        ended = server.wait(job)
        self.assertEqual((ended["state"], ended["attempt"]), ("succeeded", 2), ended["problem"])
        self.assert_one_whole_set(server, job)
        self.assertEqual([e["job"] for e in self.events(server.program, "job-completed")], [job])
        wait_for(lambda: self.events(second, "job-left"), "the worker's own last word")
        self.assertEqual([f.name for f in (self.here / "work").iterdir()], ["cache"])

    def test_frozen_worker_s_late_words_change_nothing(self):
        server = self.server()
        first = self.worker(server, "first")
        job = server.submit(NEWBORN, RINGS, LONG)
        self.wait_forming(server, job)
        (child,) = children(first.pid)
        first.send(signal.SIGSTOP)
        os.kill(child, signal.SIGSTOP)
        self.worker(server, "second")
        server.wait(job, lambda j: j["attempt"] == 2, "the second attempt")
        first.send(signal.SIGCONT)  # it wakes while the other one works
        os.kill(child, signal.SIGCONT)
        (left,) = wait_for(lambda: self.events(first, "job-left"), "the frozen worker's insight")
        self.assertEqual((left["job"], left["verdict"]), (job, "lost"))
        self.assertFalse(runs(child))
        ended = server.wait(job)
        self.assertEqual((ended["state"], ended["attempt"]), ("succeeded", 2), ended["problem"])
        self.assert_one_whole_set(server, job)
        self.assertEqual(len(self.events(server.program, "job-completed")), 1)

    def test_words_under_an_old_lease_are_refused(self):
        lease = 4 * LEASE  # this test keeps it by hand, on however busy a machine
        server = self.server(lease=lease)
        job = server.submit(NEWBORN, RINGS, COARSE)
        token = (server.data / "worker-token").read_text().strip()
        bearer, of_json = ["-H", f"Authorization: Bearer {token}"], ["-H", "Content-Type: application/json"]
        old = curl(*bearer, *of_json, "-d", '{"worker":"old","protocol":2}', f"{server.api}/leases").json
        self.assertEqual((old["job"], old["lease_seconds"]), (job, lease))
        server.wait(job, lambda j: j["state"] == "queued", "the end of the lease")
        ask = lambda: curl(*bearer, *of_json, "-d", '{"worker":"new","protocol":2}', f"{server.api}/leases")
        new = wait_for(lambda: (answer := ask()).status == 200 and answer, "the end of the job's rest").json
        self.assertEqual((new["job"], new["attempt"]), (job, 2))
        self.assertNotEqual(new["lease"], old["lease"])

        def say(lease, path, *words):
            return curl(*bearer, "-H", "Vacuform-Lease: " + lease["lease"], *words, f"{server.api}/leases/{job}/{path}")

        heartbeat = ("heartbeat", *of_json, "-d", '{"stage":"forming","progress":0.5}')
        puts = [("artifacts/" + name, "-H", "Content-Type: application/octet-stream", "-X", "PUT", "--data-binary")
                for name in sorted(ARRAY_ARTIFACTS)]
        complete = ("complete", *of_json, "-d", "{}")
        for put in puts:
            for words in heartbeat, (*put, old["lease"]), complete:
                answer = say(old, *words)
                self.assertEqual((answer.status, answer.json["type"]), (409, "/problems/lease-lost"))
            for words in heartbeat, (*put, new["lease"]):  # the heartbeat keeps the lease
                answer = say(new, *words)
                self.assertEqual(answer.status // 100, 2, answer)
        answer = say(new, *complete)
        self.assertEqual(answer.status // 100, 2, answer)
        self.assertEqual(curl(f"{server.api}/jobs/{job}/artifacts/report.json").body.decode(), new["lease"])
        self.assertEqual(curl(*of_json, "-d", '{"protocol":2}', f"{server.api}/leases").status, 403)  # the administrator is no worker

    def test_server_killed_during_an_upload_keeps_what_it_accepted_and_nothing_else(self):
        server = self.server()
        accepted = [server.submit(NEWBORN, RINGS, COARSE) for _ in range(3)]
        before = self.blobs(server)
        # Half an upload: the head promises more bytes than ever come, and the server holds what came on disk.
        boundary = "abc"
        part = (f'--{boundary}\r\nContent-Disposition: form-data; name="scan"; filename="half.stl"\r\n\r\n').encode()
        half = part + NEWBORN.read_bytes()
        with socket.create_connection(("127.0.0.1", server.port)) as connection:
            connection.sendall((f"POST /api/v1/jobs HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
                                f"Authorization: Bearer {server.token_file.read_text().strip()}\r\n"
                                f"Content-Type: multipart/form-data; boundary={boundary}\r\n"
                                f"Content-Length: {10 * len(half)}\r\n\r\n").encode() + half)
            incoming = str(server.data / "incoming")
            wait_for(lambda: any(str(fd.readlink()).startswith(incoming) and fd.stat().st_size > len(half) // 2  # has no name
                                 for fd in pathlib.Path(f"/proc/{server.program.pid}/fd").iterdir() if fd.is_symlink()),
                     "the half upload on disk")
            self.assertEqual(server.stop(signal.SIGKILL), -signal.SIGKILL)
        server.start()
        self.assertEqual([j["id"] for j in server.jobs()], accepted[::-1])
        self.assertEqual(self.blobs(server), before)
        self.worker(server, "one")
        self.worker(server, "two")
        for job in accepted:
            ended = server.wait(job)
            self.assertEqual((ended["state"], ended["attempt"]), ("succeeded", 1), ended["problem"])
            self.assert_one_whole_set(server, job)

    def test_a_browser_stays_signed_in_when_the_server_restarts(self):
        server = self.server()
        browser, other = server.sign_in(), server.sign_in()

        def session(of):
            return curl(*of, server.api + "/session")

        before = session(browser)
        self.assertEqual(before.status, 200, before)
        for number in (signal.SIGTERM, signal.SIGKILL):
            server.stop(number)
            server.start()
            self.assertEqual(session(browser).json, before.json)
        out = server.sign_out(browser)
        self.assertEqual((out.status, out.headers["location"]), (303, "/sign-in"))
        self.assertIn("Max-Age=0", out.headers["set-cookie"])
        server.stop(signal.SIGKILL)
        server.start()
        self.assertEqual(session(browser).status, 401)
        self.assertEqual(session(other).status, 200)

    def test_server_killed_while_its_worker_works_loses_nothing(self):
        server = self.server()
        worker = self.worker(server, "outlives")
        job = server.submit(NEWBORN, RINGS, LONG)
        self.wait_forming(server, job)
        server.stop(signal.SIGKILL)
        server.start()
        ended = server.wait(job)
        self.assertEqual((ended["state"], ended["attempt"]), ("succeeded", 1), ended["problem"])
        self.assert_one_whole_set(server, job)
        self.assertIsNone(worker.process.poll())

    def test_local_workers_die_with_their_server_and_are_replaced(self):
        server = self.server(workers=1)
        job = server.submit(NEWBORN, RINGS, LONG)
        self.wait_forming(server, job)
        (worker,) = children(server.program.pid)
        (child,) = children(worker)
        os.kill(worker, signal.SIGKILL)
        self.wait_forming(server, job, attempt=2)
        (worker,) = children(server.program.pid)
        (child,) = children(worker)
        server.stop(signal.SIGKILL)
        wait_for(lambda: not runs(worker) and not runs(child), "the end of the server's workers")
        server.start()
        ended = server.wait(job)
        self.assertEqual((ended["state"], ended["attempt"]), ("succeeded", 3), ended["problem"])
        self.assert_one_whole_set(server, job)

    def test_stopping_gives_the_job_back(self):
        server = self.server(workers=1)
        job = server.submit(NEWBORN, RINGS, LONG)
        self.wait_forming(server, job)
        (worker,) = children(server.program.pid)
        self.assertEqual(server.stop(signal.SIGTERM), 0)
        self.assertFalse(runs(worker))
        self.assertEqual([e["job"] for e in self.events(server.program, "job-released")], [job])
        server.start()
        ended = server.wait(job)
        self.assertEqual(ended["state"], "succeeded", ended["problem"])
        self.assert_one_whole_set(server, job)


if __name__ == "__main__":
    unittest.main()
