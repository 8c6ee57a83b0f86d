"""A hostile program in place of `vacuform`, with the real server and the real worker: all attacks at once, as jobs run.

The cases: as root with the arrangement of deploy/start (the server's own workers, as another user); as a service user
under the calls and namespaces that the worker's unit allows, imposed by a filter because systemd does not run here; in
a container without namespaces; and on a kernel without Landlock, where a worker only starts if it is configured to
accept less.
"""
import json
import os
import pathlib
import pwd
import re
import shutil
import socket
import subprocess
import time
import unittest

import confine
import hostile
from harness import BIN, Case, Program, Server, children, curl, wait_for

GOOD, TRY_ALL, SWAP, LOOP, FIFO, HARD_LINK, MANY, DEEP, DAEMON, LINK, OUT_LINK, GHOST = range(100, 112)
NOBODY = pwd.getpwnam("nobody")
ROOT = pathlib.Path(__file__).resolve().parents[2]
SECRET = b"the bytes of somebody else"


def as_nobody(filtered=None):
    """What a child does before it executes a program."""
    def change():
        os.setgroups([])
        os.setresgid(NOBODY.pw_gid, NOBODY.pw_gid, NOBODY.pw_gid)
        os.setresuid(NOBODY.pw_uid, NOBODY.pw_uid, NOBODY.pw_uid)
        if filtered:
            filtered.load()
    return change


class Hostile(Case):
    """The jobs and the checks on them; the subclasses define how the worker runs."""

    user = "nobody"
    disk_mib = 0  # of the worker's folder; 0: the disk of the test

    def setUp(self):
        self.here = self.folder / self._testMethodName
        self.here.mkdir()
        self.scan, self.pattern = self.here / "scan.stl", self.here / "pattern.svg"
        self.scan.write_bytes(hostile.stl(hostile.dome_triangles()))
        self.pattern.write_bytes(hostile.GOOD_SVG)
        self.secret = self.here / "secret"  # owned by root
        self.secret.write_bytes(SECRET)
        self.secret.chmod(0o600)
        self.listener = socket.socket()
        self.listener.bind(("127.0.0.1", 0))
        self.listener.listen()
        self.abstract = socket.socket(socket.AF_UNIX)
        self.abstract.bind(f"\0vacuform-{os.getpid()}-{self._testMethodName}")
        self.abstract.listen()
        for opened in self.listener, self.abstract:
            self.addCleanup(opened.close)
        self.bin = self.here / "bin"
        self.bin.mkdir()
        for name in "vacuform-worker", "vacuform-server":
            shutil.copy(BIN / name, self.bin)
        shutil.copy(BIN / "hostile_job", self.bin / "vacuform")

    def aims(self, *more):
        """Sets what the program attacks; each job reads it again."""
        lines = [("secret", self.secret), ("port", self.listener.getsockname()[1]), ("abstract", f"vacuform-{os.getpid()}-{self._testMethodName}"), *more]
        copy = self.bin / "new"
        copy.write_bytes((BIN / "hostile_job").read_bytes() + b"\n#TARGETS\n" + "".join(f"{name} {value}\n" for name, value in lines).encode())
        copy.chmod(0o755)
        copy.rename(self.bin / "vacuform")

    def job(self, what):
        job = self.server.submit(self.scan, self.pattern, {"print": {"dpi": what}})
        return self.server.wait(job)

    def artifact(self, job, name):
        return curl(f"{self.server.api}/jobs/{job['id']}/artifacts/{name}").body

    def programs(self):
        """Every process that runs a program of this test's folder or of its worker's work folder."""
        found = []
        for process in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                if str(process.joinpath("exe").readlink()).startswith(str(self.bin / "vacuform")):
                    found.append((int(process.name), process.joinpath("exe").readlink().name))
            except OSError:
                continue
        return found

    def hold_against(self, worker, work, foreign):
        """All attacks in turn; `foreign` selects the results that count."""
        before = self.secret.stat()
        tried = self.job(TRY_ALL)
        self.assertEqual(tried["state"], "succeeded", tried)
        done = [d for d in json.loads(self.artifact(tried, "report.json"))["done"] if foreign(d)]
        self.assertEqual(done, [])
        for what in (SWAP,) * 12 + (LOOP, FIFO, HARD_LINK, MANY, DEEP, DAEMON, LINK, OUT_LINK):
            started = time.monotonic()
            ended = self.job(what)
            with self.subTest(attack=what, state=ended["state"]):
                for artifact in ended["artifacts"]:
                    self.assertNotIn(SECRET, self.artifact(ended, artifact["name"]))
                if what in (LOOP, MANY, LINK, OUT_LINK) or ended["state"] != "succeeded":
                    self.assertIn(ended["problem"]["type"], ("/problems/internal", "/problems/out-of-time"), ended)
                self.assertLess(time.monotonic() - started, 120)
                wait_for(lambda: not any(p.name.startswith("job-") for p in work.iterdir()), "the job's folder gone", 60)
                jobs = [p for p in self.programs() if p[1] not in ("vacuform-worker", "vacuform-server")]
                self.assertEqual(jobs, [])
        after = self.secret.stat()
        self.assertEqual([after.st_mode, after.st_uid, after.st_size, after.st_nlink, after.st_mtime_ns],
                         [before.st_mode, before.st_uid, before.st_size, before.st_nlink, before.st_mtime_ns])
        self.assertEqual(self.secret.read_bytes(), SECRET)
        self.assertEqual(os.listxattr(self.secret), [])
        good = self.job(GOOD)
        self.assertEqual(good["state"], "succeeded", good)
        self.assertEqual(self.artifact(good, "report.html"), b"mine")
        self.assertIn((worker, "vacuform-worker"), self.programs())  # the same process as at the start

    def alone(self, filtered=None, *words):
        """A server without workers, and a worker beside it that runs as nobody. Returns the worker."""
        self.folder.chmod(0o711)
        self.server = Server(self.here, workers=0)
        self.addCleanup(self.server.stop)
        self.server.start()
        token = self.here / "token"
        token.write_text((self.server.data / "worker-token").read_text())
        os.chown(token, NOBODY.pw_uid, NOBODY.pw_gid)
        self.work = self.here / "work"
        self.work.mkdir(mode=0o700)
        if self.disk_mib:
            subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={self.disk_mib}m,mode=700", "tmpfs", self.work], check=True)
            self.addCleanup(subprocess.run, ["umount", "-l", self.work])
        os.chown(self.work, NOBODY.pw_uid, NOBODY.pw_gid)
        self.aims(("folder", self.server.data), ("secret", self.server.data / "admin-token"), ("secret", token), ("folder", self.work / "cache"))
        self.log = self.here / "worker.log"
        with open(self.log, "wb") as log:
            worker = subprocess.Popen([self.bin / "vacuform-worker", "--server", self.server.url, "--token-file", token, "--work", self.work,
                                       "--name", "w", "--poll-seconds", "0.05", *words], stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                      preexec_fn=as_nobody(filtered))
        self.addCleanup(worker.wait)
        self.addCleanup(worker.terminate)
        return worker

    def started(self):
        """The worker's own description of its sandbox."""
        def look():
            for line in self.log.read_text().splitlines():
                if '"worker-started"' in line:
                    return json.loads(line)
        said = wait_for(look, "the worker")
        return said["sandbox"], said["sandbox_lacks"]


class Unconfined(Hostile):
    def test_the_hostile_program_does_all_that_it_is_held_against(self):
        """Without the sandbox the attacks succeed; otherwise the tests below would prove nothing."""
        with subprocess.Popen(["sleep", "600"]) as bystander:
            self.addCleanup(bystander.kill)
            self.aims(("process", bystander.pid))
            (self.here / "settings.json").write_text(json.dumps({"print": {"dpi": TRY_ALL}}))
            subprocess.run([self.bin / "vacuform", "run"], cwd=self.here, check=True, timeout=60)
            bystander.kill()
        done = {d.split()[0] for d in json.loads((self.here / "out" / "report.json").read_text())["done"]}
        expected = {"read", "write", "empty", "truncate", "chmod", "utimensat", "link", "rename", "connect", "kill", "tgkill", "exec", "signal", "memfd_create", "sync", "future"}
        self.assertEqual(expected - done, set())


@unittest.skipUnless(os.geteuid() == 0, "only root can mount a small disk")
class SmallDisk(Hostile):
    disk_mib = 64

    def test_a_file_without_a_name_does_not_stay_on_the_disk(self):
        self.alone()
        self.started()
        started = time.monotonic()
        ended = self.job(GHOST)
        self.assertEqual(ended["state"], "failed", ended)
        self.assertIn("disk was nearly full", ended["problem"]["what"])
        self.assertLess(time.monotonic() - started, 60)
        good = self.job(GOOD)
        self.assertEqual(good["state"], "succeeded", good)


class Calls(Case):
    """The calls of real jobs. One that is missing from the list would be refused on a machine whose libraries make it."""

    def called_by(self, *words):
        trace = self.folder / "trace"
        done = subprocess.run(["strace", "-f", "-qq", "-o", trace, BIN / "vacuform", *words], cwd=self.folder,
                              capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return set(re.findall(r"^\d+ +(\w+)\(", trace.read_text(errors="replace"), re.MULTILINE))

    def test_a_job_makes_no_call_that_is_not_on_the_list(self):
        text = (ROOT / "worker/agent/sandbox.cpp").read_text()
        allowed = set(re.findall(r'"(\w+)"', text[text.index("allowed_calls{"):text.index("struct Release")]))
        allowed |= set(re.findall(r"SCMP_SYS\((\w+)\)", text)) | {"execve"}  # execve is what strace itself makes
        self.assertFalse(allowed & {"memfd_create", "socket", "sync", "fallocate", "kill", "mount", "fork"})
        subprocess.run([BIN / "vacuform", "sample", "--out", self.folder / "sample"], check=True, capture_output=True)
        subprocess.run([BIN / "vacuform", "sample", "--model", "mask", "--out", self.folder / "models"], check=True, capture_output=True)
        coarse = "--set=sheet.resolution_mm=8", "--set=print.dpi=72"
        drawing = "run", "--scan", "sample/head.stl", "--pattern", "sample/pattern.svg", *coarse
        os.mkdir(self.folder / "cache", 0o700)
        jobs = [(*drawing, "--set=coils.decouple=true", "--cache", "cache", "--out", "one", "--progress", "json"),
                (*drawing, "--cache", "cache", "--out", "two"),
                (*drawing, "--set=forming.model=mass_spring", "--out", "three"),
                ("run", "--scan", "models/mask.glb", "--set=pattern.source=scan", *coarse, "--out", "four"),
                ("inspect", "--scan", "sample/head.stl", "--out", "five")]
        for job in jobs:
            self.assertEqual(self.called_by(*job) - allowed, set(), job)


@unittest.skipUnless(os.geteuid() == 0, "only root can start workers as another user")
class AsRoot(Hostile):
    def test_the_server_s_own_workers(self):
        self.server = Server(self.here, workers=1, options=["--worker-user", "nobody", "--worker-program", self.bin / "vacuform-worker"])
        self.folder.chmod(0o700)  # the user nobody cannot enter it
        (self.bin / "vacuform-worker").chmod(0o755)
        data = self.server.data
        self.aims(("folder", data), ("secret", data / "admin-token"), ("secret", data / "worker-token"), ("secret", data / "jobs.sqlite"),
                  ("folder", data / "workers" / "cache"))
        self.server.start()
        self.addCleanup(self.server.stop)
        (worker,) = wait_for(lambda: children(self.server.program.pid), "the worker")
        wait_for(lambda: os.stat(f"/proc/{worker}/mem").st_uid == 0 and  # no other user may read its memory
                 f"Uid:\t{NOBODY.pw_uid}\t" in pathlib.Path(f"/proc/{worker}/status").read_text(), "the worker's new user")
        self.assertEqual(data.stat().st_mode & 0o777, 0o700)
        self.assertEqual((data / "workers").stat().st_uid, NOBODY.pw_uid)
        self.hold_against(worker, data / "workers", lambda done: True)


@unittest.skipUnless(os.geteuid() == 0, "only root can become the service's user")
class AsService(Hostile):
    def test_under_the_calls_that_its_unit_allows(self):
        worker = self.alone(confine.as_the_unit_allows())
        self.assertEqual(self.started(), (["namespaces", "landlock", "seccomp"], []))
        self.hold_against(worker.pid, self.work, lambda done: True)

    def test_in_a_container_without_namespaces(self):
        worker = self.alone(confine.without_namespaces())
        self.assertEqual(self.started(), (["landlock", "seccomp"], ["namespaces"]))
        self.hold_against(worker.pid, self.work, lambda done: True)

    def test_without_landlock_a_worker_does_not_start(self):
        worker = self.alone(confine.without_landlock())
        self.assertEqual(worker.wait(timeout=60), 2)
        self.assertIn("this machine lacks landlock, without which no job runs", self.log.read_text())
        self.assertIn("set sandbox to best-effort", self.log.read_text())

    def test_without_landlock_the_best_effort_keeps_all_but_this_user_s_own_files(self):
        worker = self.alone(confine.without_landlock(), "--sandbox=best-effort")
        self.assertEqual(self.started(), (["namespaces", "seccomp"], ["landlock"]))
        self.assertFalse((self.work / "cache").exists())  # no files of other owners are there
        token = str(self.here / "token")  # its user may read and delete it
        self.hold_against(worker.pid, self.work, lambda done: not (done.endswith(token) and done.split()[0] in ("read", "write", "link", "rename")))


if __name__ == "__main__":
    unittest.main()
