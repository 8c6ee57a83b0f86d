"""A PostgreSQL from Debian's packages for one test, or a primary with a synchronous standby, reachable by sockets in their
folders alone."""
import contextlib
import os
import pathlib
import pwd
import shutil
import signal
import subprocess
import tempfile
import time

from harness import children

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
        self.run("initdb", "-D", self.folder / "data", "-U", "vacuform", "-A", "trust", "--locale=C.UTF-8", "--no-sync")
        return self.start()

    def __exit__(self, *_):
        if self.process:
            self.end(signal.SIGINT)
        shutil.rmtree(self.folder)

    @staticmethod
    def run(program, *words):
        made = subprocess.run([*AS_USER, PROGRAMS / program, *words], capture_output=True, text=True, cwd="/")
        assert made.returncode == 0, made.stderr

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

    def lose(self):
        """Ends all its processes at once, as when its machine fails."""
        self.process.send_signal(signal.SIGSTOP)  # it starts none again
        for child in children(self.process.pid):
            with contextlib.suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
        self.end(signal.SIGKILL)

    def answer(self, sql):
        done = subprocess.run([PROGRAMS / "psql", "-h", self.folder, "-U", "vacuform", "-d", "postgres", "-XAtqc", sql],
                              capture_output=True, text=True, cwd="/")
        return done.stdout.strip()

    @property
    def url(self):
        return f"postgresql://vacuform@/postgres?host={self.folder}"


class PostgresPair:
    """A primary and a standby that has every commit before it is acknowledged."""

    def __init__(self):
        self.primary, self.standby = Postgres(), Postgres()

    def __enter__(self):
        self.primary.__enter__()
        self.follow()
        return self

    def __exit__(self, *words):
        self.standby.__exit__(*words)
        self.primary.__exit__(*words)

    def follow(self):
        """Makes the standby from the primary, and waits until commits wait for it."""
        data = self.standby.folder / "data"
        shutil.rmtree(data, ignore_errors=True)
        self.standby.run("pg_basebackup", "-h", self.primary.folder, "-U", "vacuform", "-D", data, "-R", "--checkpoint=fast",
                         "--no-sync")
        self.standby.start()
        self.primary.answer("ALTER SYSTEM SET synchronous_standby_names='*'")
        self.primary.answer("SELECT pg_reload_conf()")
        until = time.monotonic() + 60
        while self.primary.answer("SELECT sync_state FROM pg_stat_replication") != "sync":
            assert time.monotonic() < until, "the standby does not follow"
            time.sleep(0.1)

    def fail_over(self):
        """The primary is lost, the standby takes its place, and a new one follows it. Until then no commit is acknowledged."""
        self.primary.lose()
        assert self.standby.answer("SELECT pg_promote()") == "t"
        self.primary, self.standby = self.standby, self.primary
        self.follow()

    def answer(self, sql):
        return self.primary.answer(sql)

    @property
    def url(self):
        return f"postgresql://vacuform@/postgres?host={self.primary.folder},{self.standby.folder}"
