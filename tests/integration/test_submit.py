"""vacuform submit against a scripted server: what it shows, what it fetches, and which answers it rejects."""
import hashlib
import http.server
import json
import signal
import socket
import subprocess
import threading
import unittest

import hostile
from harness import BIN, Case, Server, vacuform, wait_for

PRINT = b"\x89PNG print"


def artifact(name, body, sha256=None, size=None):
    return {"name": name, "bytes": len(body) if size is None else size,
            "sha256": sha256 or hashlib.sha256(body).hexdigest()}


class ScriptedServer(http.server.ThreadingHTTPServer):
    """`jobs` are the successive answers for the job, the last one is repeated; a tuple is a status and a body."""

    daemon_threads = True

    def __init__(self):
        super().__init__(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self.server_port}"
        self.jobs, self.files, self.seen = [], {}, []
        threading.Thread(target=self.serve_forever, daemon=True).start()


class Handler(http.server.BaseHTTPRequestHandler):
    def log_message(self, *_):
        pass

    def do_POST(self):
        self.rfile.read(int(self.headers["Content-Length"]))
        self.answer(202, json.dumps({"id": "j1", "state": "queued"}).encode())

    def do_GET(self):
        s = self.server
        s.seen.append(self.path)
        if self.path == "/api/v1/jobs/j1":
            found = s.jobs.pop(0) if len(s.jobs) > 1 else s.jobs[0]
            status, body = found if isinstance(found, tuple) else (200, found)
            self.answer(status, body if isinstance(body, bytes) else json.dumps({"id": "j1", **body}).encode())
        else:
            body = s.files.get(self.path.removeprefix("/api/v1/jobs/j1/artifacts/"))
            self.answer(404 if body is None else 200, body or b"")

    def answer(self, status, body):
        self.send_response(status)
        if status == 302:
            self.send_header("Location", "/api/v1/jobs/j1/artifacts/print.png")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        try:
            self.wfile.write(body)
        except ConnectionError:
            pass


class Submit(Case):
    def setUp(self):
        self.out = self.folder / self._testMethodName
        self.server = ScriptedServer()
        self.addCleanup(self.server.server_close)
        self.addCleanup(self.server.shutdown)

    def words(self):
        return ["submit", "--server", self.server.url, "--job", "j1", "--wait", "--out", str(self.out)]

    def submit(self, *jobs, files={}):
        self.server.jobs, self.server.files = list(jobs), files
        return vacuform(*self.words())

    def assert_nothing_fetched(self):
        self.assertEqual([p.name for p in self.out.iterdir()] if self.out.exists() else [], [])

    def test_stages_are_shown_and_artifacts_fetched(self):
        done = self.submit({"state": "queued"}, {"state": "running", "stage": "scan", "progress": 0.1}, (503, {}),
                           {"state": "running", "stage": "forming", "progress": 0.4},
                           {"state": "succeeded", "artifacts": [artifact("print.png", PRINT), artifact("report.json", b"{}")]},
                           files={"print.png": PRINT, "report.json": b"{}"})
        self.assertEqual((done.returncode, done.stderr), (0, "queued\nscan\nforming\ndownload\n"))
        self.assertEqual(done.stdout, f"{self.server.url}/api/v1/jobs/j1\n")
        self.assertEqual({p.name: p.read_bytes() for p in self.out.iterdir()}, {"print.png": PRINT, "report.json": b"{}"})

    REPORT = {"label": "3f9a12c4", "print": {"inked_face": "outer", "mirrored": False},
              "pattern": {"ink_on_head": 0.412}, "coils": [{"id": "coil-1"}],
              "figures": {"with": {"coils": {"on_head": 0}}, "without": {}},
              "warnings": [{"stage": "printing", "code": "coil-off-head", "severity": "serious", "what": "coil-1 lies off.",
                            "place": "coil-1", "figure": None, "fix": "Move it.", "marks": []}],
              "artifacts": [{"name": "report.json", "title": "The report"}]}

    def succeeded(self, *words, report=REPORT):
        """A job that has a report, fetched with these additional arguments."""
        body = json.dumps(report).encode()
        self.server.jobs = [{"state": "succeeded", "artifacts": [artifact("print.png", PRINT), artifact("report.json", body)]}]
        self.server.files = {"print.png": PRINT, "report.json": body}
        self.server.seen.clear()
        return vacuform("submit", "--server", self.server.url, "--job", "j1", "--wait", *words)

    def test_the_summary_is_that_of_run(self):
        done = self.succeeded("--out", self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        url, text = done.stdout.split("\n", 1)
        self.assertEqual(url, f"{self.server.url}/api/v1/jobs/j1")
        self.assertTrue(text.startswith("Print 3f9a12c4, for the outer face.\n41.2 % of its ink lies on the head, with 0 of 1 coils.\n"), text)
        self.assertIn("1 serious warning, 0 warnings, 0 notes\n  serious: coil-1 lies off. [coil-off-head]\n", text)
        self.assertIn(f"Files: {self.out} ", text)

    def test_without_a_folder_only_the_report_is_fetched(self):
        done = self.succeeded()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("1 serious warning", done.stdout)
        self.assertIn(f"Files: {self.server.url}/api/v1/jobs/j1 ", done.stdout)
        self.assertEqual(self.server.seen[-1], "/api/v1/jobs/j1/artifacts/report.json")
        self.assertNotIn("/api/v1/jobs/j1/artifacts/print.png", self.server.seen)

    def test_as_json_strictly_and_quietly(self):
        done = self.succeeded("--json", "--strict")
        self.assertEqual((done.returncode, done.stderr), (3, ""))
        summary = json.loads(done.stdout)
        self.assertEqual((summary["label"], summary["serious_warnings"], summary["files"]), ("3f9a12c4", 1, ["report.json"]))
        done = self.succeeded("--quiet", "--strict")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (3, f"{self.server.url}/api/v1/jobs/j1\n", ""))
        self.assertEqual(self.succeeded("--strict", report={**self.REPORT, "warnings": []}).returncode, 0)
        self.assertEqual(self.succeeded("--quiet", "--json").returncode, 2)
        self.assertEqual(vacuform("submit", "--server", self.server.url, "--job", "j1", "--strict").returncode, 2)

    def test_a_report_that_makes_no_sense_is_no_summary(self):
        for report in ([], 7, {}, {"figures": None, "warnings": 3, "coils": "x"},
                       {"figures": {"with": {"coils": {"strongest_pair": {"coils": 3}, "strongest_neighbours": {}}}}}):
            with self.subTest(report):
                self.assertEqual(self.succeeded("--strict", report=report).returncode, 0)

    def test_names_that_are_no_artifacts_are_left_alone(self):
        done = self.submit({"state": "succeeded", "artifacts": [
            artifact(n, b"x") for n in ("../../evil", "/etc/passwd", "notes.txt", "", "print.png/..")] + [7, {}]},
            files={"notes.txt": b"x"})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.server.seen, ["/api/v1/jobs/j1"])
        self.assert_nothing_fetched()

    def test_damaged_artifacts_are_not_kept(self):
        for name, listed in [("hash", artifact("print.png", PRINT, sha256="0" * 64)),
                             ("short", artifact("print.png", PRINT, size=len(PRINT) + 1)),
                             ("long", artifact("print.png", PRINT, size=len(PRINT) - 1))]:
            with self.subTest(name):
                done = self.submit({"state": "succeeded", "artifacts": [listed]}, files={"print.png": PRINT})
                self.assertEqual(done.returncode, 1)
                self.assertTrue(done.stderr.endswith("vacuform: the file arrived damaged (print.png); try again\n"), done.stderr)
                self.assert_nothing_fetched()

    def test_how_the_job_ended_is_the_exit_status(self):
        for slug, exit_status in ("does-not-fit", 2), ("internal", 1), ("out-of-time", 2):
            done = self.submit({"state": "failed", "problem": {
                "type": "/problems/" + slug, "what": "it is too wide", "where": "scan.stl", "fix": "turn it"}})
            self.assertEqual((done.returncode, done.stderr), (exit_status, "vacuform: it is too wide (scan.stl); turn it\n"))
        self.assertEqual(self.submit({"state": "cancelled"}).returncode, 130)
        self.assertEqual(self.submit({"state": "failed", "problem": None}).returncode, 1)

    def test_answers_that_make_no_sense(self):
        for job in [(200, b"<html>"), (200, b"[]"), (200, b"{}"), (200, b'{"id":"j1","state":"melted"}'),
                    (200, b'{"id":"../j1","state":"succeeded"}'), (200, b" " * 5000000), (302, b""), (404, b""), (418, b"")]:
            with self.subTest(repr(job)[:60]):
                done = self.submit(job)
                self.assertIn(done.returncode, (1, 2))
                self.assertRegex(done.stderr, r"\Avacuform: [^\n]+\n\Z")
                self.assert_nothing_fetched()

    def test_interrupt_leaves_the_job_and_says_how_to_come_back(self):
        self.server.jobs = [{"state": "running", "stage": "forming", "progress": 0.4}]
        with subprocess.Popen([BIN / "vacuform", *self.words()], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as p:
            wait_for(lambda: self.server.seen, "the first question")
            p.send_signal(signal.SIGINT)
            out, err = p.communicate(timeout=60)
        self.assertEqual(p.returncode, 130)
        self.assertIn("the job goes on", err)
        self.assertIn(f"vacuform submit --server {self.server.url} --job j1 --wait --out {self.out}", err)
        self.assertNotIn("/api/v1/jobs/j1/cancel", self.server.seen)


class Relay(threading.Thread):
    """Forwards connections to a port of this machine; the first `broken` of them end before the answer."""

    def __init__(self, port, broken):
        super().__init__(daemon=True)
        self.port, self.broken, self.answered = port, broken, []
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self.listener.getsockname()[1]}"
        self.start()

    def run(self):
        while True:
            near, _ = self.listener.accept()
            with near, socket.create_connection(("127.0.0.1", self.port)) as far:
                sender = threading.Thread(target=self.send, args=[near, far], daemon=True)
                sender.start()
                answer = far.recv(1 << 16)
                self.answered.append(answer[:12])
                if len(self.answered) > self.broken:
                    near.sendall(answer)
                    while piece := far.recv(1 << 16):
                        near.sendall(piece)
                near.shutdown(socket.SHUT_RDWR)  # closing alone tells the client nothing while the other thread reads

    @staticmethod
    def send(near, far):
        try:
            while piece := near.recv(1 << 16):
                far.sendall(piece)
        except OSError:  # one side has closed the connection
            pass


class SubmitAgain(Case):
    def test_a_submission_whose_answer_is_lost_makes_one_job(self):
        with Server(self.folder, 0) as server:
            relay = Relay(server.port, 2)
            scan, pattern = self.folder / "scan.stl", self.folder / "p.svg"
            scan.write_bytes(hostile.stl(hostile.dome_triangles()))
            pattern.write_bytes(hostile.GOOD_SVG)
            done = vacuform("submit", "--server", relay.url, "--token-file", server.token_file, "--scan", scan, "--pattern", pattern)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertEqual([answer for answer in relay.answered], [b"HTTP/1.1 202"] * 3)
            self.assertEqual([job["id"] for job in server.jobs()], [done.stdout.strip().rsplit("/", 1)[1]])

    def test_a_token_is_not_sent_over_the_network_in_plain_http(self):
        token = self.folder / "token"
        token.write_text("vft_0123456789abcdef_" + "0" * 64 + "\n")
        done = vacuform("submit", "--server", "http://192.0.2.1:8080", "--token-file", token, "--job", "j1")
        self.assertEqual(done.returncode, 2)
        self.assertIn("a token must not cross the network in plain HTTP", done.stderr)


if __name__ == "__main__":
    unittest.main()
