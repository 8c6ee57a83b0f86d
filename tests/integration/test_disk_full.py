"""The disk fills up under the running service: accepted data stays, data that cannot be stored is refused and leaves
nothing."""
import json
import os
import shutil
import signal
import subprocess
import sys
import unittest

import hostile
from harness import Case, Server, curl, wait_for

COARSE = {"sheet": {"resolution_mm": 12}, "print": {"dpi": 72}}


class DiskFull(Case):
    """A small tmpfs in a separate mount namespace is the disk; the test is skipped on machines that do not allow
    one."""

    def server_on_a_disk_of(self, mebibytes):
        folder = self.folder / f"of{mebibytes}"
        disk = folder / "data"
        disk.mkdir(parents=True)
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={mebibytes}m,mode=700", "tmpfs", disk], check=True)
        self.addCleanup(subprocess.run, ["umount", "-l", disk])
        server = Server(folder, 0).start()
        self.addCleanup(lambda: server.stop())
        return server, disk

    def expect_refused(self, answer):
        self.assertEqual(answer.status, 507, answer)
        self.assertEqual(answer.json["type"], "/problems/disk-full")
        self.assertTrue(answer.json["fix"])
        self.assertGreater(int(answer.headers["retry-after"]), 0)

    def test_nothing_accepted_is_lost_and_nothing_half_is_kept(self):
        server, disk = self.server_on_a_disk_of(24)
        scan, pattern = self.folder / "scan.stl", self.folder / "p.svg"
        pattern.write_bytes(hostile.GOOD_SVG)
        accepted, refused = [], 0
        for number in range(40):  # one mebibyte each, all different
            scan.write_bytes(hostile.stl(hostile.dome_triangles(scale=1 + number / 1000) * 54))
            answer = server.post(scan, pattern, COARSE)
            if answer.status == 202:
                accepted.append(answer.json["id"])
                self.assertEqual(refused, 0, "nothing has been freed in between")
            else:
                self.expect_refused(answer)
                refused += 1
            if refused == 3:
                break
        self.assertGreater(len(accepted), 10)
        self.assertEqual(refused, 3)
        self.assertEqual(curl(server.url + "/healthz").status, 200)

        server.stop(signal.SIGKILL)
        server.start()
        self.assertEqual([j["id"] for j in server.jobs()], accepted[::-1])
        blobs = [p for p in (disk / "blobs").rglob("*") if p.is_file()]
        self.assertEqual(len(blobs), len(accepted) + 1)  # all jobs share the pattern
        self.assertEqual([p for p in (disk / "incoming").rglob("*") if p.is_file()], [])

        for job in accepted[:3]:  # there is space again once something is deleted
            self.assertEqual(curl("-X", "POST", f"{server.api}/jobs/{job}/cancel").status // 100, 2)
            self.assertEqual(curl("-X", "DELETE", f"{server.api}/jobs/{job}").status, 204)
        self.assertEqual(server.post(scan, pattern, COARSE).status, 202)
        self.assertEqual(len(server.jobs()), len(accepted) - 2)

    def upload_until_refused(self, server):
        """Uploads of two mebibytes, in pieces, until the disk is full; returns their addresses."""
        piece = self.folder / "piece"
        places = []
        tus = ["-H", "Tus-Resumable: 1.0.0"]
        while True:
            started = curl("-X", "POST", *tus, "-H", f"Upload-Length: {1 << 21}", server.api + "/uploads")
            if started.status == 507:
                self.expect_refused(started)
                return places
            self.assertEqual(started.status, 201, started)
            places.append(server.url + started.headers["location"])
            for offset in (0, 1 << 20):
                piece.write_bytes(os.urandom(1 << 20))
                sent = curl("-X", "PATCH", *tus, "-H", "Content-Type: application/offset+octet-stream", "-H",
                            f"Upload-Offset: {offset}", "--data-binary", f"@{piece}", places[-1])
                if sent.status == 507:
                    self.expect_refused(sent)
                    return places
                self.assertEqual(sent.status, 204, sent)

    def fill(self, disk):
        """Another program fills the rest of the disk."""
        with open(disk / "somebody-elses", "ab", buffering=0) as filler:
            try:
                while True:
                    filler.write(bytes(4096))
            except OSError:
                pass

    def lease(self, server):
        worker = ["-H", "Authorization: Bearer " + (server.data / "worker-token").read_text().strip()]
        of_json = ["-H", "Content-Type: application/json", "-d", '{"protocol": 2}']
        answer = curl("-X", "POST", *worker, *of_json, server.api + "/leases")
        self.assertEqual(answer.status, 200, answer)
        words = [*worker, "-H", "Vacuform-Lease: " + answer.json["lease"]]
        return answer.json["job"], words, f"{server.api}/leases/{answer.json['job']}"

    def test_a_full_disk_stops_new_files_and_nothing_else(self):
        server, disk = self.server_on_a_disk_of(64)
        scan, pattern = self.folder / "scan.stl", self.folder / "p.svg"
        pattern.write_bytes(hostile.GOOD_SVG)
        scan.write_bytes(hostile.stl(hostile.dome_triangles()))
        jobs = [server.submit(scan, pattern, COARSE) for _ in range(6)]
        running, words, lease = self.lease(server)
        uploads = self.upload_until_refused(server)
        self.assertGreater(len(uploads), 15)
        reserve = (disk / "reserve").stat().st_blocks
        self.assertGreater(reserve, 0)
        self.fill(disk)

        def beat(progress):
            return curl("-X", "POST", *words, "-H", "Content-Type: application/json", "-d",
                        json.dumps({"stage": "scan", "progress": progress}), lease + "/heartbeat").status

        for i in range(50):
            self.assertEqual(beat(i / 50), 200)
        self.expect_refused(server.post(scan, pattern, COARSE))
        browser = server.sign_in()
        self.assertEqual(curl(*browser, server.api + "/session").status, 200)
        self.assertEqual(server.sign_out(browser).status, 303)
        jobs.remove(running)
        self.assertEqual(curl("-X", "POST", f"{server.api}/jobs/{jobs[0]}/cancel").status, 200)
        self.assertEqual(curl("-X", "DELETE", f"{server.api}/jobs/{jobs[0]}").status, 204)
        self.fill(disk)
        for number in (signal.SIGTERM, signal.SIGKILL):
            self.assertEqual(server.stop(number), 0 if number == signal.SIGTERM else -number)
            self.fill(disk)
            server.start()
            self.assertEqual({j["id"] for j in server.jobs()}, {*jobs[1:], running})
            self.assertEqual(curl(f"{server.api}/jobs/{running}").json["state"], "running")
            self.assertEqual(curl(server.api + "/limits").status, 200)

        (disk / "somebody-elses").unlink()
        for upload in uploads:
            self.assertEqual(curl("-X", "DELETE", "-H", "Tus-Resumable: 1.0.0", upload).status, 204)
        self.assertEqual(curl("-X", "POST", f"{server.api}/jobs/{running}/cancel").status, 200)
        self.assertEqual(curl("-X", "POST", *words, lease + "/cancelled").status, 200)
        for job in [*jobs[1:], running]:
            curl("-X", "POST", f"{server.api}/jobs/{job}/cancel")
            self.assertEqual(curl("-X", "DELETE", f"{server.api}/jobs/{job}").status, 204)
        self.assertEqual(server.post(scan, pattern, COARSE).status, 202)
        wait_for(lambda: (disk / "reserve").stat().st_blocks == reserve, "the reserve")


def may_mount():
    return subprocess.run(["unshare", "-Urm", "--propagation", "private", "mount", "-t", "tmpfs", "tmpfs", "/mnt"],
                          capture_output=True).returncode == 0


if __name__ == "__main__":
    if os.environ.get("VACUFORM_OWN_MOUNTS"):
        unittest.main()
    if not shutil.which("unshare") or not may_mount():
        print("this machine lets no one make a mount namespace", file=sys.stderr)
        sys.exit(77)  # ctest: skipped
    sys.exit(subprocess.run(["unshare", "-Urm", "--propagation", "private", sys.executable, *sys.argv],
                            env=dict(os.environ, VACUFORM_OWN_MOUNTS="yes")).returncode)
