"""The real vacuform-worker against a scripted server, with a scripted pipeline: leases, limits, losses, and endings."""
import hashlib
import http.server
import json
import shutil
import signal
import threading
import time
import unittest

from contract import Broken
from harness import BIN, CONTRACT, Case, Program, runs, wait_for

REQUEST = "4bf92f3577b34da6a3ce929d0e0e4736"
SCAN, PATTERN = b"solid head " * 1000, b"<svg/>"


def digest(data):
    return hashlib.sha256(data).hexdigest()


def described(method, path, headers, body):
    """What the description of the API says against a request; nothing, as it should be."""
    operation, parameters, where = CONTRACT.operation(method, path)
    try:
        CONTRACT.check_request(operation, parameters, "", {k.lower(): v for k, v in headers.items()}, body, where)
        return []
    except Broken as fault:
        return [str(fault)]


class ScriptedServer(http.server.ThreadingHTTPServer):
    """Gives one job, and answers as the test says. `seen` holds (method, path, body, when)."""

    daemon_threads = True

    def __init__(self):
        super().__init__(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self.server_port}"
        self.jobs = 1             # still to be leased
        self.lease_seconds = 30
        self.scan_sha = digest(SCAN)
        self.kind = "print"
        self.inputs = {}          # besides scan and pattern
        self.cache = "a" * 64
        self.cancel = False       # asked with the next heartbeat
        self.lost = False         # the lease is someone else's
        self.away = 0             # so many requests under a lease get 503
        self.token = "secret"
        self.seen = []
        self.faults = []          # of requests that the API's description does not know
        self.artifacts = {}
        threading.Thread(target=self.serve_forever, daemon=True).start()

    def calls(self, tail):
        return [s for s in self.seen if s[1].endswith(tail)]


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *_):
        pass

    def reply(self, status, body=b"", kind="application/json"):
        if isinstance(body, dict):
            body = json.dumps(body).encode()
        self.send_response(status)
        self.send_header("Content-Type", kind)
        if status != 204:
            self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if status != 204:
            self.wfile.write(body)

    def problem(self, status, slug, what):
        self.reply(status, {"type": "/problems/" + slug, "title": slug, "status": status, "what": what},
                   "application/problem+json")

    def handle_any(self):
        s = self.server
        body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        s.seen.append((self.command, self.path, body, time.monotonic()))
        s.faults += described(self.command, self.path, self.headers, body)
        if self.headers.get("Authorization") != "Bearer " + s.token:
            return self.problem(401, "bad-usage", "the worker token is not known")
        if self.path == "/api/v1/leases":
            if s.jobs == 0:
                return self.reply(204)
            s.jobs -= 1
            return self.reply(200, {
                "job": "j1", "kind": s.kind, "lease": "abc", "attempt": 1, "lease_seconds": s.lease_seconds, "heartbeat_seconds": 1,
                "request": REQUEST, "cache": s.cache,
                "settings": {"print": {"dpi": 100}},
                "inputs": {"scan": {"extension": "stl", "bytes": len(SCAN), "sha256": s.scan_sha},
                           "pattern": {"extension": "svg", "bytes": len(PATTERN), "sha256": digest(PATTERN)}, **s.inputs}})
        if self.headers.get("Vacuform-Lease") != "abc" or s.lost:
            return self.problem(409, "lease-lost", "the lease is no longer held")
        if s.away > 0:
            s.away -= 1
            return self.problem(503, "unavailable", "away")
        tail = self.path.removeprefix("/api/v1/leases/j1")
        if self.headers.get("X-Request-Id") != REQUEST:
            return self.problem(400, "bad-usage", "the request id is missing")
        if tail == "/inputs/scan":
            return self.reply(200, SCAN, "application/octet-stream")
        if tail == "/inputs/pattern":
            return self.reply(200, PATTERN, "application/octet-stream")
        if tail == "/heartbeat":
            return self.reply(200, {"cancel": s.cancel})
        if tail.startswith("/artifacts/"):
            s.artifacts[tail.removeprefix("/artifacts/")] = body
        self.reply(204)

    do_GET = do_POST = do_PUT = handle_any


class Worker(Case):
    def setUp(self):
        self.here = self.folder / self._testMethodName
        self.here.mkdir()
        shutil.copy(BIN / "vacuform-worker", self.here)
        self.work = self.here / "work"
        self.token = self.here / "token"
        self.token.write_text("secret\n")
        self.server = ScriptedServer()
        self.addCleanup(self.server.server_close)
        self.addCleanup(self.server.shutdown)
        self.addCleanup(lambda: self.assertEqual(self.server.faults, []))

    def start(self, pipeline, cache="--no-cache"):
        """Starts the worker with this shell script in the place of vacuform. $OUT is the folder for artifacts."""
        program = self.here / "vacuform"
        program.write_text('#!/bin/sh\nOUT=out; mkdir -p $OUT; echo $$ > %s/pid\n' % self.here + pipeline)
        program.chmod(0o755)
        worker = Program([self.here / "vacuform-worker", "--server", self.server.url, "--token-file", self.token,
                          "--sandbox=off", "--work", self.work, "--poll-seconds", "0.05", "--name", "w1", *cache.split()], self.here / "log")
        self.addCleanup(worker.end)
        return worker

    def child(self):
        pid = wait_for(lambda: (self.here / "pid").exists() and (self.here / "pid").read_text().strip(), "the child")
        return int(pid)

    def the_call(self, tail):
        return wait_for(lambda: self.server.calls(tail), tail)[0]

    def assert_nothing_left(self):
        wait_for(lambda: not list(self.work.iterdir()), "an empty folder for work")

    def test_job_is_run_and_its_artifacts_handed_in(self):
        worker = self.start("""
            echo "$@" > %s/words; cp scan.stl pattern.svg settings.json %s
            echo '{"stage":"forming","progress":0.5}'
            printf print > $OUT/print.png; printf '{}' > $OUT/report.json
            printf x > $OUT/notes.txt
            until [ -e %s/go ]; do sleep 0.02; done""" % (self.here, self.here, self.here))
        wait_for(lambda: any(json.loads(c[2]) == {"stage": "forming", "progress": 0.5}
                             for c in self.server.calls("/heartbeat")), "a heartbeat in forming")
        (self.here / "go").touch()
        self.the_call("/complete")
        self.assertEqual(self.server.artifacts, {"print.png": b"print", "report.json": b"{}"})
        self.assertEqual((self.here / "words").read_text().split(),
                         "run --settings settings.json --out out --progress json --scan scan.stl --pattern pattern.svg".split())
        self.assertEqual((self.here / "scan.stl").read_bytes(), SCAN)
        self.assertEqual((self.here / "pattern.svg").read_bytes(), PATTERN)
        self.assertEqual(json.loads((self.here / "settings.json").read_text()), {"print": {"dpi": 100}})
        self.assert_nothing_left()
        self.assertEqual(worker.end(), 0)
        events = [json.loads(line) for line in worker.says().splitlines()]
        self.assertEqual([e["event"] for e in events], ["worker-started", "job-leased", "job-left", "worker-stopped"])
        self.assertEqual(events[2]["verdict"], "completed")
        self.assertEqual([e.get("request") for e in events], [None, REQUEST, REQUEST, None])
        self.assertNotIn(str(self.here), worker.says())

    def test_cancel_ends_even_a_deaf_child_within_two_seconds(self):
        self.start("trap '' TERM; while :; do sleep 0.05; done")
        child = self.child()
        self.the_call("/heartbeat")
        self.server.cancel = True
        asked = time.monotonic()
        told = self.the_call("/cancelled")
        self.assertLess(told[3] - asked, 2.0)
        self.assertFalse(runs(child))
        self.assert_nothing_left()
        self.assertFalse(self.server.calls("/fail") + self.server.calls("/complete"))

    def test_lost_lease_ends_the_child_and_nothing_more_is_said(self):
        self.start("printf print > $OUT/print.png; sleep 300")
        child = self.child()
        self.server.lost = True
        wait_for(lambda: not runs(child), "the child's end")
        self.server.jobs, self.server.lost = 1, False
        wait_for(lambda: len(self.server.calls("/inputs/scan")) == 2, "the next job")
        self.assertEqual(self.server.artifacts, {})
        self.assertFalse(self.server.calls("/fail") + self.server.calls("/complete") + self.server.calls("/release"))

    def test_crash_is_worth_another_try(self):
        worker = self.start("echo oh dear >&2; kill -SEGV $$")
        said = json.loads(self.the_call("/fail")[2])
        self.assertEqual((said["code"], said["retry"], said["crashed"]), ("internal", True, True))
        self.assert_nothing_left()
        fault = wait_for(lambda: [e for e in map(json.loads, worker.says().splitlines()) if e["event"] == "child-fault"],
                         "the fault in the log")[0]
        self.assertEqual((fault["signal"], fault["stderr"], fault["job"]), (signal.SIGSEGV, "oh dear\n", "j1"))

    def test_child_gets_the_cache_of_its_own_scan_and_its_stages_are_told(self):
        other = self.here / "cache" / ("0" * 64)
        other.mkdir(parents=True)
        (self.here / "cache").chmod(0o700)
        self.start("""echo "$@" > %s/words
            echo '{"stage":"scan","progress":1,"cached":true}'; echo '{"stage":"forming","progress":0.5}'
            echo '{"stage":"forming","progress":1}'
            echo '{"warnings":[{"code":"thin","what":"x","severity":"serious"},{"code":"A B"}]}' > $OUT/report.json""" % self.here,
                   cache=f"--cache {self.here / 'cache'}")
        self.the_call("/complete")
        own = self.here / "cache" / ("a" * 64)  # as the lease says: the scan's own digest is other owners' too
        self.assertIn(f"--cache {own}", (self.here / "words").read_text())
        self.assertEqual(own.stat().st_mode & 0o777, 0o700)
        lines = []
        for call in self.server.calls("/log"):
            said = json.loads(call[2])
            self.assertEqual(said["first"], len(lines))
            lines += said["lines"]
        self.assertEqual(lines, ["stage scan cached", "stage forming", "warning thin"])

    def test_what_is_not_a_plain_file_is_not_handed_in(self):
        for number, left in enumerate(("ln -s /etc/passwd $OUT/mold.stl", "mkfifo $OUT/mold.stl", "ln $OUT/print.png $OUT/mold.stl",
                                       "mkdir $OUT/mold.stl", "mv $OUT real; ln -s real out", "mv $OUT real; ln -s out out")):
            with self.subTest(left):
                self.server.jobs = 1
                worker = self.start(f"printf print > $OUT/print.png; {left}")
                said = json.loads(wait_for(lambda: self.server.calls("/fail")[number:], "the failure")[0][2])
                self.assertEqual((said["code"], said["crashed"]), ("internal", True))
                self.assertIn("not a file of its own", said["what"])
                self.assertIsNone(worker.process.poll())
                worker.end()
                self.assert_nothing_left()
        self.assertNotIn("mold.stl", self.server.artifacts)
        self.assertFalse(self.server.calls("/complete"))

    def test_too_many_files_end_the_job_and_are_deleted(self):
        self.start("cd $OUT; for i in $(seq 2000); do : > $i; done; exec sleep 300")
        said = json.loads(self.the_call("/fail")[2])
        self.assertEqual((said["code"], said["retry"]), ("out-of-time", False))
        self.assertIn("more than 1000 files", said["what"])
        self.assert_nothing_left()

    def test_a_job_that_is_killed_from_outside_is_not_blamed_on_its_scan(self):
        self.start("kill -KILL $$")
        said = json.loads(self.the_call("/fail")[2])
        self.assertEqual((said["code"], said["retry"], said["crashed"]), ("out-of-time", True, True))
        self.assertIn("killed from outside", said["what"])
        self.assertIn("system's log", said["fix"])
        self.assertNotIn("scan", said["what"] + said["fix"])

    def test_a_job_that_is_not_understood_is_given_back_once(self):
        for change in ({"kind": "casting"}, {"inputs": {"mask": {"extension": "png", "bytes": 1, "sha256": "0" * 64}}}):
            with self.subTest(change):
                self.server.jobs, self.server.seen = 3, []
                self.server.kind, self.server.inputs = change.get("kind", "print"), change.get("inputs", {})
                worker = self.start("exit 0")
                self.assertEqual(worker.wait(), 2)
                self.assertIn("a job that this worker does not understand; it is given back", worker.says())
                self.assertEqual([len(self.server.calls(tail)) for tail in ("/leases", "/release", "/fail")], [1, 1, 0])

    def test_refusal_is_passed_on_and_final(self):
        self.start("""echo '{"problem":{"code":"does-not-fit","what":"too wide","where":"scan.stl","fix":"turn it","proposals":[{"set":{"scan":{"yaw_deg":90}},"text":""}]}}'
                      exit 2""")
        self.assertEqual(json.loads(self.the_call("/fail")[2]), {
            "code": "does-not-fit", "what": "too wide", "where": "scan.stl", "fix": "turn it",
            "proposals": [{"set": {"scan": {"yaw_deg": 90}}, "text": ""}], "retry": False, "crashed": False})

    def test_refused_print_hands_in_what_explains_it(self):
        self.start("""for file in mold.stl findings.json print.png; do echo $file > $OUT/$file; done
                      echo '{"problem":{"code":"forming-failed","what":"the sheet tears"}}'; exit 2""")
        said = json.loads(self.the_call("/fail")[2])
        self.assertEqual((said["code"], said["retry"], said["crashed"]), ("forming-failed", False, False))
        self.assertEqual(self.server.artifacts, {"mold.stl": b"mold.stl\n", "findings.json": b"findings.json\n"})

    def test_refusal_without_a_reason_is_a_fault(self):
        self.start("echo '{\"problem\":{\"code\":\"made-up\",\"what\":\"x\"}}'; exit 2")
        said = json.loads(self.the_call("/fail")[2])
        self.assertEqual((said["code"], said["retry"]), ("internal", False))

    def test_internal_fault_is_worth_another_try(self):
        self.start("""echo '{"problem":{"code":"internal","what":"a bug"}}'; exit 1""")
        said = json.loads(self.the_call("/fail")[2])
        self.assertEqual((said["code"], said["what"], said["retry"]), ("internal", "a bug", True))

    def test_server_briefly_away_costs_nothing(self):
        self.start("printf print > $OUT/print.png; until [ -e %s/go ]; do sleep 0.02; done" % self.here)
        child = self.child()
        self.server.away = 4
        wait_for(lambda: self.server.away == 0, "the server's return")
        self.assertTrue(runs(child))
        self.server.away = 3
        (self.here / "go").touch()
        self.the_call("/complete")
        wait_for(lambda: self.server.artifacts == {"print.png": b"print"}, "the artifact")

    def test_server_away_for_longer_than_the_lease_ends_the_child(self):
        self.server.lease_seconds = 2
        self.start("sleep 300")
        child = self.child()
        self.server.away = 10**9
        wait_for(lambda: not runs(child), "the child's end")
        self.assert_nothing_left()

    def test_damaged_input_is_fetched_again_and_then_given_back(self):
        self.server.scan_sha = "0" * 64
        self.server.lease_seconds = 2
        self.start("exit 0")
        said = json.loads(self.the_call("/fail")[2])
        self.assertTrue(said["retry"])
        self.assertIn("damaged", said["what"])
        self.assertGreater(len(self.server.calls("/inputs/scan")), 1)
        self.assertFalse((self.here / "pid").exists())

    def test_sigterm_releases_the_job(self):
        worker = self.start("sleep 300")
        child = self.child()
        self.assertEqual(worker.end(signal.SIGTERM), 0)
        self.assertFalse(runs(child))
        self.assertEqual(len(self.server.calls("/release")), 1)
        self.assert_nothing_left()

    def test_sigterm_lets_the_job_end_within_the_drain_and_leases_no_other(self):
        self.server.jobs = 2
        worker = self.start("printf print > $OUT/print.png; until [ -e %s/go ]; do sleep 0.02; done" % self.here, cache="--no-cache --drain 60")
        child = self.child()
        worker.process.send_signal(signal.SIGTERM)
        self.the_call("/heartbeat")
        self.assertTrue(runs(child))
        self.server.away = 2  # a fault meanwhile is borne as before
        (self.here / "go").touch()
        self.assertEqual(worker.wait(), 0)
        self.assertEqual([len(self.server.calls(tail)) for tail in ("/leases", "/complete", "/release", "/fail")], [1, 1, 0, 0])
        self.assert_nothing_left()

    def test_sigterm_releases_the_job_at_the_end_of_the_drain(self):
        worker = self.start("sleep 300", cache="--no-cache --drain 0.5")
        child = self.child()
        told = time.monotonic()
        worker.process.send_signal(signal.SIGTERM)
        self.assertEqual(worker.wait(), 0)
        self.assertGreaterEqual(self.server.calls("/release")[0][3] - told, 0.5)
        self.assertFalse(runs(child))
        self.assertEqual(len(self.server.calls("/fail")), 0)

    def test_worker_exits_after_so_many_jobs(self):
        self.server.jobs = 5
        worker = self.start("exit 0", cache="--no-cache --max-jobs 2")
        self.assertEqual(worker.wait(), 0)
        self.assertEqual([len(self.server.calls(tail)) for tail in ("/leases", "/complete")], [2, 2])
        self.assertIn('"why":"max-jobs"', worker.says().replace(" ", ""))

    def test_worker_exits_when_there_is_no_job_for_long(self):
        started = time.monotonic()
        worker = self.start("exit 0", cache="--no-cache --idle-exit 0.5")
        self.assertEqual(worker.wait(), 0)
        self.assertGreater(time.monotonic() - started, 0.5)
        self.assertEqual(len(self.server.calls("/complete")), 1)
        self.assertIn('"why":"idle"', worker.says().replace(" ", ""))

    def test_killed_worker_leaves_nothing_for_long(self):
        worker = self.start("sleep 300 & wait")
        child = self.child()
        worker.end(signal.SIGKILL)
        wait_for(lambda: not runs(child), "the child's end")
        self.assertEqual(len(list(self.work.iterdir())), 1)
        self.start("exit 0")
        self.assert_nothing_left()

    def test_unknown_token_is_said_at_once(self):
        self.server.token = "another"
        worker = self.start("exit 0")
        self.assertEqual(worker.wait(), 2)
        self.assertIn("vacuform-worker: the worker token is not known", worker.says())


if __name__ == "__main__":
    unittest.main()
