"""The validator itself: it refuses what the description refuses, and the real server's exchanges pass it."""
import base64
import hashlib
import json
import re
import unittest

from contract import DESCRIPTION, METHODS, Broken, Contract, Part
import hostile
from harness import ARRAY_ARTIFACTS, CONTRACT, Case, Server, curl


class Validator(unittest.TestCase):
    def setUp(self):
        self.contract = Contract()

    def answer(self, method, path, status, media, value):
        self.contract.check(method, "http://127.0.0.1:1" + path, {}, status, {"content-type": media},
                            value if isinstance(value, bytes) else json.dumps(value).encode())

    def test_refuses_what_is_not_described(self):
        scan = {"id": "x", "created": "2026", "bytes": 1, "sha256": "0" * 64, "extension": "stl", "inspection": None}
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

    def ask(self, method, path, sent=None, asked=None, media=None):
        """A request that was taken: 204 is no answer of any of these, so that the request must be what is refused."""
        sent = {**(sent or {}), **({"content-type": media} if media else {})}
        operation, parameters, where = self.contract.operation(method, path.partition("?")[0])
        self.contract.check_request(operation, parameters, path.partition("?")[2], sent, asked, where)

    def test_refuses_requests_that_are_not_described(self):
        form, json_text, piece = "multipart/form-data", "application/json", "application/offset+octet-stream"
        scan, pattern = Part("scan", b"", True), Part("pattern", b"", True)
        tus = {"tus-resumable": "1.0.0", "upload-offset": "0"}
        by_hand = b'--b\r\nContent-Disposition: form-data; name="scan"; filename="a"\r\n\r\nx\r\n--b--\r\n'
        good = [("POST", "/api/v1/jobs", {"idempotency-key": "12345678"},
                 [scan, pattern, Part("settings", b'{"print": {"dpi": 100}}', False), Part("print.dpi", b"600", False)], form),
                ("POST", "/api/v1/jobs", {}, b'{"from": "x", "priority": -3}', json_text),
                ("POST", "/api/v1/scans", {}, by_hand, form + "; boundary=b"),
                ("PATCH", "/api/v1/uploads/x", tus, b"abc", piece),
                ("GET", "/api/v1/jobs/x?wait=30", {"if-none-match": '"1"'}, None, None)]
        bad = [("POST", "/api/v1/jobs", {}, [scan, pattern, Part("name", b"Jane", False)], form),
               ("POST", "/api/v1/jobs", {}, [scan, scan], form),
               ("POST", "/api/v1/jobs", {}, [scan, Part("settings", b"", True)], form),
               ("POST", "/api/v1/jobs", {}, [scan, Part("settings", b"[]", False)], form),
               ("POST", "/api/v1/jobs", {}, [Part("scan", b"v 0 0 0", False)], form),
               ("POST", "/api/v1/jobs", {}, [scan, Part("priority", b"11", False)], form),
               ("POST", "/api/v1/jobs", {}, None, None),
               ("POST", "/api/v1/jobs", {"idempotency-key": "short"}, [scan], form),
               ("POST", "/api/v1/jobs?dry_run=true", {}, [scan], form),
               ("POST", "/api/v1/jobs", {}, b'{"from": "x", "priority": 11}', json_text),
               ("POST", "/api/v1/jobs", {}, b'{"form": "x"}', json_text),
               ("POST", "/api/v1/jobs", {}, b'{"from": "x"}', "text/plain"),
               ("POST", "/api/v1/scans", {}, by_hand.replace(b"scan", b"skan"), form + "; boundary=b"),
               ("POST", "/api/v1/tokens", {}, b'{"owner": "Jane Doe", "scopes": ["read"]}', json_text),
               ("PATCH", "/api/v1/uploads/x", {"upload-offset": "0"}, b"abc", piece),
               ("PATCH", "/api/v1/uploads/x", {**tus, "upload-offset": "-1"}, b"abc", piece),
               ("PATCH", "/api/v1/uploads/x", {**tus, "tus-resumable": "0.2"}, b"abc", piece),
               ("GET", "/api/v1/jobs", {"range": "bytes=0-1"}, None, None),
               ("GET", "/api/v1/jobs?limit=1&limit=2", {}, None, None),
               ("GET", "/api/v1/jobs?limit=1e2", {}, None, None),
               ("DELETE", "/api/v1/jobs/x", {}, b"{}", json_text)]
        for exchange in good:
            self.ask(*exchange)
        for exchange in bad:
            with self.assertRaises(Broken, msg=exchange):
                self.ask(*exchange)

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

    def test_every_operation_describes_its_refusals(self):
        for path, item in self.contract.root["paths"].items():
            for method in item.keys() & METHODS:
                self.assertTrue(any(str(status).startswith("4") for status in item[method]["responses"]), (method, path))

    def test_every_required_property_is_described(self):
        def look(node, where):
            if isinstance(node, dict):
                if "properties" in node:
                    self.assertLessEqual(set(node.get("required", [])), set(node["properties"]), where)
                for key, value in node.items():
                    look(value, f"{where}/{key}")
            elif isinstance(node, list):
                for number, value in enumerate(node):
                    look(value, f"{where}/{number}")
        look(self.contract.root, "")

    def test_every_reference_leads_somewhere(self):
        for reference in set(re.findall(r"\$ref: '(#[^']+)'", DESCRIPTION.read_text())):
            self.contract.resolved({"$ref": reference})


OF_JSON = ["-H", "Content-Type: application/json"]
OF_BYTES = ["-H", "Content-Type: application/octet-stream"]
TUS = ["-H", "Tus-Resumable: 1.0.0"]


class Exchanges(Case):
    """Every described operation answers as described; harness.curl checks each exchange."""

    def taken(self, *words, status=200):
        answer = curl(*words)
        self.assertEqual(answer.status, status, (words, answer))
        return answer

    def lease(self):
        """A leased job, as words of curl with which its worker speaks, and its address."""
        worker = ["-H", "Authorization: Bearer " + (self.server.data / "worker-token").read_text().strip()]
        lease = self.taken(*worker, *OF_JSON, "-d", '{"worker": "w1", "sandbox": [], "protocol": 2}', self.server.api + "/leases").json
        return [*worker, "-H", "Vacuform-Lease: " + lease["lease"]], f"{self.server.api}/leases/{lease['job']}"

    def test_every_operation_is_taken(self):
        with Server(self.folder, workers=0) as self.server:
            self.scan, self.pattern = self.folder / "a.stl", self.folder / "p.svg"
            self.scan.write_bytes(hostile.stl(hostile.dome_triangles()))
            self.pattern.write_bytes(hostile.GOOD_SVG)
            self.say_what_the_service_is()
            self.use_profiles_and_tokens()
            self.use_uploads_and_scans()
            self.work_on_jobs()
            self.assertEqual(CONTRACT.all_operations() - CONTRACT.taken, {"POST /api/v1/orphans"})  # test_object_store takes it

    def say_what_the_service_is(self):
        for path in ("/healthz", "/api/v1/limits", "/api/v1/session", "/api/v1/settings-schema", "/api/v1/openapi.yaml"):
            self.taken(self.server.url + path)
        self.assertEqual(self.taken(self.server.api + "/queue").json["wanted_workers"], 0)
        copy = self.folder / "copy"
        copy.mkdir(mode=0o700)
        self.taken(*OF_JSON, "-d", json.dumps({"to": str(copy)}), self.server.api + "/backup")
        self.assertIsNotNone(self.taken(self.server.api + "/service").json["last_backup"])

    def use_profiles_and_tokens(self):
        place = self.server.api + "/profiles/house"
        put = ["-X", "PUT", *OF_JSON, "-d", '{"print": {"dpi": 100}}']
        made = self.taken(*put, "-H", "If-None-Match: *", place, status=201)
        self.taken(*put, "-H", "If-Match: " + made.headers["etag"], place)
        self.taken("-H", "If-None-Match: " + made.headers["etag"], place, status=304)
        self.taken(self.server.api + "/profiles?limit=1")
        for method in "PUT", "DELETE":
            self.taken("-X", method, place + "/default", status=204)
        self.taken("-X", "DELETE", place, status=204)
        token = self.taken(*OF_JSON, "-d", '{"owner": "station-3", "scopes": ["read"], "days": 1}', self.server.api + "/tokens",
                           status=201).json
        self.taken(self.server.api + "/tokens")
        self.taken("-X", "POST", f"{self.server.api}/tokens/{token['id']}/link", status=201)
        self.taken("-X", "DELETE", f"{self.server.api}/tokens/{token['id']}", status=204)

    def use_uploads_and_scans(self):
        uploads, bytes_ = self.server.api + "/uploads", self.scan.read_bytes()
        piece = [*TUS, "-H", "Content-Type: application/offset+octet-stream"]
        (self.folder / "half").write_bytes(bytes_[:1000])
        (self.folder / "rest").write_bytes(bytes_[1000:])
        begin = ["-X", "POST", *TUS, "-H", f"Upload-Length: {len(bytes_)}", "-H", "Upload-Metadata: input c2Nhbg==", uploads]
        self.taken("-X", "OPTIONS", uploads, status=204)
        place = self.server.url + self.taken(*begin, status=201).headers["location"]
        self.taken("-X", "OPTIONS", place, status=204)
        digest = base64.b64encode(hashlib.sha256(bytes_[:1000]).digest()).decode()
        self.taken("-X", "PATCH", *piece, "-H", "Upload-Offset: 0", "-H", f"Upload-Checksum: sha256 {digest}",
                   "--data-binary", f"@{self.folder / 'half'}", place, status=204)
        self.taken("-I", *TUS, place)
        self.taken("-X", "POST", *piece, "-H", "X-HTTP-Method-Override: PATCH", "-H", "Upload-Offset: 1000",
                   "--data-binary", f"@{self.folder / 'rest'}", place, status=204)
        upload = self.taken(place).json
        self.assertEqual(upload["offset"], len(bytes_))
        scan = self.taken("-F", "scan_upload=" + upload["id"], self.server.api + "/scans", status=201).json
        self.taken("-X", "DELETE", *TUS, place, status=204)
        self.taken(self.server.api + "/scans?limit=1")
        self.taken(f"{self.server.api}/scans/{scan['id']}")
        self.taken("-X", "DELETE", f"{self.server.api}/scans/{scan['id']}", status=204)

    def work_on_jobs(self):
        jobs = self.server.api + "/jobs"
        form = ["-F", f"scan=@{self.scan}", "-F", f"pattern=@{self.pattern}", "-F", 'settings={"print": {"dpi": 100}}']
        self.taken(*form, "-F", "print.dpi=150", self.server.api + "/validate")
        texts = ["-F", "reference=CASE-12", "-F", "note=first\nsecond"]
        first = self.taken("-H", "Idempotency-Key: 12345678", *form, *texts, jobs, status=202).json["id"]
        for _ in range(4):
            self.taken(*OF_JSON, "-d", json.dumps({"from": first, "priority": -1}), jobs, status=202)
        worker, lease = self.lease()
        for name in ("scan", "pattern"):
            self.taken(*worker, f"{lease}/inputs/{name}")
        self.taken(*worker, *OF_JSON, "-d", '{"stage": "scan", "progress": 0.5}', lease + "/heartbeat")
        self.taken(*worker, *OF_JSON, "-d", '{"first": 0, "lines": ["stage scan"]}', lease + "/log")
        self.taken(*worker, *OF_BYTES, "-T", self.scan, lease + "/artifacts/mold.stl")
        for artifact in sorted({*ARRAY_ARTIFACTS} - {"mold.stl"}):
            self.taken(*worker, *OF_BYTES, "-T", self.pattern, f"{lease}/artifacts/{artifact}")
        self.taken("-X", "POST", *worker, lease + "/complete")
        for path in ("", "?wait=1", "/log?limit=5", "/artifacts", "/artifacts/mold.stl", "/artifacts.zip", "/events"):
            self.taken(f"{jobs}/{first}{path}")
        self.taken("-r", "0-9", f"{jobs}/{first}/artifacts/mold.stl", status=206)
        changed = self.taken("-X", "PATCH", *OF_JSON, "-d", '{"reference": "CASE-13", "rescan": true}', f"{jobs}/{first}").json
        self.assertEqual((changed["reference"], changed["printed_reference"]), ("CASE-13", "CASE-12"))
        self.taken(jobs + "?limit=100&state=queued,succeeded&kind=print&created_after=2026-01-01T00:00:00Z")
        self.taken(jobs + "?full=true")
        worker, lease = self.lease()
        self.taken(*worker, *OF_JSON, "-d", '{"code": "corrupt-file", "what": "x"}', lease + "/fail")
        worker, lease = self.lease()
        self.taken("-X", "POST", lease.replace("/leases/", "/jobs/") + "/cancel")
        self.taken("-X", "POST", *worker, lease + "/cancelled")
        worker, lease = self.lease()
        self.taken("-X", "POST", *worker, lease + "/release")
        self.taken("-X", "DELETE", f"{jobs}/{first}", status=204)

    def test_every_operation_answers_as_described(self):
        contract = Contract()
        with Server(self.folder, workers=0) as server:
            asked = 0
            for path, item in contract.root["paths"].items():
                for method in item.keys() & {"get", "post", "put", "patch", "delete", "options"}:
                    url = server.url + re.sub(r"\{\w+\}", "none", path)
                    for token in [], ["-H", "Authorization: none"]:
                        body = [*OF_JSON, "-d", "{}"] if "requestBody" in item[method] else []
                        answer = curl("-X", method.upper(), *token, *body, url)
                        self.assertNotEqual(answer.status, 405, (method, path))
                        self.assertLess(answer.status, 500, (method, path))
                        asked += 1
            self.assertGreater(asked, 80)


if __name__ == "__main__":
    unittest.main()
