"""An object store that speaks S3 for tests: OpenStack Swift from Debian's packages, on loopback, with its files in a
folder of its own.

As a program it serves until its standard input ends: it prints the address of its bucket and its access key, and
then does what each line of the input says: `kill`, `start`, `quota BYTES`.
"""
import contextlib
import hashlib
import os
import pathlib
import pwd
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

os.environ.setdefault("VACUFORM_BIN", "")
from harness import free_port  # noqa: E402

KEY_ID, SECRET, BUCKET = "vac:form", "a-secret-of-the-tests", "vacuform"
ENVIRONMENT = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin"}  # Swift runs with Debian's Python
SERVERS = ("account", "container", "object", "proxy")
PIPELINE = ("catch_errors gatekeeper healthcheck cache listing_formats bulk s3api tempauth container-quotas slo dlo copy"
            " versioned_writes symlink proxy-server")


class Swift:
    def __init__(self):
        assert all(shutil.which(f"swift-{name}-server", path="/usr/bin") for name in SERVERS), \
            "OpenStack Swift is not installed; deploy/packages --tests installs it"
        self.user = pwd.getpwnam("swift") if os.geteuid() == 0 else pwd.getpwuid(os.geteuid())
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="vacuform-s3-"))
        self.as_user = ["setpriv", "--reuid=swift", "--regid=swift", "--clear-groups"] if os.geteuid() == 0 else []
        first = free_port(5)
        self.ports = {name: first + i for i, name in enumerate((*SERVERS, "memcached"))}
        self.endpoint = f"http://127.0.0.1:{self.ports['proxy']}"
        self.processes = []

    @property
    def url(self):
        return f"s3://{BUCKET}?endpoint={self.endpoint}"

    @property
    def environment(self):
        return {"AWS_ACCESS_KEY_ID": KEY_ID, "AWS_SECRET_ACCESS_KEY": SECRET}

    def __enter__(self):
        try:
            self.configure()
            self.start()
            self.request("PUT", "")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        self.kill()
        shutil.rmtree(self.folder)

    def configure(self):
        (self.folder / "swift.conf").write_text("[swift-hash]\nswift_hash_path_prefix = a\nswift_hash_path_suffix = b\n"
                                                "[storage-policy:0]\nname = gold\ndefault = yes\n")
        common = f"[DEFAULT]\nbind_ip = 127.0.0.1\nswift_dir = {self.folder}\nuser = {self.user.pw_name}\n"
        for name in SERVERS[:3]:
            (self.folder / f"{name}.conf").write_text(
                f"{common}bind_port = {self.ports[name]}\ndevices = {self.folder}/node\nmount_check = false\nworkers = 0\n"
                f"[pipeline:main]\npipeline = {name}-server\n[app:{name}-server]\nuse = egg:swift#{name}\n")
            builder = self.folder / f"{name}.builder"
            for words in (["create", "4", "1", "1"], ["add", f"r1z1-127.0.0.1:{self.ports[name]}/d1", "1"], ["rebalance"]):
                subprocess.run(["/usr/bin/swift-ring-builder", builder, *words], check=True, env=ENVIRONMENT,
                               stdout=subprocess.DEVNULL)
        filters = "".join(f"[filter:{name}]\nuse = egg:swift#{name}\n" for name in
                          "catch_errors gatekeeper healthcheck listing_formats bulk slo dlo copy versioned_writes symlink".split())
        (self.folder / "proxy.conf").write_text(
            f"{common}bind_port = {self.ports['proxy']}\nworkers = 1\n[pipeline:main]\npipeline = {PIPELINE}\n"
            f"[app:proxy-server]\nuse = egg:swift#proxy\naccount_autocreate = true\n{filters}"
            "[filter:container-quotas]\nuse = egg:swift#container_quotas\n"
            f"[filter:cache]\nuse = egg:swift#memcache\nmemcache_servers = 127.0.0.1:{self.ports['memcached']}\n"
            "[filter:s3api]\nuse = egg:swift#s3api\nlocation = us-east-1\ns3_acl = false\nallow_multipart_uploads = true\n"
            f"min_segment_size = 1048576\n[filter:tempauth]\nuse = egg:swift#tempauth\nuser_vac_form = {SECRET} .admin\n")
        (self.folder / "node" / "d1").mkdir(parents=True)
        for path in [self.folder, *self.folder.rglob("*")]:
            os.chown(path, self.user.pw_uid, self.user.pw_gid)

    def start(self):
        programs = {name: [f"/usr/bin/swift-{name}-server", self.folder / f"{name}.conf", "-v"] for name in SERVERS}
        programs["memcached"] = ["/usr/bin/memcached", "-l", "127.0.0.1", "-p", str(self.ports["memcached"]), "-U", "0"]
        for name, words in programs.items():
            with open(self.folder / f"{name}.log", "ab") as log:
                self.processes.append(subprocess.Popen([*self.as_user, *words], cwd="/", env=ENVIRONMENT, stdout=log, stderr=log,
                                                       stdin=subprocess.DEVNULL, start_new_session=True))
        until = time.monotonic() + 60
        while not all(self.listens(port) for port in self.ports.values()):
            assert time.monotonic() < until, "Swift did not start:\n" + (self.folder / "proxy.log").read_text()
            time.sleep(0.1)

    @staticmethod
    def listens(port):
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=5):
            return True

    def kill(self):
        """kill -9 of all its processes."""
        for process in self.processes:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        self.processes = []

    def request(self, method, path, body=""):
        """A signed request to the bucket by curl, which is no part of what the tests examine; gives the answer's body."""
        host = self.endpoint.replace("http://", "http://" + KEY_ID.replace(":", "%3A") + ":" + SECRET + "@")
        done = subprocess.run(["curl", "-sS", "--fail-with-body", "--noproxy", "*", "-X", method, "--aws-sigv4",
                               "aws:amz:us-east-1:s3", "-H", "x-amz-content-sha256: " + hashlib.sha256(body.encode()).hexdigest(),
                               *(["--data-binary", body] if body else []), f"{host}/{BUCKET}{path}"],
                              capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def quota(self, most):
        """Bounds the bytes of the bucket, by Swift's own interface; 0 lifts the bound."""
        def swift(*words):
            return subprocess.run(["curl", "-sS", "--fail", "--noproxy", "*", "-i", *words], capture_output=True, text=True,
                                  check=True).stdout
        told = dict(line.split(": ", 1) for line in swift("-H", f"X-Storage-User: {KEY_ID}", "-H", f"X-Storage-Pass: {SECRET}",
                                                          self.endpoint + "/auth/v1.0").splitlines() if ": " in line)
        swift("-X", "POST", "-H", "X-Auth-Token: " + told["X-Auth-Token"],
              "-H", f"X-Container-Meta-Quota-Bytes: {most}" if most else "X-Remove-Container-Meta-Quota-Bytes: yes", f"{told['X-Storage-Url']}/{BUCKET}")

    def keys(self):
        """The keys of all objects in the bucket."""
        return re.findall(r"<Key>([^<]*)</Key>", self.request("GET", "?list-type=2"))


def main():
    with Swift() as swift:
        print(swift.url, KEY_ID, SECRET, flush=True)
        for line in sys.stdin:
            word, *numbers = line.split()
            {"kill": swift.kill, "start": swift.start, "quota": swift.quota}[word](*map(int, numbers))
            print("done", flush=True)


if __name__ == "__main__":
    main()
