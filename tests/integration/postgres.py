"""A PostgreSQL from Debian's packages for one test, reachable by a socket in its folder alone."""
import os
import pathlib
import pwd
import shutil
import signal
import subprocess
import tempfile
import time

PROGRAMS = max(pathlib.Path("/usr/lib/postgresql").glob("*/bin"), default=None)
AS_USER = ["setpriv", "--reuid=postgres", "--regid=postgres", "--clear-groups"] if os.geteuid() == 0 else []  # it refuses root


class Postgres:
    def __init__(self):
        assert PROGRAMS, "PostgreSQL is not installed; deploy/packages --tests installs it"
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="vacuform-pg-"))
        self.folder.chmod(0o711)
        if AS_USER:
            user = pwd.getpwnam("postgres")
            os.chown(self.folder, user.pw_uid, user.pw_gid)
        self.process = None

    def __enter__(self):
        made = subprocess.run([*AS_USER, PROGRAMS / "initdb", "-D", self.folder / "data", "-U", "vacuform", "-A", "trust",
                               "--locale=C.UTF-8", "--no-sync"], capture_output=True, text=True, cwd="/")
        assert made.returncode == 0, made.stderr
        return self.start()

    def __exit__(self, *_):
        self.end(signal.SIGINT)
        shutil.rmtree(self.folder)

    def start(self):
        until = time.monotonic() + 60
        while self.answer("SELECT 1") != "1":
            assert time.monotonic() < until, "PostgreSQL did not start"
            if self.process is None or self.process.poll() is not None:  # it ends while processes of a killed one are there
                self.process = subprocess.Popen([*AS_USER, PROGRAMS / "postgres", "-D", self.folder / "data", "-k", self.folder,
                                                 "-c", "listen_addresses="], cwd="/", stdin=subprocess.DEVNULL,
                                                stderr=subprocess.DEVNULL)
            time.sleep(0.1)
        return self

    def end(self, number):
        """Ends it by a signal; SIGKILL is a crash."""
        self.process.send_signal(number)
        self.process.wait()

    def answer(self, sql):
        done = subprocess.run([PROGRAMS / "psql", "-h", self.folder, "-U", "vacuform", "-d", "postgres", "-XAtqc", sql],
                              capture_output=True, text=True, cwd="/")
        return done.stdout.strip()

    @property
    def url(self):
        return f"postgresql://vacuform@/postgres?host={self.folder}"
