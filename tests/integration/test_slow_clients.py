"""Many deliberately slow clients at a time against the running program: bodies sent byte by byte, answers that are not
read, heads that never end, and downloads of zips. Other clients' requests are answered within a second at the 99th
percentile, with a token and without, and the server's memory stays below 300 MiB.

Each attack lasts VACUFORM_ATTACK_SECONDS, by default 8; the long run uses 60.
"""
import contextlib
import http.client
import json
import os
import pathlib
import re
import socket
import subprocess
import threading
import time
import unittest

import hostile
from harness import ARTIFACTS, Case, Server, wait_for

SECONDS = float(os.environ.get("VACUFORM_ATTACK_SECONDS", "8"))
MOST_MEMORY_KIB = 300 * 1024
MANY = 200
ARTIFACT_BYTES = 100 << 20  # two of them: the zip has 200 MiB


class Others(threading.Thread):
    """A client that requests one address repeatedly, each time over a new connection."""

    def __init__(self, port, path, token, status):
        super().__init__(daemon=True)
        self.port, self.path, self.status = port, path, status
        self.headers = {"Authorization": "Bearer " + token} if token else {}
        self.seconds, self.wrong = [], []
        self.over = threading.Event()

    def run(self):
        while not self.over.wait(0.02):
            started = time.monotonic()
            try:
                connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=20)
                connection.request("GET", self.path, headers=self.headers)
                answer = connection.getresponse()
                answer.read()
                if answer.status != self.status:
                    self.wrong.append(answer.status)
                connection.close()
            except OSError as fault:
                self.wrong.append(repr(fault))
            self.seconds.append(time.monotonic() - started)

    def p99(self):
        return sorted(self.seconds)[int(0.99 * (len(self.seconds) - 1))]


class SlowClients(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = cls.enterClass(Server(cls.folder, 0))
        cls.token = cls.server.token_file.read_text().strip()
        cls.job = cls.job_with_large_artifacts()

    @classmethod
    def ask(cls, method, path, token, body=b"", **headers):
        connection = http.client.HTTPConnection("127.0.0.1", cls.server.port, timeout=120)
        connection.request(method, path, body, {"Authorization": "Bearer " + token, **headers})
        answer = connection.getresponse()
        text = answer.read()
        connection.close()
        assert answer.status < 300, (method, path, answer.status, text[:300])
        return json.loads(text) if text else None

    @classmethod
    def job_with_large_artifacts(cls):
        form = (b'--b\r\nContent-Disposition: form-data; name="scan"; filename="a.stl"\r\n\r\n' + hostile.stl(hostile.dome_triangles()) +
                b'\r\n--b\r\nContent-Disposition: form-data; name="pattern"; filename="p.svg"\r\n\r\n' + hostile.GOOD_SVG + b"\r\n--b--\r\n")
        kind = {"Content-Type": "multipart/form-data; boundary=b"}
        job = cls.ask("POST", "/api/v1/jobs", cls.token, form, **kind)["id"]
        worker = (cls.server.data / "worker-token").read_text().strip()
        lease = cls.ask("POST", "/api/v1/leases", worker, b'{"worker":"slow-clients","protocol":2}', **{"Content-Type": "application/json"})
        mine = {"Vacuform-Lease": lease["lease"], "Content-Type": "application/octet-stream"}
        for name in ARTIFACTS:
            large = os.urandom(1 << 20) * (ARTIFACT_BYTES >> 20) if name in ("print.png", "formed.ply") else b"{}"
            cls.ask("PUT", f"/api/v1/leases/{job}/artifacts/{name}", worker, large, **mine)
        cls.ask("POST", f"/api/v1/leases/{job}/complete", worker, b"", **mine)
        return job

    def setUp(self):
        self.opened = []
        self.stop = threading.Event()

    def tearDown(self):
        self.stop.set()

    def connected(self):
        connection = socket.create_connection(("127.0.0.1", self.server.port), timeout=30)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.opened.append(connection.fileno())
        return connection

    def head(self, first, *lines, token=None):
        return "\r\n".join([first + " HTTP/1.1", f"Host: 127.0.0.1:{self.server.port}",
                            *(["Authorization: Bearer " + token] if token else []), *lines, "", ""]).encode()

    def attack(self, text, trickle=b"", pause=1.0):
        """Keeps MANY connections on which `text` was sent; a closed connection is opened again. Every `pause` each
        sends one more byte, or reads a few."""
        def keep(share):
            mine = [None] * share
            while not self.stop.is_set():
                for i, connection in enumerate(mine):
                    try:
                        if connection is None:
                            mine[i] = self.connected()
                            mine[i].sendall(text)
                            mine[i].setblocking(False)
                        elif trickle:
                            connection.send(trickle)
                        if not trickle and connection is not None and connection.recv(16) == b"":
                            raise ConnectionError
                    except BlockingIOError:
                        pass
                    except OSError:
                        if mine[i] is not None:
                            mine[i].close()
                        mine[i] = None
                self.stop.wait(pause)
            for connection in filter(None, mine):
                connection.close()
        threads = [threading.Thread(target=keep, args=[MANY // 4], daemon=True) for _ in range(4)]
        for thread in threads:
            thread.start()
        wait_for(lambda: len(self.opened) >= MANY, "the attackers", pause=0.01)
        return threads

    def hold(self, name, threads):
        """Measures the other clients' requests and the memory during the attack."""
        others = [Others(self.server.port, "/healthz", None, 200), Others(self.server.port, "/sign-in", None, 200),
                  Others(self.server.port, f"/api/v1/jobs/{self.job}", self.token, 200),
                  Others(self.server.port, "/api/v1/jobs?limit=5", self.token, 200)]
        for other in others:
            other.start()
        time.sleep(SECONDS)
        for other in others:
            other.over.set()
        self.stop.set()
        for thread in [*others, *threads]:
            thread.join(30)
        memory = pathlib.Path(f"/proc/{self.server.program.pid}/status").read_text()
        peak = int(re.search(r"VmHWM:\s+(\d+) kB", memory)[1])
        worst = max(other.p99() for other in others)
        print(f"\n{name}: {sum(len(o.seconds) for o in others)} requests of others, p99 {1000 * worst:.0f} ms, "
              f"slowest {1000 * max(max(o.seconds) for o in others):.0f} ms, peak memory {peak >> 10} MiB", flush=True)
        for other in others:
            self.assertEqual(other.wrong, [], other.path)
            self.assertGreater(len(other.seconds), SECONDS)
            self.assertLess(other.p99(), 1, other.path)
        self.assertLess(peak, MOST_MEMORY_KIB)

    def test_two_hundred_slow_bodies_without_a_token(self):
        kind = "Content-Type: multipart/form-data; boundary=b"
        text = self.head("POST /sign-in", kind, "Content-Length: 1000")
        self.hold("slow bodies, no token", self.attack(text, b"-"))

    def test_two_hundred_endless_bodies_without_a_token(self):
        kind = "Content-Type: multipart/form-data; boundary=b"
        text = self.head("POST /sign-in", kind, "Content-Length: 100000000000")
        self.hold("endless bodies, no token", self.attack(text, b"-"))

    def test_two_hundred_slow_bodies_with_a_token(self):
        kind = "Content-Type: multipart/form-data; boundary=b"
        part = b'--b\r\nContent-Disposition: form-data; name="scan"; filename="a.stl"\r\n\r\n'
        text = self.head("POST /api/v1/scans", kind, "Content-Length: 100000000", token=self.token) + part
        self.hold("slow bodies, token", self.attack(text, b"-"))

    def test_two_hundred_slow_readers_with_a_token(self):
        text = self.head(f"GET /api/v1/jobs/{self.job}/artifacts/print.png", token=self.token)
        self.hold("slow readers, token", self.attack(text))

    def test_two_hundred_slow_readers_without_a_token(self):
        text = self.head("GET /api/v1/openapi.yaml")
        self.hold("slow readers, no token", self.attack(text))

    def test_two_hundred_half_open_connections(self):
        self.hold("half-open", self.attack(b"GET /healthz HTTP/1.1\r\nHo", b"s"))

    def many(self, name, take):
        """64 threads that call take() until the end. The results, which must all be 200."""
        ended = []

        def again():
            while not self.stop.is_set():
                if (status := take()) is not None:
                    ended.append(status)
        threads = [threading.Thread(target=again, daemon=True) for _ in range(64)]
        for thread in threads:
            thread.start()
        self.hold(name, threads)
        self.assertEqual(set(ended) - {200}, set())
        return len(ended)

    def test_sixty_four_downloads_of_a_zip(self):
        """A zip of 200 MiB, repeatedly, at 8 MiB per second each."""
        def take():
            with subprocess.Popen(["curl", "-sS", "--noproxy", "*", "--limit-rate", "8M", "-H", "Authorization: Bearer " + self.token,
                                   "-w", "%{stderr}%{http_code}", "-o", "/dev/null", f"{self.server.api}/jobs/{self.job}/artifacts.zip"],
                                  stderr=subprocess.PIPE, text=True) as client:
                while client.poll() is None and not self.stop.wait(0.05):
                    pass
                if client.poll() is None:
                    client.kill()
                    return None
                return int(client.stderr.read())
        self.many("64 x artifacts.zip", take)
        self.assertEqual(list((self.server.data / "incoming").iterdir()), [])

    def test_sixty_four_questions_about_a_zip(self):
        """Some hundred a second in all: clients that ask faster take the two cores from the server that is measured."""
        def take():
            self.stop.wait(0.4)
            connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=30)
            with contextlib.closing(connection):
                connection.request("HEAD", f"/api/v1/jobs/{self.job}/artifacts.zip", headers={"Authorization": "Bearer " + self.token})
                return connection.getresponse().status
        self.assertGreater(self.many("64 x HEAD artifacts.zip", take), 64)


if __name__ == "__main__":
    unittest.main()
