"""The disk fills up under the running service: what it accepted stays, what it cannot keep is refused and leaves nothing."""
import os
import shutil
import signal
import subprocess
import sys
import unittest

import hostile
from harness import Case, Server, curl

COARSE = {"sheet": {"resolution_mm": 12}, "print": {"dpi": 72}}


class DiskFull(Case):
    """In a mount namespace of its own a small tmpfs is the disk; where the machine allows none, there is nothing to be tested."""

    def test_nothing_accepted_is_lost_and_nothing_half_is_kept(self):
        disk = self.folder / "data"
        disk.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=24m,mode=700", "tmpfs", disk], check=True)
        self.addCleanup(subprocess.run, ["umount", "-l", disk])
        server = Server(self.folder, 0).start()
        self.addCleanup(lambda: server.stop())
        scan, pattern = self.folder / "scan.stl", self.folder / "p.svg"
        pattern.write_bytes(hostile.GOOD_SVG)
        accepted, refused = [], 0
        for number in range(40):  # a mebibyte each, no two the same
            scan.write_bytes(hostile.stl(hostile.dome_triangles(scale=1 + number / 1000) * 54))
            answer = server.post(scan, pattern, COARSE)
            if answer.status == 202:
                accepted.append(answer.json["id"])
                self.assertEqual(refused, 0, "nothing has been freed in between")
            else:
                self.assertIn(answer.status, (503, 507), answer)
                self.assertEqual(answer.headers["content-type"], "application/problem+json")
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
        self.assertEqual(len(blobs), len(accepted) + 1)  # the pattern is everyone's
        self.assertEqual([p for p in (disk / "incoming").rglob("*") if p.is_file()], [])

        for job in accepted[:3]:  # room again, once something is deleted
            self.assertEqual(curl("-X", "POST", f"{server.api}/jobs/{job}/cancel").status // 100, 2)
            self.assertEqual(curl("-X", "DELETE", f"{server.api}/jobs/{job}").status, 204)
        self.assertEqual(server.post(scan, pattern, COARSE).status, 202)
        self.assertEqual(len(server.jobs()), len(accepted) - 2)


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
