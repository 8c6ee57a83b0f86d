"""Kills the service at random under load, and checks through the API alone that no accepted job is lost or done twice.

    VACUFORM_BIN=build/tests/bin tests/integration/chaos.py [--kills 200] [--seed 1] [--pause 3] [--open 3]

A real server runs with a local worker; a second worker runs next to it as if on another machine. Eight clients, each
with its own token and owner, keep some jobs each open (chaos_load.py). Most of these jobs succeed if nothing interrupts
them. Each is submitted under its own Idempotency-Key, and again under the same key until the server answers. Meanwhile
the server, the workers and the processes of the jobs are killed (SIGKILL) one at a time, and restarted. Workers are
also frozen for longer than their lease and resumed.

The run checks (chaos_ledger.py):
 - every submission that was answered with 202 is one job, found once in the list, and every job in the list is one of
   them;
 - a key that is submitted again returns the same job;
 - every job ends; after its end neither its state nor its time nor its artifacts change;
 - every job has the expected end: it succeeds, is refused for a bad scan, or was cancelled. A job does not fail because
   a machine, server or worker was killed, unless that happened ten times. It does fail if its own process died twice.
   Its log says so;
 - the artifacts of a job that succeeded are one complete set with the digests that the job names, and all jobs with the
   same request have the same bytes.
"""
import argparse
import json
import os
import pathlib
import random
import signal
import tempfile
import threading
import time

from chaos_ledger import Ledger
from chaos_load import Api, Client, scans
from harness import BIN, Program, Server, children, runs

CLIENTS = 8
LEASE = 4
VICTIMS = {"server": 5, "worker": 8, "child": 3, "frozen": 1}  # with the weight of each


class Chaos:
    def __init__(self, folder, seed, pause, most_open):
        self.folder, self.seed, self.pause, self.most_open = folder, seed, pause, most_open
        self.random = random.Random(seed)
        self.server = Server(folder, 1, ["--lease-seconds", LEASE])
        self.remote = None
        self.faults = []
        self.kills = dict.fromkeys(VICTIMS, 0)
        self.ledger = Ledger()

    def guarded(self, work):
        try:
            work()
        except Exception as fault:  # reported by run(), on the main thread
            self.faults.append(f"{type(fault).__name__}: {fault}")

    def start_remote(self):
        self.remote = Program([BIN / "vacuform-worker", "--server", self.server.url, "--token-file", self.server.data / "worker-token",
                               "--name", "remote", "--work", self.folder / "work", "--poll-seconds", "0.2"], self.folder / "remote.log")

    def clients(self, admin):
        files = scans(self.folder)
        for number in range(CLIENTS):
            status, body = admin.ask("POST", "/api/v1/tokens", json.dumps({"owner": f"station-{number}", "scopes": ["submit", "read"]}),
                                     {"Content-Type": "application/json"})
            assert status == 201, (status, body)
            yield Client(Api(self.server.port, json.loads(body)["token"]), files, self.ledger, f"{self.seed}/{number}",
                         self.most_open)

    def workers(self):
        return [*children(self.server.program.pid), self.remote.pid]

    def kill_one(self):
        due = [what for what, times in self.kills.items() if times == 0]  # even the shortest run kills each once
        (what,) = due[:1] or self.random.choices(list(VICTIMS), VICTIMS.values())
        if what == "server":
            self.server.stop(signal.SIGKILL)
            self.server.start()
        else:
            workers = self.workers()
            found = [c for w in workers for c in children(w)] if what == "child" else workers
            if not found:
                return
            try:
                self.end_process(what, self.random.choice(found))
            except ProcessLookupError:
                return
        self.kills[what] += 1

    def end_process(self, what, pid):
        if what == "frozen":
            self.freeze(pid)
        elif pid == self.remote.pid:
            self.remote.end(signal.SIGKILL)
            self.start_remote()
        else:
            os.kill(pid, signal.SIGKILL)

    def freeze(self, worker):
        """Stops a worker and its job for longer than its lease, then resumes them."""
        everyone = [worker, *children(worker)]
        for pid in everyone:
            os.kill(pid, signal.SIGSTOP)
        time.sleep(LEASE + 1)
        for pid in everyone:
            if runs(pid):
                os.kill(pid, signal.SIGCONT)

    def run(self, kills):
        """The figures, after a run in which every check passed."""
        self.server.start()
        self.start_remote()
        admin = Api(self.server.port, self.server.token_file.read_text().strip())
        over = threading.Event()
        clients = [threading.Thread(target=self.guarded, args=[lambda c=client: c.run(over)]) for client in list(self.clients(admin))]
        for client in clients:
            client.start()
        try:
            while sum(self.kills.values()) < kills and not self.faults:
                time.sleep(self.random.uniform(0, 2 * self.pause))
                self.kill_one()
        finally:
            over.set()
            for client in clients:
                client.join()
        assert not self.faults, self.faults
        return {**self.ledger.check(admin), "killed": self.kills}

    def stop(self):
        for program in (self.remote, self.server.program):
            if program:
                program.end()


def run(kills, seed, pause, most_open, folder):
    chaos = Chaos(pathlib.Path(folder), seed, pause, most_open)
    try:
        return chaos.run(kills)
    finally:
        chaos.stop()


def main():
    options = argparse.ArgumentParser(description="Kills the service at random under load and checks that nothing is lost or done twice.")
    options.add_argument("--kills", type=int, default=200)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--pause", type=float, default=3, help="mean seconds from a kill to the next")
    options.add_argument("--open", type=int, default=3, help="jobs that each client waits for at a time")
    given = options.parse_args()
    started = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="vacuform-chaos-") as folder:
        figures = run(given.kills, given.seed, given.pause, given.open, folder)
    print(f"seed {given.seed}, {time.monotonic() - started:.0f} s:", json.dumps(figures))


if __name__ == "__main__":
    main()
