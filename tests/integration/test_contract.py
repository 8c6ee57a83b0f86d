"""The validator itself: it refuses what the description refuses, and the real server's exchanges pass it."""
import json
import re
import unittest

from contract import DESCRIPTION, Broken, Contract
from harness import Case, Server, curl


class Validator(unittest.TestCase):
    def setUp(self):
        self.contract = Contract()

    def answer(self, method, path, status, media, value):
        self.contract.check(method, "http://127.0.0.1:1" + path, {}, status, {"content-type": media},
                            value if isinstance(value, bytes) else json.dumps(value).encode())

    def test_refuses_what_is_not_described(self):
        scan = {"id": "x", "created": "2026", "bytes": 1, "sha256": "0" * 64, "extension": "stl"}
        self.answer("GET", "/api/v1/scans/x", 200, "application/json", scan)
        wrong = [{**scan, "bytes": 0}, {**scan, "bytes": "1"}, {**scan, "sha256": "0"}, {**scan, "extension": "STL"},
                 {k: v for k, v in scan.items() if k != "id"}, [scan], None]
        for value in wrong:
            with self.assertRaises(Broken, msg=value):
                self.answer("GET", "/api/v1/scans/x", 200, "application/json", value)
        for method, path, status, media, body in [
                ("GET", "/api/v1/scans/x", 201, "application/json", scan),
                ("GET", "/api/v1/scans/x", 200, "text/plain", scan),
                ("GET", "/api/v1/secrets", 200, "application/json", {}),
                ("DELETE", "/api/v1/scans/x", 204, "", b"something"),
                ("GET", "/api/v1/scans/x", 404, "application/problem+json", {"type": "x"}),
                ("GET", "/api/v1/scans?page=2", 200, "application/json", {"scans": [], "next": None})]:
            with self.assertRaises(Broken, msg=(method, path, status)):
                self.answer(method, path, status, media, body)

    def test_knows_every_keyword_that_the_description_uses(self):
        def walk(schema):
            schema = self.contract.resolved(schema)
            for value in (None, 1, "text", [], {}):
                try:
                    self.contract.check_value(value, schema, "here")
                except Broken as fault:
                    self.assertNotIn("does not know", str(fault))
        for schema in self.contract.root["components"]["schemas"].values():
            walk(schema)

    def test_every_reference_leads_somewhere(self):
        for reference in set(re.findall(r"\$ref: '(#[^']+)'", DESCRIPTION.read_text())):
            self.contract.resolved({"$ref": reference})


class Exchanges(Case):
    """Every described operation that needs nothing to be there answers as described; harness.curl checks each exchange."""

    def test_every_operation_answers_as_described(self):
        contract = Contract()
        with Server(self.folder, workers=0) as server:
            asked = 0
            for path, item in contract.root["paths"].items():
                for method in item.keys() & {"get", "post", "put", "patch", "delete", "options"}:
                    url = server.url + re.sub(r"\{\w+\}", "none", path)
                    for token in [], ["-H", "Authorization: none"]:
                        answer = curl("-X", method.upper(), *token, *(["-d", "{}"] if method in ("put", "post") else []),
                                      url)
                        self.assertNotEqual(answer.status, 405, (method, path))
                        self.assertLess(answer.status, 500, (method, path))
                        asked += 1
            self.assertGreater(asked, 80)


if __name__ == "__main__":
    unittest.main()
