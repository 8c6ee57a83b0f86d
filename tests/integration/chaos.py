"""Kills the service at random under load, and checks through the API alone that nothing it accepted is lost or done twice.

    VACUFORM_BIN=build/release/bin VACUFORM_SHARED_DATA=. tests/integration/chaos.py [--kills 200] [--seed 1] [--workers 2]

A real server runs with real local workers. Eight clients submit small jobs, two out of three with a scan that is refused at
once, each under an Idempotency-Key of its own, and repeat a submission under the same key until it is answered. Meanwhile the server, its workers and their children are killed
(SIGKILL) one at a time, and the server is started again. Workers are also frozen beyond their lease and woken again.

What must hold:
 - every submission that was answered with 202 is one job, found once in the list, and every job in the list is one of them;
 - a key submitted again gives that job and no other;
 - every job ends; what was once seen to have ended never changes again, neither its state nor its time nor its artifacts;
 - the artifacts of a job that succeeded are one whole set with the digests that the job names.
"""
import argparse
import hashlib
import http.client
import json
import os
import pathlib
import random
import signal
import tempfile
import threading
import time
import uuid

import hostile
from harness import PATIENCE, Server, children, runs, wait_for

CLIENTS = 8
LEASE = 3
SMALL = {"sheet": {"resolution_mm": 8, "width_mm": 150, "height_mm": 150},
         "machine": {"window_width_mm": 140, "window_height_mm": 140}, "print": {"dpi": 72}}
ENDED = ("succeeded", "failed", "cancelled")


def form(scan):
    """The body of a submission."""
    parts = [("scan", "a.stl", scan), ("pattern", "a.svg", hostile.GOOD_SVG),
             ("settings", "", json.dumps(SMALL).encode())]
    body = b"".join(f'--chaos\r\nContent-Disposition: form-data; name="{name}"'.encode() +
                    (f'; filename="{file}"'.encode() if file else b"") + b"\r\n\r\n" + data + b"\r\n" for name, file, data in parts)
    return body + b"--chaos--\r\n"


class Api:
    """Requests that give None where the service is not there to answer."""

    def __init__(self, server):
        self.server = server
        self.bodies = {True: form(hostile.stl(hostile.dome_triangles())), False: form(hostile.stl([]))}

    def ask(self, method, path, body=None, headers=()):
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=20)
        try:
            token = self.server.token_file.read_text().strip()
            connection.request(method, path, body, {"Authorization": "Bearer " + token, **dict(headers)})
            answer = connection.getresponse()
            return answer.status, answer.read()
        except (OSError, http.client.HTTPException):
            return None
        finally:
            connection.close()

    def submit(self, key, good):
        """The id of the job under that key, asked for until there is an answer."""
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            answer = self.ask("POST", "/api/v1/jobs", self.bodies[good],
                              {"Content-Type": "multipart/form-data; boundary=chaos", "Idempotency-Key": key})
            if answer and answer[0] in (200, 202):
                return json.loads(answer[1])["id"]
            assert answer is None or answer[0] in (429, 503, 507) or answer[0] >= 500, answer
            time.sleep(0.2)
        raise AssertionError("a submission was never answered")

    def job(self, job):
        answer = self.ask("GET", "/api/v1/jobs/" + job)
        assert answer is None or answer[0] == 200, (job, answer)
        return json.loads(answer[1]) if answer else None

    def jobs(self):
        found, cursor = [], ""
        while True:
            answer = self.ask("GET", "/api/v1/jobs?limit=100" + cursor)
            assert answer and answer[0] == 200, answer
            page = json.loads(answer[1])
            found += [j["id"] for j in page["jobs"]]
            if not page["next"]:
                return found
            cursor = "&cursor=" + page["next"]


class Chaos:
    def __init__(self, folder, workers, seed):
        self.random = random.Random(seed)
        self.server = Server(folder, workers, ["--lease-seconds", LEASE])
        self.api = Api(self.server)
        self.workers = workers
        self.accepted, self.ends, self.faults = {}, {}, []
        self.lock = threading.Lock()
        self.over = threading.Event()
        self.kills = {"server": 0, "worker": 0, "child": 0, "frozen": 0}

    def guarded(self, work):
        try:
            work()
        except Exception as fault:  # told by check(), on the main thread
            self.faults.append(f"{type(fault).__name__}: {fault}")

    def client(self, number):
        while not self.over.is_set():
            key, good = str(uuid.uuid4()), number % 3 == 0
            number += 1
            job = self.api.submit(key, good)
            with self.lock:
                self.accepted[key] = (job, good)
            while not self.over.is_set() and not self.look(job):
                time.sleep(0.1)

    def look(self, job):
        """Whether the job has ended; what was seen of its end must stay."""
        found = self.api.job(job)
        if not found or found["state"] not in ENDED:
            with self.lock:
                assert not found or job not in self.ends, f"{job} had ended and is {found['state']} now"
            return False
        end = (found["state"], found["ended"], tuple((a["name"], a["sha256"]) for a in found["artifacts"]))
        with self.lock:
            assert self.ends.setdefault(job, end) == end, f"{job} ended twice"
        return True

    def victims(self):
        """Workers, and the processes in which they run jobs."""
        workers = children(self.server.program.pid)
        return {"worker": workers, "child": [c for w in workers for c in children(w)]}

    def kill_one(self):
        what = self.random.choice(["server", "server", "worker", "worker", "worker", "child", "child", "frozen"])
        if what == "server":
            self.server.stop(signal.SIGKILL)
            self.server.start()
        else:
            found = self.victims()["worker" if what == "frozen" else what]
            if not found:
                return
            pid = self.random.choice(found)
            try:
                if what == "frozen":
                    self.freeze(pid)
                else:
                    os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                return
        self.kills[what] += 1

    def freeze(self, worker):
        """Stops a worker and its job for longer than its lease, then lets it go on."""
        everyone = [worker, *children(worker)]
        for pid in everyone:
            os.kill(pid, signal.SIGSTOP)
        time.sleep(LEASE + 1)
        for pid in everyone:
            if runs(pid):
                os.kill(pid, signal.SIGCONT)

    def run(self, kills):
        self.server.start()
        clients = [threading.Thread(target=self.guarded, args=[lambda number=number: self.client(number)])
                   for number in range(CLIENTS)]
        for client in clients:
            client.start()
        try:
            while sum(self.kills.values()) < kills and not self.faults:
                time.sleep(self.random.uniform(0.1, 1.2))
                self.kill_one()
        finally:
            self.over.set()
            for client in clients:
                client.join()

    def check(self):
        """Waits for the end of all jobs, then compares what was promised with what is there."""
        assert not self.faults, self.faults
        jobs = [job for job, _ in self.accepted.values()]
        wait_for(lambda: all([self.look(job) for job in jobs]), "the end of all jobs", patience=PATIENCE + 3 * len(jobs), pause=0.5)
        listed = self.api.jobs()
        assert len(set(jobs)) == len(jobs), "two keys have one job"
        assert sorted(listed) == sorted(jobs), (f"{len(set(jobs) - set(listed))} jobs were lost, {len(set(listed) - set(jobs))} "
                                                f"were made of nothing, {len(listed) - len(set(listed))} are listed twice")
        for key, (job, good) in self.accepted.items():
            assert self.api.submit(key, good) == job, "a key gives another job"
            self.check_end(job, good)
        for job in jobs[::10]:
            for name, digest in self.ends[job][2]:
                status, body = self.api.ask("GET", f"/api/v1/jobs/{job}/artifacts/{name}")
                assert status == 200 and hashlib.sha256(body).hexdigest() == digest, (job, name, status)
        states = [end[0] for end in self.ends.values()]
        return {"accepted": len(jobs), **{state: states.count(state) for state in ("succeeded", "failed")}, **self.kills}


    def check_end(self, job, good):
        """A good job succeeds with all its artifacts, or was killed too often, which is said to be the service's own fault."""
        state, _, artifacts = self.ends[job]
        names = [name for name, _ in artifacts]
        if state == "succeeded":
            assert good and len(names) >= 18 and len(names) == len(set(names)), (job, names)
            return
        problem = self.api.job(job)["problem"]["type"]
        assert state == "failed" and names == [], (job, state, names)
        assert problem == "/problems/internal" or (not good and problem == "/problems/unusable-scan"), (job, problem)


def run(kills, seed, workers, folder):
    """The figures, after a run in which everything held."""
    chaos = Chaos(pathlib.Path(folder), workers, seed)
    try:
        chaos.run(kills)
        return chaos.check()
    finally:
        chaos.server.stop()


def main():
    options = argparse.ArgumentParser(description="Kills the service at random under load and checks that nothing is lost or done twice.")
    options.add_argument("--kills", type=int, default=200)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--workers", type=int, default=2)
    given = options.parse_args()
    begun = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="vacuform-chaos-") as folder:
        figures = run(given.kills, given.seed, given.workers, folder)
    print(f"seed {given.seed}, {time.monotonic() - begun:.0f} s:", json.dumps(figures))


if __name__ == "__main__":
    main()
