"""deploy/install and the units of deploy/units: what is laid where, and that it runs with the rights that it is given."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import unittest

import hostile
from harness import BIN, PATIENCE, Case, free_port

DEPLOY = pathlib.Path(__file__).resolve().parents[2] / "deploy"
UNITS = ("vacuform-server.service", "vacuform-worker@.service")
SMALL = {"sheet": {"resolution_mm": 8, "width_mm": 150, "height_mm": 150},
         "machine": {"window_width_mm": 140, "window_height_mm": 140}, "print": {"dpi": 72}}


def script(path, text):
    path.write_text("#!/bin/bash\n" + text)
    path.chmod(0o755)


class Units(Case):
    """As systemd's own judge sees them, without a systemd that runs."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for unit in UNITS:
            (cls.folder / unit).write_text((DEPLOY / "units" / unit).read_text().replace("@BIN@", str(BIN.resolve())))

    def analyze(self, *words):
        return subprocess.run(["systemd-analyze", *words], cwd=self.folder, capture_output=True, text=True)

    def test_systemd_takes_them_without_a_word(self):
        done = self.analyze("verify", "--man=no", *(f"./{unit}" for unit in UNITS))
        self.assertEqual((done.returncode, done.stdout + done.stderr), (0, ""))

    def test_they_expose_little(self):
        """The measure of `systemd-analyze security`, from 0 to 10; a unit without any hardening has 9.6."""
        for unit, most in zip(UNITS, (1.5, 2.5)):
            done = self.analyze("security", "--offline=true", f"--threshold={int(most * 10)}", "--no-pager", f"./{unit}")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_worker_can_still_confine_its_jobs(self):
        """worker/agent/sandbox.cpp: namespaces for users, processes, network and IPC; Landlock, which this systemd's groups of calls may lack; seccomp."""
        text = (DEPLOY / "units" / UNITS[1]).read_text()
        self.assertIn("\nRestrictNamespaces=user pid net ipc\n", text)
        calls = re.search(r"^SystemCallFilter=@system-service (.*)$", text, re.M)[1].split()
        self.assertEqual(calls, ["landlock_create_ruleset", "landlock_add_rule", "landlock_restrict_self", "seccomp"])
        self.assertNotIn("~@process", text)

    def test_a_stop_is_told_to_the_program_alone(self):
        """A job's child that got the signal too would be taken for one that crashed; the programs need up to ten seconds."""
        for unit in UNITS:
            text = (DEPLOY / "units" / unit).read_text()
            self.assertIn("\nKillMode=mixed\n", text)
            self.assertGreater(int(re.search(r"^TimeoutStopSec=(\d+)$", text, re.M)[1]), 20)


class Install(Case):
    """In a checkout of its own with the programs that were built; the packages and the build are stood in for."""

    def setUp(self):
        self.here = self.folder / self.id().rpartition(".")[2]
        self.checkout = self.here / "checkout"
        self.checkout.mkdir(parents=True)
        shutil.copytree(DEPLOY, self.checkout / "deploy")
        script(self.checkout / "deploy" / "packages", "echo 'Packages: all installed.'\n")
        (self.here / "path").mkdir()
        script(self.here / "path" / "cmake", f"""
            case $1 in
              --install) exec {shutil.which("cmake")} --install {BIN.resolve().parent} "${{@:3}}" ;;
            esac
            """)
        self.environment = {k: v for k, v in os.environ.items() if not k.startswith("VACUFORM_")}
        self.environment["PATH"] = f"{self.here / 'path'}:{os.environ['PATH']}"

    def install(self, *words, **environment):
        return subprocess.run([self.checkout / "deploy" / "install", *map(str, words)], env=self.environment | environment,
                              capture_output=True, text=True, timeout=PATIENCE)

    def installed(self, *words, **environment):
        done = self.install(*words, **environment)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_files_below_a_root_of_their_own(self):
        root = self.here / "root"
        said = self.installed("--prefix", "/opt/vacuform", "--listen", "127.0.0.1:9000", "--front", "https://vacuform.example.org",
                              DESTDIR=str(root))
        self.assertIn("users, tokens and services are made without DESTDIR", said)
        self.assertEqual(sorted(p.name for p in (root / "opt/vacuform/bin").iterdir()), ["vacuform", "vacuform-server", "vacuform-worker"])
        self.assertTrue((root / "opt/vacuform/share/vacuform/profiles/sheet-a4.json").exists())
        for unit, program in zip(UNITS, ("vacuform-server\n", "vacuform-worker --name %H-%i\n")):
            text = (root / "etc/systemd/system" / unit).read_text()
            self.assertIn("\nExecStart=/opt/vacuform/bin/" + program, text)
            self.assertNotRegex(text, "@[A-Z]+@")
        for program, token in ("server", None), ("worker", "VACUFORM_TOKEN"):
            environment = self.environment | ({token: "vft_0123456789abcdef_" + "0" * 64} if token else {})
            checked = subprocess.run([BIN / f"vacuform-{program}", "--check-config", "--config", root / f"etc/vacuform/{program}.json"],
                                     env=environment, capture_output=True, text=True)
            self.assertEqual(checked.returncode, 0, checked.stderr)
            settings = json.loads(checked.stdout)
            if program == "server":
                self.assertEqual([settings[k] for k in ("data", "listen", "status_listen", "front")],
                                 ["/var/lib/vacuform", "127.0.0.1:9000", "127.0.0.1:9001", "https://vacuform.example.org"])
            else:
                self.assertEqual([settings[k] for k in ("server", "work")], ["http://127.0.0.1:9000", "/var/cache/vacuform-worker"])

    def test_settings_of_an_administrator_are_kept(self):
        root = self.here / "root"
        self.installed(DESTDIR=str(root))
        mine = root / "etc/vacuform/server.json"
        mine.write_text('{"workers": 1}')
        said = self.installed("--listen", "127.0.0.1:9000", DESTDIR=str(root))
        self.assertRegex(said, rf'{mine} is kept as it is\..*\n{{\n(  .*\n)*  "listen": "127.0.0.1:9000",\n')
        self.assertIn('"server": "http://127.0.0.1:9000"', said)  # what the workers would be told
        self.assertEqual(mine.read_text(), '{"workers": 1}')

    def test_workers_of_a_service_that_listens_everywhere_go_to_loopback(self):
        root = self.here / "root"
        self.installed("--listen", "0.0.0.0:9000", "--front", "https://vacuform.example.org", DESTDIR=str(root))
        self.assertEqual(json.loads((root / "etc/vacuform/worker.json").read_text())["server"], "http://127.0.0.1:9000")
        self.assertEqual(json.loads((root / "etc/vacuform/server.json").read_text())["status_listen"], "0.0.0.0:9001")

    def test_workers_alone(self):
        root, token = self.here / "root", self.here / "token"
        token.write_text("vft_0123456789abcdef_" + "0" * 64 + "\n")
        self.installed("--server", "https://vacuform.example.org", "--token-file", token, DESTDIR=str(root))
        self.assertEqual(json.loads((root / "etc/vacuform/worker.json").read_text())["server"], "https://vacuform.example.org")
        self.assertFalse((root / "etc/vacuform/server.json").exists())
        self.assertEqual([p.name for p in (root / "etc/systemd/system").iterdir()], ["vacuform-worker@.service"])

    def test_options_that_make_no_sense(self):
        for words, complaint in ((["--listen"], "lacks its value"), (["--listen", "8080"], "HOST:PORT"), (["--workers", "100"], "from 0 to 99"),
                                 (["--front", "http://a"], "https://NAME"), (["--prefix", "opt"], "whole path"), (["--colour", "x"], "unknown option"),
                                 (["--server", "ftp://a"], "http://"), (["--server", "http://a"], "--token-file"),
                                 (["--token-file", "/dev/null"], "goes with --server")):
            refused = self.install(*words, DESTDIR=str(self.here / "root"))
            self.assertEqual(refused.returncode, 2, words)
            self.assertIn(complaint, refused.stderr)

    def test_setup_refuses_options_that_make_no_sense(self):
        for words, complaint in ((["--workers", "100"], "from 0 to 99"), (["--bin"], "lacks its value"), (["--colour"], "unknown option"),
                                 (["--token-file", "/dev/null"], "and --workers-only"),
                                 (["--workers-only", "--token-file", "/none"], "a file that can be read")):
            refused = subprocess.run([DEPLOY / "setup", *words], env=self.environment, capture_output=True, text=True)
            self.assertEqual(refused.returncode, 2, words)
            self.assertIn(complaint, refused.stderr)

    @unittest.skipUnless(os.geteuid() == 0, "only root can make users")
    def test_really_installed_and_run_without_systemd(self):
        """All of it, in a mount namespace whose /etc, /opt, /run and /var are its own; started by the commands that it tells."""
        shutil.copytree("/etc", self.here / "etc", symlinks=True)
        for name in ("passwd", "group", "shadow", "gshadow"):  # as if Vacuform had never been started here
            lines = (self.here / "etc" / name).read_text().splitlines(keepends=True)
            (self.here / "etc" / name).write_text("".join(line for line in lines if not line.startswith("vacuform")))
        for name, data in ("head.stl", hostile.stl(hostile.dome_triangles())), ("coils.svg", hostile.GOOD_SVG):
            (self.here / name).write_bytes(data)
        (self.here / "small.json").write_text(json.dumps(SMALL))
        port = free_port(2)
        inside = self.here / "inside"
        script(inside, f"""
            set -euo pipefail
            mount --bind etc /etc
            for own in /opt /run /var/lib /var/cache /var/backups; do mount -t tmpfs -o mode=755 own $own; done
            install=(checkout/deploy/install --prefix /opt/vacuform --listen 127.0.0.1:{port})
            "${{install[@]}}" > first
            sed -i 's/"cache_days": 1/"cache_days": 2/' /etc/vacuform/worker.json
            "${{install[@]}}" > second
            while read -r command; do eval "$command" 2>> log & done < <(sed -n 's/^    \\(.*vacuform-\\(server\\|worker\\)\\)$/\\1/p' second)
            for _ in {{1..600}}; do curl -sf --noproxy '*' -o health http://127.0.0.1:{port}/healthz && break; sleep 0.1; done
            make=$(sed -n 's/^    \\(.*token create.*\\)$/\\1/p' second)
            VACUFORM_TOKEN=$(eval "$make") vacuform submit --server http://127.0.0.1:{port} --scan head.stl --pattern coils.svg \\
              --settings small.json --wait --out out
            stat -c '%U:%G %a %n' /var/lib/vacuform /var/cache/vacuform-worker /etc/vacuform/sign-in.token /etc/vacuform/worker.token /etc/vacuform/server.json > modes
            runuser -u vacuform -- vacuform-server backup --to /var/backups/vacuform/monday > backup
            ps -eo user:20,comm | sort -u > users
            ! runuser -u vacuform-worker -- ls /var/lib/vacuform 2>> refused
            ! runuser -u vacuform-worker -- cat /etc/vacuform/worker.token 2>> refused
            pkill -TERM -x vacuform-server
            pkill -TERM -x vacuform-worker
            wait
            """)
        done = subprocess.run(["unshare", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc", "--propagation", "private", inside], cwd=self.here,
                              env=self.environment | {"PATH": f"{self.environment['PATH']}:/opt/vacuform/bin:/usr/sbin:/sbin"},
                              capture_output=True, text=True, timeout=PATIENCE)
        log = (self.here / "log").read_text() if (self.here / "log").exists() else ""
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr + log)
        first, second = ((self.here / name).read_text() for name in ("first", "second"))
        self.assertIn("The user vacuform-worker is made.", first)
        self.assertIn("The workers' token is made, in /etc/vacuform/worker.token, for root alone.", first)
        self.assertIn("systemd does not run here", first)
        self.assertIn("/etc/vacuform/worker.json is kept as it is.", second)
        self.assertNotIn("is made", second)
        self.assertEqual((self.here / "out" / "print.png").read_bytes()[:4], b"\x89PNG")
        self.assertEqual((self.here / "modes").read_text().splitlines(),
                         ["vacuform:vacuform 700 /var/lib/vacuform", "vacuform-worker:vacuform-worker 700 /var/cache/vacuform-worker",
                          "root:root 600 /etc/vacuform/sign-in.token", "root:root 600 /etc/vacuform/worker.token", "root:root 644 /etc/vacuform/server.json"])
        self.assertEqual(json.loads((self.here / "backup").read_text())["damaged"], [])
        users = (self.here / "users").read_text().split("\n")
        self.assertIn(["vacuform", "vacuform-server"], [line.split() for line in users])
        self.assertIn(["vacuform-worker", "vacuform-worker"], [line.split() for line in users])
        self.assertEqual((self.here / "refused").read_text().count("Permission denied"), 2)
        self.assertIn('"event":"server-stopped"', log)


if __name__ == "__main__":
    unittest.main()
