"""Uploads in pieces to the real server: interrupted by the client and by kill -9, resumed, in little memory; and a job's events."""
import base64
import json
import pathlib
import signal
import unittest

import hostile
from harness import PATTERNS, Case, Server, curl, wait_for
from tus_uploads import LargeScan, ZippedScan, send, sending

MOST_MEMORY = 64 << 20


def peak_memory(pid):
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return int(line.split()[1]) << 10
    raise AssertionError("no peak of memory")


class Uploads(Case):
    def offset(self, server, place):
        def look():
            answer = curl("-I", "-H", "Tus-Resumable: 1.0.0", server.url + place)
            if answer.status == 423:  # the server has not noticed yet that the other request is over
                return None
            self.assertEqual(answer.status, 200, answer)
            return answer.headers["upload-offset"]
        return int(wait_for(look, "the end of a broken request"))

    def begin(self, server, size, file=b"Jane Doe.STL"):
        name = base64.b64encode(file).decode()
        answer = curl("-X", "POST", "-H", "Tus-Resumable: 1.0.0", "-H", f"Upload-Length: {size}", "-H",
                      f"Upload-Metadata: filename {name},input c2Nhbg==", server.api + "/uploads")
        self.assertEqual(answer.status, 201, answer)
        return answer.headers["location"]

    def test_a_large_scan_goes_on_after_a_break_and_after_a_kill(self):
        scan = LargeScan()
        with Server(self.folder, workers=0) as server:
            place = self.begin(server, scan.size)
            third = scan.size // 3
            self.assertIsNone(send(server, place, 0, third, scan))  # the client leaves
            at = self.offset(server, place)
            self.assertEqual(at, third)

            with sending(server, place, at, 2 * third, scan):
                before = peak_memory(server.program.pid)
                server.stop(signal.SIGKILL)  # in the middle of the request
            for file in server.data.rglob("*"):
                if file.suffix == ".part":
                    with file.open("rb") as part:
                        self.assertNotIn(b"Jane", part.read(84))
            server.start()
            at = self.offset(server, place)
            self.assertGreaterEqual(at, third)  # what was flushed by then is there
            self.assertLessEqual(at, 2 * third)
            self.assertGreaterEqual(at, 2 * third - (16 << 20))  # 8 MiB between flushes, and what the socket held

            self.assertEqual(send(server, place, at, scan.size, scan), 204)
            upload = curl(server.url + place).json
            self.assertEqual(upload["offset"], scan.size)
            self.assertEqual(upload["sha256"], scan.sha256(b" " * 80))
            after = peak_memory(server.program.pid)
            self.assertLess(max(before, after), MOST_MEMORY)
            print(f"{scan.size >> 20} MiB: peak memory {before >> 20} and {after >> 20} MiB", flush=True)

            kept = curl("-F", "scan_upload=" + upload["id"], server.api + "/scans")
            self.assertEqual(kept.status, 201, kept)
            form = ["-F", "scan_id=" + kept.json["id"], "-F", f"pattern=@{PATTERNS / 'rings-7x40mm.svg'}"]
            plan = curl(*form, server.api + "/validate")
            self.assertEqual((plan.status, plan.json["inputs"]["scan"]["format"]), (200, "stl"))
            job = curl(*form, server.api + "/jobs")
            self.assertEqual(job.json["inputs"]["scan"]["sha256"], upload["sha256"])
            self.assertEqual(curl("-X", "DELETE", f"{server.api}/scans/{kept.json['id']}").status, 204)
            self.assertNotIn("Jane", server.program.says())

    def test_a_zip_goes_on_after_a_break_and_after_a_kill(self):
        scan, stored = ZippedScan(), set()
        with Server(self.folder, workers=0) as server:
            for killed in False, True:
                place = self.begin(server, scan.size, b"Jane Doe.zip")
                self.assertIsNone(send(server, place, 0, scan.size // 2, scan))
                self.assertEqual(self.offset(server, place), scan.size // 2)
                if killed:
                    server.stop(signal.SIGKILL)
                    server.start()
                    self.assertEqual(self.offset(server, place), scan.size // 2)
                self.assertEqual(send(server, place, scan.size // 2, scan.size, scan), 204)
                stored.add(curl(server.url + place).json["sha256"])
            self.assertEqual(len(stored), 1)
            for path in [p for p in server.data.rglob("*") if p.is_file()]:
                self.assertNotIn(b"Jane", path.read_bytes(), path)
            broken = self.begin(server, scan.size - 30, b"Jane Doe.zip")
            scan.whole, scan.size = scan.whole[:-30], scan.size - 30
            self.assertEqual(send(server, broken, 0, scan.size, scan), 422)
            self.assertEqual(curl(server.url + broken).status, 404)  # what is refused goes

    def test_events_tell_a_job_to_its_end(self):
        scan, pattern = self.folder / "dome.stl", self.folder / "rings.svg"
        scan.write_bytes(hostile.stl(hostile.dome_triangles()))
        pattern.write_bytes(hostile.GOOD_SVG)
        (self.folder / "events").mkdir()
        with Server(self.folder / "events", workers=1) as server:
            job = server.submit(scan, pattern, {"sheet": {"resolution_mm": 6}, "print": {"dpi": 72}})
            answer = curl("-N", f"{server.api}/jobs/{job}/events")
            self.assertEqual((answer.status, answer.headers["content-type"]), (200, "text/event-stream"))
            events = [dict(line.split(": ", 1) for line in block.splitlines())
                      for block in answer.body.decode().split("\n\n") if block and not block.startswith(":")]
            jobs = [json.loads(e["data"]) for e in events if e["event"] == "job"]
            self.assertEqual(jobs[-1]["state"], "succeeded", jobs[-1])
            self.assertEqual([j["progress"] for j in jobs], sorted(j["progress"] for j in jobs))
            lines = [json.loads(e["data"])["number"] for e in events if e["event"] == "log"]
            self.assertEqual(lines, list(range(1, len(lines) + 1)))
            again = curl("-H", "Last-Event-ID: " + events[-1]["id"], f"{server.api}/jobs/{job}/events")
            self.assertEqual((again.status, again.body), (204, b""))
            known = curl(f"{server.api}/jobs/{job}").headers["etag"]
            same = curl("-H", f"If-None-Match: {known}", f"{server.api}/jobs/{job}?wait=30")
            self.assertEqual((same.status, same.body), (304, b""))


if __name__ == "__main__":
    unittest.main()
