"""Shared parts of the integration tests: the real programs, curl, free ports, a folder per test, and polling.

Run by ctest, which passes the folder of the programs (VACUFORM_BIN).
"""
import contextlib
import fcntl
import json
import os
import pathlib
import random
import signal
import socket
import subprocess
import tempfile
import time
import unittest

from contract import Contract, of_curl

BIN = pathlib.Path(os.environ["VACUFORM_BIN"])
CONTRACT = Contract()  # every exchange by curl() is checked against it
PATTERNS = pathlib.Path(__file__).resolve().parents[1] / "data" / "patterns"
PATIENCE = 240  # seconds that any operation may take on a busy machine

# What --version prints, for str.format() with the program's name.
VERSION = r"\A{} [0-9]+\.[0-9]+\.[0-9]+ \(commit ([0-9a-f]{{12,40}}(, modified)?|unknown)\)\n\Z"

# The artifacts that every successful print of a drawing has, and those of one with loops without gaps, in their order.
ARTIFACTS = """print.png print.svg print.pdf preview-pattern.png preview-print.png preview-without.png preview-with.png preview-views.png
    preview-lengths.png preview-shape.png preview-area.png preview-thickness.png preview-gap.png preview-findings.png formed.ply formed.obj formed.mtl
    formed.glb uv-map.obj mold.stl report.json report.html""".split()
ARRAY_ARTIFACTS = [*ARTIFACTS[:-2], "layers.dxf", "array.json", "array.nec", "array.ts", *ARTIFACTS[-2:]]


PORTS = pathlib.Path(tempfile.gettempdir()) / "vacuform-test-ports"  # one locked file for each port that a test uses
held_ports = contextlib.ExitStack()


def free_port(count=1):
    """The first of `count` consecutive free ports, reserved for this process as long as it runs. They are below the
    range from which the kernel takes the local ports of connections."""
    with contextlib.suppress(FileExistsError):
        PORTS.mkdir()
        PORTS.chmod(0o1777)
    for _ in range(1000):
        first = random.randrange(10240, 32000)
        with contextlib.suppress(OSError), contextlib.ExitStack() as locks, contextlib.ExitStack() as listeners:
            for port in range(first, first + count):
                fcntl.flock(locks.enter_context(open(PORTS / str(port), "w")), fcntl.LOCK_EX | fcntl.LOCK_NB)
                listeners.enter_context(socket.create_server(("127.0.0.1", port)))
            held_ports.enter_context(locks.pop_all())
            return first
    raise AssertionError("no free port was found")


def wait_for(condition, what, patience=PATIENCE, pause=0.05):
    """Polls until `condition` returns something true, and returns that."""
    until = time.monotonic() + patience
    while time.monotonic() < until:
        value = condition()
        if value:
            return value
        time.sleep(pause)
    raise AssertionError(f"after {patience} s still waiting for: {what}")


def runs(pid):
    """Whether a process is running; a zombie is not."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except (FileNotFoundError, ProcessLookupError):
        return False


def children(pid):
    """The running processes that `pid` has started."""
    found = []
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, parent = stat.read_text().rpartition(")")[2].split()[:2]
            if int(parent) == pid and state not in "ZX":
                found.append(int(stat.parent.name))
    return found


TOKEN_FILES = {}  # the file of the administrator's token, by the address of a server that a test started


def signed(words):
    """The arguments of curl with the token of the addressed server, unless they contain one."""
    if any(str(w).startswith(("Authorization:", "Cookie:")) for w in words):
        return words
    for url, file in TOKEN_FILES.items():
        if file.exists() and any(str(w).startswith(url + "/") for w in words):
            return ["-H", "Authorization: Bearer " + file.read_text().strip(), *words]
    return words


def vacuform(*words, patience=PATIENCE, **options):
    """Runs `vacuform` to its end, with the token of the addressed server in its environment."""
    environment = dict(os.environ)
    for url, file in TOKEN_FILES.items():
        if url in words:
            environment["VACUFORM_TOKEN_FILE"] = str(file)
    return subprocess.run([BIN / "vacuform", *map(str, words)], capture_output=True, text=True, timeout=patience,
                          env=environment, **options)


class Response:
    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    @property
    def json(self):
        return json.loads(self.body)

    def __repr__(self):
        return f"{self.status} {self.body[:2000]!r}"


def curl(*words, patience=PATIENCE):
    """One authenticated request by curl: the last response's status, headers (names in lower case) and body."""
    words = signed(words)
    with tempfile.TemporaryDirectory() as folder:
        head, body = pathlib.Path(folder, "head"), pathlib.Path(folder, "body")
        done = subprocess.run(["curl", "-sS", "--noproxy", "*", "--max-time", str(patience), "-D", head, "-o", body,
                               *map(str, words)], capture_output=True, text=True)
        if done.returncode != 0:
            raise ConnectionError(done.stderr.strip())
        last = head.read_text().strip().split("\n\n")[-1] if head.exists() else ""
        lines = [line.rstrip("\r") for line in last.splitlines()]
        for i, line in enumerate(lines):  # curl also prints the heads of interim responses
            if line.startswith("HTTP/"):
                start = i
        headers = {}
        for line in lines[start + 1:]:
            name, colon, value = line.partition(":")
            if colon:
                headers[name.strip().lower()] = value.strip()
        response = Response(int(lines[start].split()[1]), headers, body.read_bytes() if body.exists() else b"")
    method, url, sent, asked = of_curl(words)
    if url and any(url.startswith(server + "/") for server in TOKEN_FILES):
        CONTRACT.check(method, url, sent, response.status, headers, response.body, asked)
    return response


class Program:
    """A program of the project that runs beside the test; its standard error is stored in a file."""

    def __init__(self, words, log):
        self.log = log
        with open(log, "ab") as stderr:
            self.process = subprocess.Popen([str(w) for w in words], stdin=subprocess.DEVNULL,
                                            stdout=subprocess.DEVNULL, stderr=stderr)
        self.pid = self.process.pid

    def send(self, number):
        self.process.send_signal(number)

    def wait(self):
        return self.process.wait(timeout=PATIENCE)

    def end(self, number=signal.SIGTERM):
        """Ends it and returns its exit status (negative: the signal)."""
        if self.process.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                self.send(signal.SIGCONT)
            self.send(number)
        return self.wait()

    def says(self):
        return self.log.read_text(errors="replace")


class Case(unittest.TestCase):
    """A test with its own folder, which is removed at the end of the test."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClass(tempfile.TemporaryDirectory(prefix="vacuform-test-")))

    @classmethod
    def enterClass(cls, context):
        value = context.__enter__()
        cls.addClassCleanup(context.__exit__, None, None, None)
        return value

    maxDiff = None


class Server:
    """The real vacuform-server on its own port; `workers` are its children."""

    def __init__(self, folder, workers=2, options=()):
        self.folder = folder
        self.data = folder / "data"
        self.port = free_port()
        self.url = f"http://127.0.0.1:{self.port}"
        self.api = self.url + "/api/v1"
        self.workers, self.options = workers, options
        self.program = None
        self.token_file = self.data / "admin-token"
        TOKEN_FILES[self.url] = self.token_file

    def __enter__(self):
        return self.start()

    def __exit__(self, *_):
        self.stop()

    def start(self):
        self.program = Program([BIN / "vacuform-server", "--listen", f"127.0.0.1:{self.port}", "--data", self.data,
                                "--workers", self.workers, *self.options], self.folder / "server.log")
        wait_for(self.answers, "the server")
        return self

    def answers(self):
        if self.program.process.poll() is not None:
            raise AssertionError("the server has ended:\n" + self.program.says())
        with contextlib.suppress(ConnectionError):
            return curl(self.url + "/healthz").status == 200

    def stop(self, number=signal.SIGTERM):
        return self.program.end(number)

    def sign_in(self):
        """The arguments of curl for a browser that has signed in."""
        answer = curl("-H", "Authorization:", "-F", "token=" + self.token_file.read_text().strip(), self.url + "/sign-in")
        assert answer.status == 303, answer
        return ["-H", "Cookie: " + answer.headers["set-cookie"].partition(";")[0]]

    def sign_out(self, browser):
        """The answer to that browser."""
        return curl(*browser, "-X", "POST", "-H", f"Origin: {self.url}", self.url + "/sign-out")

    def post(self, scan, pattern, settings=None, *more):
        """The answer to a new job."""
        words = ["-F", f"scan=@{scan}", "-F", f"pattern=@{pattern}", *more]
        if settings is not None:
            words += ["-F", "settings=" + json.dumps(settings)]
        return curl(*words, self.api + "/jobs")

    def submit(self, scan, pattern, settings=None):
        """The id of a new job."""
        answer = self.post(scan, pattern, settings)
        assert answer.status == 202, answer
        assert answer.headers["location"] == "/api/v1/jobs/" + answer.json["id"], answer.headers
        return answer.json["id"]

    def job(self, job):
        answer = curl(f"{self.api}/jobs/{job}")
        assert answer.status == 200, answer
        return answer.json

    def wait(self, job, condition=lambda j: j["state"] in ("succeeded", "failed", "cancelled"), what="the end of a job"):
        """Waits until the condition holds and returns the job."""
        def look():
            found = self.job(job)
            return found if condition(found) else None
        return wait_for(look, what)

    def jobs(self):
        """All jobs, newest first, page by page."""
        found, cursor = [], ""
        while True:
            page = curl(f"{self.api}/jobs?limit=100{cursor}").json
            found += page["jobs"]
            if not page["next"]:
                return found
            cursor = "&cursor=" + page["next"]
