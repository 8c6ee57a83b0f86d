"""Known attacks on a service of this kind, against the running program with two workers. None succeeds; the server's
memory always stays below 300 MiB, and /healthz always answers within a second."""
import contextlib
import http.client
import json
import pathlib
import re
import socket
import threading
import time
import unittest

import hostile
from harness import Case, Server, curl, wait_for

MOST_MEMORY_KIB = 300 * 1024
MOST_SECONDS = 1


class Health(threading.Thread):
    """Requests /healthz repeatedly; `worst` is the longest time it took, `wrong` lists everything that was not a valid
    answer."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.port, self.worst, self.asked, self.wrong = port, 0, 0, []
        self.over = threading.Event()

    def run(self):
        while not self.over.wait(0.05):
            started = time.monotonic()
            try:
                connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=20)
                connection.request("GET", "/healthz")
                if connection.getresponse().status != 200:
                    self.wrong.append("status")
                connection.close()
            except OSError as fault:
                self.wrong.append(str(fault))
            self.worst = max(self.worst, time.monotonic() - started)
            self.asked += 1


class Attacks(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        port_file = cls.folder / "status-port"
        cls.server = cls.enterClass(Server(cls.folder, 2, ["--status-port-file", port_file]))
        wait_for(port_file.exists, "the port of the other listener")  # it is written after the first listener answers
        cls.status_port = int(port_file.read_text())
        cls.health = Health(cls.status_port)
        cls.health.start()
        cls.token = cls.server.token_file.read_text().strip()

    def tearDown(self):
        """Conditions that hold during every attack."""
        self.assertEqual(self.health.wrong, [])
        self.assertLess(self.health.worst, MOST_SECONDS)
        memory = pathlib.Path(f"/proc/{self.server.program.pid}/status").read_text()
        self.assertLess(int(re.search(r"VmHWM:\s+(\d+) kB", memory)[1]), MOST_MEMORY_KIB)

    @classmethod
    def tearDownClass(cls):
        cls.health.over.set()
        cls.health.join()
        assert cls.health.asked > 20, "the health was hardly looked at"

    def connected(self, port=None):
        return socket.create_connection(("127.0.0.1", port or self.server.port), timeout=60)

    def head(self, first, *lines, token=None):
        return "\r\n".join([first + " HTTP/1.1", f"Host: 127.0.0.1:{self.server.port}", f"Authorization: Bearer {token or self.token}",
                            *lines, "", ""]).encode()

    def talk(self, *pieces):
        """Sends the pieces as long as the server accepts them, and returns its whole answer."""
        with self.connected() as connection:
            answer = []

            def listen():
                with contextlib.suppress(ConnectionError):
                    while piece := connection.recv(65536):
                        answer.append(piece)
            listener = threading.Thread(target=listen)  # reads while it sends: a reset discards unread bytes
            listener.start()
            with contextlib.suppress(OSError):  # the server closed the connection early
                for piece in pieces:
                    connection.sendall(piece)
                connection.shutdown(socket.SHUT_WR)
            listener.join()
            return b"".join(answer)

    def form(self, file_name=b"a.stl", scan=None):
        scan = hostile.stl(hostile.dome_triangles()) if scan is None else scan
        return (b'--b\r\nContent-Disposition: form-data; name="scan"; filename="' + file_name + b'"\r\n\r\n' + scan +
                b'\r\n--b\r\nContent-Disposition: form-data; name="pattern"; filename="p.svg"\r\n\r\n' + hostile.GOOD_SVG +
                b'\r\n--b\r\nContent-Disposition: form-data; name="settings"\r\n\r\n{"sheet":{"resolution_mm":12},"print":{"dpi":72}}'
                b"\r\n--b--\r\n")

    def post(self, body, *lines):
        return self.talk(self.head("POST /api/v1/jobs", "Content-Type: multipart/form-data; boundary=b",
                                   f"Content-Length: {len(body)}", *lines) + body)

    def jobs(self):
        return len(self.server.jobs())

    def test_an_oversized_chunked_body_is_refused(self):
        before = self.jobs()
        chunk = b"100000\r\n" + b"x" * 0x100000 + b"\r\n"
        answer = self.talk(self.head("POST /api/v1/jobs", "Content-Type: multipart/form-data; boundary=b", "Transfer-Encoding: chunked"),
                           *[chunk] * 200)
        self.assertRegex(answer[:20], rb"^HTTP/1.1 411 ")
        self.assertEqual(self.jobs(), before)

    def test_endless_heads_are_refused(self):
        for line in (b"X: " + b"a" * 10**6, b"X: a\r\n" * 10**5):
            answer = self.talk(self.head("GET /api/v1/jobs")[:-2], *[line] * 50)
            self.assertRegex(answer[:20], rb"^HTTP/1.1 431 ")

    def test_a_smuggled_request_is_no_request(self):
        before = self.jobs()
        body = self.form()
        hidden = self.head("POST /api/v1/jobs", "Content-Type: multipart/form-data; boundary=b", f"Content-Length: {len(body)}") + body
        for lines in ([f"Content-Length: {len(hidden)}"], ["Content-Length: 0", f"Content-Length: {len(hidden)}"],
                      ["Transfer-Encoding: chunked"], [f"Content-Length: {len(hidden)}", "Transfer-Encoding: chunked"],
                      ["Transfer-Encoding : chunked"], ["Transfer-Encoding: xchunked"], ["Content-Length: +5"], []):
            for first in ("POST /nowhere", "POST /api/v1/jobs", "GET /healthz"):
                with self.subTest(lines=lines, first=first):
                    answer = self.talk(self.head(first, "Connection: keep-alive", *lines) + hidden)
                    # None if the unread bytes reset the connection before the answer was read.
                    self.assertLessEqual(answer.count(b"HTTP/1.1 "), 1, answer)
        self.assertEqual(self.jobs(), before)

    def test_sixty_four_stalled_connections_stop_nobody(self):
        stalled = []
        try:
            for i in range(64):
                stalled.append(self.connected())
                stalled[-1].sendall(self.head("POST /api/v1/jobs", "Content-Type: multipart/form-data; boundary=b",
                                              "Content-Length: 1000000") + self.form()[:200] if i % 2 else b"GET / HTTP/1.1\r\nHo")
            started = time.monotonic()
            self.assertEqual(curl(self.server.url + "/healthz").status, 200)
            self.assertLess(time.monotonic() - started, 15)  # on the busy listener; tearDown checks the health listener
            time.sleep(3)
        finally:
            for connection in stalled:
                connection.close()

    def test_heads_that_never_end_do_not_keep_the_health_from_answering(self):
        asked = self.health.asked
        stalled = []
        try:
            for _ in range(300):
                stalled.append(self.connected(self.status_port))
                stalled[-1].sendall(b"GET /healthz HTTP/1.1\r\nHo")
            wait_for(lambda: self.health.asked > asked + 10, "some answers about the health")
        finally:
            for connection in stalled:
                connection.close()

    def test_headers_about_the_peer_are_not_believed(self):
        lies = ["REMOTE_ADDR: 6.6.6.6", "X-Forwarded-For: 6.6.6.6", "Forwarded: for=6.6.6.6", "REMOTE_PORT: 6666", "LOCAL_ADDR: 6.6.6.6"]
        self.assertRegex(self.talk(self.head("GET /api/v1/jobs", *lies)), rb"^HTTP/1.1 200 ")
        wrong = "vft_" + "0" * 60
        statuses = [self.talk(self.head("GET /api/v1/jobs", f"REMOTE_ADDR: 6.6.6.{i}", f"X-Forwarded-For: 6.6.6.{i}", token=wrong))[9:12]
                    for i in range(40)]
        self.assertIn(b"429", statuses)  # guesses are counted, whatever source address they claim
        self.assertNotIn("6.6.6.", self.server.program.says())

    def test_a_file_name_adds_no_header_and_no_path(self):
        for name in (b'a\\"\r\nSet-Cookie: evil=1\r\nX: .stl', b"a%0d%0aSet-Cookie: evil=1.stl", b"../../../../tmp/evil.stl",
                     b"evil\0.stl", b"evil\nLocation: http://evil.example.org/.stl", b"e" * 4000 + b".stl"):
            with self.subTest(name[:40]):
                answer = self.post(self.form(name))
                self.assertEqual(answer.count(b"HTTP/1.1 "), 1)
                self.assertNotIn(b"evil", answer)
                self.assertRegex(answer, rb"^HTTP/1.1 (202|400) ")
        for job in self.server.jobs():
            job = self.server.job(job["id"])
            self.assertNotIn("evil", json.dumps(job))
            extension = job["inputs"]["scan"]["extension"]
            self.assertRegex(extension, r"^[a-z0-9]{0,8}$")
        self.assertEqual([p for p in pathlib.Path(self.folder).rglob("*") if "evil" in p.name], [])
        self.assertNotIn("evil", self.server.program.says())

    def test_names_of_artifacts_lead_nowhere_else(self):
        answer = self.post(self.form())
        job = json.loads(answer.partition(b"\r\n\r\n")[2])["id"]
        secret = (self.server.data / "worker-token").read_bytes().strip()
        for name in ("../../../worker-token", "..%2f..%2f..%2fworker-token", "%2e%2e%2fworker-token", "%2fetc%2fpasswd", "..\\worker-token",
                     "print.png%00", "print.png/../../../../worker-token", "print.png%2f..%2f..%2fworker-token", ".", "..", "%", "%zz"):
            for path in (f"/api/v1/jobs/{job}/artifacts/{name}", f"/api/v1/jobs/{name}", f"/{name}"):
                with self.subTest(path):
                    answer = self.talk(self.head("GET " + path))
                    self.assertRegex(answer, rb"^HTTP/1.1 4\d\d ")
                    self.assertNotIn(secret, answer)
                    self.assertNotIn(b"root:", answer)


if __name__ == "__main__":
    unittest.main()
