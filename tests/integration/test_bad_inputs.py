"""Hostile and broken files and requests through the API: each ends with its own type of problem and a message that says
what is wrong, where, and how to fix it; the service keeps running."""
import socket
import unittest

import hostile
from harness import Case, Server, curl

COARSE = {"sheet": {"resolution_mm": 8}, "print": {"dpi": 72}}


class BadInputs(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = cls.enterClass(Server(cls.folder))
        cls.scan, cls.pattern = cls.folder / "good.stl", cls.folder / "good.svg"
        cls.scan.write_bytes(hostile.stl(hostile.dome_triangles()))
        cls.pattern.write_bytes(hostile.GOOD_SVG)

    def check_files(self, cases, place):
        """Submits all files before it waits for the first. What cannot be read without the names in it is refused at once."""
        jobs = {}
        for name, (slug, words, extension, make) in cases.items():
            file = self.folder / f"case.{extension}"
            file.write_bytes(make())
            files = {"scan": self.scan, "pattern": self.pattern, place: file}
            answer = self.server.post(files["scan"], files["pattern"], COARSE)
            if answer.status == 202:
                jobs[name] = answer.json["id"]
                continue
            with self.subTest(name):
                self.check_problem(answer.json, slug, words, f"{place}.{extension}")
        for name, job in jobs.items():
            slug, words, extension, _ = cases[name]
            with self.subTest(name):
                ended = self.server.wait(job)
                self.assertEqual(ended["attempt"], 1, "nothing of this may look like a fault of the worker")
                if slug is None:
                    self.assertEqual((ended["state"], ended["problem"]), ("succeeded", None))
                    continue
                self.assertEqual(ended["state"], "failed")
                self.check_problem(ended["problem"], slug, words, f"{place}.{extension}")
                self.assertEqual(ended["artifacts"], [])

    def check_problem(self, problem, slug, words, where):
        self.assertEqual(problem["type"], f"/problems/{slug}", problem)
        self.assertIn(words, problem["what"] + problem["fix"])
        self.assertIn(where, problem["where"])
        self.assertTrue(problem["fix"])

    def test_scans(self):
        self.check_files(hostile.SCANS, "scan")

    def test_patterns(self):
        self.check_files(hostile.PATTERNS, "pattern")

    def test_requests(self):
        scan, pattern = f"scan=@{self.scan}", f"pattern=@{self.pattern}"
        both = ["-F", scan, "-F", pattern]
        empty = self.folder / "empty.stl"
        empty.write_bytes(b"")
        url = self.server.api + "/jobs"
        for words, status, slug, says in [
                (["-F", scan], 400, "bad-usage", "pattern"),
                (["-F", pattern], 400, "bad-usage", "scan"),
                (["-F", f"scan=@{empty}", "-F", pattern], 400, "bad-usage", "empty"),
                (["-F", "scan=", "-F", pattern], 400, "bad-usage", "scan"),
                ([*both, "-F", scan], 400, "bad-usage", "more than one scan"),
                ([*both, "-F", "head=x"], 400, "bad-usage", "head"),
                ([*both, "-F", "settings={"], 422, "bad-settings", "not valid JSON"),
                ([*both, "-F", "settings=[]"], 422, "bad-settings", "JSON object"),
                ([*both, "-F", "settings=" + "[" * 5000], 422, "bad-settings", "nested more than 16 levels deep"),
                ([*both, "-F", 'settings={"print": {"dpi": 72, "dpi": 600}}'], 422, "bad-settings", '"dpi" twice'),
                ([*both, "-F", 'settings={"print":{"dip":3}}'], 422, "bad-settings", "print.dip"),
                ([*both, "-F", 'settings={"print":{"dpi":1e999}}'], 422, "bad-settings", ""),
                ([*both, "-F", 'settings={"sheet":{"resolution_mm":0.5,"width_mm":2000,"height_mm":2000}}'], 422,
                 "bad-settings", "coarser"),
                ([*both, "-F", "settings={" + " " * 70000 + "}"], 413, "too-large", "64 KiB"),
                (["-d", "{}", "-H", "Content-Type: text/plain"], 415, "unsupported-format", "multipart/form-data"),
                (["--data-binary", "x" * 1000, "-H", "Content-Type: multipart/form-data; boundary=b"], 400, "bad-usage", ""),
                (["--data-binary", "--b\r\nContent-Disposition: form-data; name=\"scan\"; filename=\"a.stl\"\r\n\r\nhalf",
                  "-H", "Content-Type: multipart/form-data; boundary=b"], 400, "bad-usage", "")]:
            with self.subTest(words[-1][:80]):
                answer = curl(*words, url)
                self.assertEqual((answer.status, answer.headers["content-type"]), (status, "application/problem+json"))
                problem = answer.json
                self.assertEqual((problem["type"], problem["status"]), ("/problems/" + slug, status))
                self.assertIn(says, problem["detail"])
                self.assertTrue(problem["what"] and problem["fix"], problem)

    def test_names_and_numbers_in_the_path(self):
        for path in ("/jobs/none", "/jobs/..%2f..%2fetc", "/jobs/" + "a" * 5000, "/jobs/%00", "/nothing",
                     "/jobs/none/artifacts/..%2fworker-token"):
            with self.subTest(path[:40]):
                answer = curl("--path-as-is", self.server.api + path)
                self.assertIn(answer.status, (400, 404, 414, 431))
                self.assertEqual(answer.headers["content-type"], "application/problem+json")
        self.assertEqual(curl("-X", "PATCH", self.server.api + "/jobs").status, 405)

    def raw(self, request):
        with socket.create_connection(("127.0.0.1", self.server.port), timeout=60) as connection:
            connection.sendall(request)
            connection.shutdown(socket.SHUT_WR)
            answer = b""
            while piece := connection.recv(65536):
                answer += piece
            return answer

    def test_a_refused_body_is_never_the_next_request(self):
        head = f"POST /api/v1/jobs HTTP/1.1\r\nHost: 127.0.0.1:{self.server.port}\r\n"
        smuggled = f"DELETE /api/v1/jobs/none HTTP/1.1\r\nHost: 127.0.0.1:{self.server.port}\r\n\r\n".encode()
        for framing in [f"Content-Type: text/plain\r\nContent-Length: {len(smuggled)}\r\n\r\n",
                        "Transfer-Encoding: chunked\r\n\r\n",
                        f"Content-Length: {len(smuggled)}\r\nTransfer-Encoding: chunked\r\n\r\n",
                        f"Content-Length: 0\r\nContent-Length: {len(smuggled)}\r\n\r\n",
                        "Content-Length: 99999999999999999999\r\n\r\n", "Content-Length: -1\r\n\r\n", "\r\n",
                        f"Content-Encoding: gzip\r\nContent-Length: {len(smuggled)}\r\n\r\n"]:
            with self.subTest(framing):
                answer = self.raw(head.encode() + framing.encode() + smuggled)
                self.assertEqual(answer.count(b"HTTP/1.1 "), 1, answer)
                self.assertRegex(answer.split(b"\r\n")[0].decode(), r"HTTP/1.1 (4\d\d|501) ")

    def test_endless_heads_are_refused(self):
        start = f"GET /healthz HTTP/1.1\r\nHost: 127.0.0.1:{self.server.port}\r\n".encode()
        for head in [start + b"X: " + b"a" * 10**6 + b"\r\n\r\n", start + b"".join(b"X-%d: a\r\n" % i for i in range(10**4)) + b"\r\n",
                     b"GET /" + b"a" * 10**6 + b" HTTP/1.1\r\n\r\n"]:
            try:
                answer = self.raw(head)
            except ConnectionError:  # the server may close before it has read everything
                continue
            self.assertNotRegex(answer[:20], rb"HTTP/1.1 (2|5)")
        self.assertEqual(curl(self.server.url + "/healthz").status, 200)


if __name__ == "__main__":
    unittest.main()
