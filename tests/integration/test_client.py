"""The Python client in one file, against a real server."""
import hashlib
import importlib.util
import pathlib
import struct
import subprocess
import sys
import threading
import unittest

from harness import Case, Server, vacuform

PROGRAM = pathlib.Path(__file__).resolve().parents[2] / "api/clients/vacuform.py"
COARSE = {"sheet": {"resolution_mm": 6}, "print": {"dpi": 72}}


def load():
    spec = importlib.util.spec_from_file_location("vacuform_client", PROGRAM)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


client = load()


class Client(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = cls.enterClass(Server(cls.folder, workers=1))
        cls.service = client.Service(cls.server.url, cls.server.token_file.read_text().strip(), patience=60)
        sample = cls.folder / "sample"
        assert vacuform("sample", "--out", sample).returncode == 0
        cls.scan, cls.pattern = sample / "head.stl", sample / "pattern.svg"

    def test_submits_waits_and_downloads_what_the_job_made(self):
        seen = []
        job = self.service.submit(self.scan, self.pattern, COARSE, reference="CASE-12 ä", note="first\nsecond")
        self.assertEqual((job["reference"], job["note"]), ("CASE-12 ä", "first\nsecond"))
        job = self.service.wait(job["id"], lambda j: seen.append(j["state"]))
        self.assertEqual(job["state"], "succeeded", job)
        self.assertEqual(seen[-1], "succeeded")
        paths = self.service.download_all(job["id"], self.folder / "out")
        listed = {a["name"]: a["sha256"] for a in self.service.artifacts(job["id"])}
        self.assertEqual({p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in paths}, listed)
        self.assertIn("print.pdf", listed)
        turned = self.service.submit(settings={"pattern": {"rotate_deg": 10}}, from_job=job["id"])
        self.assertEqual(turned["settings"]["sheet"]["resolution_mm"], 6)
        self.assertEqual(self.service.cancel(turned["id"])["id"], turned["id"])
        self.assertEqual(turned["reference"], "CASE-12 ä")
        self.assertIn(job["id"], [j["id"] for j in self.service.jobs(state="succeeded", text="case-12 Ä")])
        self.service.wait(turned["id"])
        self.service.delete(job["id"])
        with self.assertRaises(client.Problem) as refused:
            self.service.job(job["id"])
        self.assertEqual((refused.exception.status, refused.exception.type), (404, "/problems/not-found"))

    def test_follows_a_proposal(self):
        data = bytearray(self.scan.read_bytes())  # the head at a tenth of its size, 100 mm to 254 mm in two units
        for at in range(84, len(data), 50):
            corners = struct.unpack_from("<9f", data, at + 12)
            struct.pack_into("<9f", data, at + 12, *(0.055 * x for x in corners))
        scan = self.folder / "small.stl"
        scan.write_bytes(data)
        settings = {"sheet": {"resolution_mm": 6}}
        job = self.service.wait(self.service.submit(scan, settings=settings, kind="inspection")["id"])
        self.assertEqual((job["state"], job["problem"]["type"]), ("failed", "/problems/ambiguous-units"))
        self.assertEqual([p["set"] for p in job["problem"]["proposals"]], [{"scan": {"units": "cm"}}, {"scan": {"units": "in"}}])
        merged = client.with_proposal(settings, job["problem"]["proposals"][1])
        self.assertEqual(merged, {"sheet": {"resolution_mm": 6}, "scan": {"units": "in"}})
        self.assertEqual(settings, {"sheet": {"resolution_mm": 6}})
        job = self.service.wait(self.service.submit(scan, settings=merged, kind="inspection")["id"])
        self.assertEqual(job["state"], "succeeded", job)

    def test_says_what_is_wrong_where_and_the_fix(self):
        with self.assertRaises(client.Problem) as refused:
            self.service.submit(self.scan, self.pattern, {"print": {"dpi": 1}})
        self.assertEqual((refused.exception.status, refused.exception.where), (422, "print.dpi"))
        self.assertTrue(refused.exception.what and refused.exception.fix)

    def test_refuses_a_download_that_is_damaged(self):
        job = self.service.wait(self.service.submit(self.scan, kind="inspection")["id"])
        to = self.folder / "mold.stl"
        with self.assertRaises(ValueError):
            self.service.download(job["id"], "mold.stl", to, sha256="0" * 64)
        self.assertEqual(list(self.folder.glob("mold.stl*")), [])

    def test_an_upload_goes_on_after_a_restart_of_the_server(self):
        whole = self.scan.stat().st_size
        client.PIECE, usual = whole // 5, client.PIECE
        self.addCleanup(setattr, client, "PIECE", usual)
        pieces = []
        once = self.service._once

        def broken_once(method, *rest):
            if method == "PATCH":
                pieces.append(method)
                if len(pieces) == 3:
                    self.server.stop()
                    threading.Timer(2, self.server.start).start()
            return once(method, *rest)

        self.service._once = broken_once
        self.addCleanup(setattr, self.service, "_once", once)
        upload = self.service.upload(self.scan)
        self.assertGreaterEqual(len(pieces), 6)
        job = self.service.submit(kind="inspection", scan_upload=upload)
        self.assertEqual(self.service.wait(job["id"])["state"], "succeeded")

    def test_the_program_inspects_a_scan(self):
        out = self.folder / "inspected"
        done = subprocess.run([sys.executable, PROGRAM, "--server", self.server.url, "--token-file", self.server.token_file,
                               "--scan", self.scan, "--out", out], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(sorted(done.stdout.split()), sorted(str(p) for p in out.iterdir()))
        self.assertIn("succeeded", done.stderr)
        wrong = self.folder / "wrong-token"
        wrong.write_text("vft_wrong\n")
        refused = subprocess.run([sys.executable, PROGRAM, "--server", self.server.url, "--token-file", wrong,
                                  "--scan", self.scan, "--out", out], capture_output=True, text=True)
        self.assertEqual((refused.returncode, refused.stderr.count("\n")), (2, 1), refused.stderr)


if __name__ == "__main__":
    unittest.main()
