"""The load on a service under chaos: prints, prints derived from others, inspections, bad scans, and jobs that are
cancelled."""
import http.client
import json
import pathlib
import random
import time
import uuid

import hostile
from harness import PATIENCE, vacuform

COARSE = {"sheet": {"resolution_mm": 8, "width_mm": 260, "height_mm": 260},
          "machine": {"window_width_mm": 250, "window_height_mm": 250}, "print": {"dpi": 72}}
PRINT = {"print.png", "print.svg", "print.pdf", "formed.ply", "mold.stl", "report.json", "report.html"}
BOUNDARY = "chaos"


def form(scan, pattern, fields):
    """The body of a submission; without a pattern if that is None."""
    parts = [("scan", "a.stl", scan), ("pattern", "a.svg", pattern), *((name, "", text.encode()) for name, text in fields.items())]
    return b"".join(f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="{name}"'.encode() +
                    (f'; filename="{file}"'.encode() if file else b"") + b"\r\n\r\n" + data + b"\r\n"
                    for name, file, data in parts if data is not None) + f"--{BOUNDARY}--\r\n".encode()


class Api:
    """Requests under one token that return None if the service does not answer."""

    def __init__(self, port, token):
        self.port, self.token = port, token

    def ask(self, method, path, body=None, headers=()):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=20)
        try:
            connection.request(method, path, body, {"Authorization": "Bearer " + self.token, **dict(headers)})
            answer = connection.getresponse()
            return answer.status, answer.read()
        except (OSError, http.client.HTTPException):
            return None
        finally:
            connection.close()

    def insist(self, *request):
        """The first answer other than "not now"."""
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            answer = self.ask(*request)
            if answer and answer[0] not in (429, 503):
                return answer
            time.sleep(0.2)
        raise AssertionError(f"{request[:2]} was never answered")

    def got(self, path):
        status, body = self.insist("GET", path)
        assert status == 200, (path, status, body[:500])
        return json.loads(body)

    def job(self, job):
        answer = self.ask("GET", "/api/v1/jobs/" + job)
        assert answer is None or answer[0] == 200, (job, answer)
        return json.loads(answer[1]) if answer else None

    def log(self, job):
        return self.got(f"/api/v1/jobs/{job}/log?limit=1000")["lines"]

    def jobs(self):
        found, cursor = [], ""
        while True:
            page = self.got("/api/v1/jobs?limit=100" + cursor)
            found += [j["id"] for j in page["jobs"]]
            if not page["next"]:
                return found
            cursor = "&cursor=" + page["next"]


class Wish:
    """One submission under its own key. `same`: what it has in common with requests that give the same result."""

    def __init__(self, api, kind, same, ends=("succeed",), artifacts=PRINT):
        self.api, self.kind, self.same, self.ends, self.artifacts = api, kind, same, ends, artifacts
        self.key = str(uuid.uuid4())
        self.body, self.type = (lambda: b""), f"multipart/form-data; boundary={BOUNDARY}"

    def __repr__(self):
        return f"{self.kind} {self.same}"

    def may(self, end):
        return end in self.ends

    def submit(self, _=None):
        """The id of the job under the key, created now or earlier. Repeated until the server answers."""
        status, body = self.api.insist("POST", "/api/v1/jobs", self.body(), {"Content-Type": self.type, "Idempotency-Key": self.key})
        assert status in (200, 202), (self, status, body[:500])
        return json.loads(body)["id"]


class Client:
    """A station that always waits for `most` jobs. The seed determines everything it does, except the times."""

    def __init__(self, api, scans, ledger, seed, most):
        self.api, self.scans, self.ledger, self.most = api, scans, ledger, most
        self.random = random.Random(seed)
        self.open, self.prints, self.cancels = [], [], {}

    def run(self, over):
        while not over.is_set():
            while len(self.open) < self.most and not over.is_set():
                self.begin()
            for job, when in list(self.cancels.items()):
                if time.monotonic() > when:
                    self.cancel(job)
            self.open = [job for job in self.open if not self.ledger.see(self.api, job)]
            over.wait(0.3)
        for job in list(self.cancels):
            self.cancel(job)

    def begin(self):
        kinds = {"print": 8, "derived": 6 if self.prints else 0, "inspection": 3, "bad": 2, "cancelled": 2}
        (kind,) = self.random.choices(list(kinds), kinds.values())
        wish = getattr(self, kind)()
        job = wish.submit()
        self.ledger.accept(job, wish)
        self.open.append(job)
        if kind == "print":
            self.prints.append((job, wish))
        if kind == "cancelled":
            self.cancels[job] = time.monotonic() + self.random.uniform(0, 4)

    def cancel(self, job):
        answer = self.api.ask("POST", f"/api/v1/jobs/{job}/cancel")
        if answer:
            assert answer[0] in (200, 202, 409), answer  # 409: the job has ended
            del self.cancels[job]

    def print(self, kind="print", ends=("succeed",)):
        scan, thickness, turn = self.random.choice(list(self.scans)), self.random.choice([0.5, 1.0]), self.random.choice([0, 20, 40])
        settings = {**COARSE, "sheet": {**COARSE["sheet"], "thickness_mm": thickness}, "pattern": {"rotate_deg": turn}}
        wish = Wish(self.api, kind, (scan, thickness, turn), ends)
        wish.body = lambda: form(*self.scans[scan], {"settings": json.dumps(settings)})
        return wish

    def cancelled(self):
        return self.print("cancelled", ("succeed", "be cancelled"))

    def derived(self):
        origin, of = self.random.choice(self.prints)
        scan, thickness, _ = of.same
        turn = self.random.choice([0, 20, 40])
        wish = Wish(self.api, "derived", (scan, thickness, turn))
        wish.type = "application/json"
        wish.body = lambda: json.dumps({"from": origin, "settings": {"pattern": {"rotate_deg": turn}}}).encode()
        return wish

    def inspection(self):
        scan = self.random.choice(list(self.scans))
        wish = Wish(self.api, "inspection", ("inspection", scan), artifacts={"findings.json", "mold.stl"})
        wish.body = lambda: form(self.scans[scan][0], None, {"kind": "inspection", "settings": json.dumps(COARSE)})
        return wish

    def bad(self):
        wish = Wish(self.api, "bad", ("bad",), ("be refused",))
        wish.body = lambda: form(hostile.stl([]), hostile.GOOD_SVG, {"settings": json.dumps(COARSE)})
        return wish


def scans(folder):
    """Scans and their patterns by name: the bundled sample and two domes."""
    made = pathlib.Path(folder, "sample")
    written = vacuform("sample", "--out", made)
    assert written.returncode == 0, written.stderr
    sample = ((made / "head.stl").read_bytes(), (made / "pattern.svg").read_bytes())
    domes = {f"dome {r}": (hostile.stl(hostile.dome_triangles(radius=r)), hostile.GOOD_SVG) for r in (40, 48)}
    return {"sample": sample, **domes}
