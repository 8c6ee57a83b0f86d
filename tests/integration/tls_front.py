"""The real nginx with TLS, as deploy/front configures it, in front of servers of a test, with a certificate made here."""
import contextlib
import os
import pathlib
import shutil
import subprocess

from harness import TOKEN_FILES, Program, curl, free_port, wait_for

DEPLOY = pathlib.Path(__file__).resolve().parents[2] / "deploy"
NGINX = shutil.which("nginx") or "/usr/sbin/nginx"
NAME = "front.localhost"


class TlsFront:
    def __init__(self, folder):
        self.folder = folder
        self.http, self.https = free_port(), free_port()
        self.url = f"https://{NAME}:{self.https}"
        self.certificate, self.key = folder / "certificate.pem", folder / "key.pem"
        self.nginx = None

    @contextlib.contextmanager
    def serve(self, servers):
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2",
                        "-subj", f"/CN={NAME}", "-addext", f"subjectAltName=DNS:{NAME}", "-keyout", self.key, "-out", self.certificate],
                       check=True, capture_output=True)
        upstreams = [word for server in servers for word in ("--upstream", f"127.0.0.1:{server.port}")]
        site = subprocess.run([DEPLOY / "front", "--print", "--name", NAME, "--certificate", self.certificate, "--key", self.key,
                               *upstreams, "--http", f"127.0.0.1:{self.http}", "--https", f"127.0.0.1:{self.https}"],
                              check=True, capture_output=True, text=True).stdout
        temporary = "".join(f"{kind}_temp_path {self.folder}/nginx-{kind};\n" for kind in
                            ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
        user = "user root;\n" if os.geteuid() == 0 else ""
        (self.folder / "nginx.conf").write_text(
            f"{user}daemon off;\nworker_processes 1;\npid {self.folder}/nginx.pid;\nerror_log {self.folder}/nginx.log;\nevents {{ worker_connections 4096; }}\n"
            f"http {{\naccess_log off;\ntypes {{}}\n{temporary}{site}\n}}\n")
        self.nginx = Program([NGINX, "-c", self.folder / "nginx.conf", "-e", self.folder / "nginx.log"], self.folder / "nginx.out")
        try:
            TOKEN_FILES[self.url] = servers[0].token_file
            wait_for(self.answers, "nginx")
            yield self
        finally:
            self.nginx.end()

    def answers(self):
        assert self.nginx.process.poll() is None, self.nginx.says() + (self.folder / "nginx.log").read_text()
        try:
            return self.ask("/healthz").status == 200
        except ConnectionError:
            return False

    def ask(self, path, *words):
        return curl("--resolve", f"{NAME}:{self.https}:127.0.0.1", "--resolve", f"{NAME}:{self.http}:127.0.0.1",
                    "--cacert", self.certificate, *words, path if "://" in path else self.url + path)
