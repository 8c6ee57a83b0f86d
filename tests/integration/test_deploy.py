"""deploy/start, deploy/stop and deploy/packages: what they say and what is left running.

The scripts run in a checkout of their own with the programs that were built; `cmake` and the packages, which the tests
have had already, are stood in for.
"""
import json
import os
import pathlib
import pwd
import re
import shutil
import signal
import socket
import subprocess
import unittest

from harness import BIN, PATIENCE, Case, children, curl, free_port, runs, wait_for

DEPLOY = pathlib.Path(__file__).resolve().parents[2] / "deploy"


def script(path, text):
    path.write_text("#!/bin/bash\n" + text)
    path.chmod(0o755)


class Deploy(Case):
    def setUp(self):
        self.checkout = self.folder / self.id().rpartition(".")[2]
        self.bin = self.checkout / "build" / "release" / "bin"
        self.bin.mkdir(parents=True)
        for program in ("vacuform", "vacuform-server", "vacuform-worker"):
            shutil.copy2(BIN / program, self.bin)
        shutil.copytree(DEPLOY, self.checkout / "deploy")
        script(self.checkout / "deploy" / "packages", "echo 'Packages: all installed.'\n")
        (self.checkout / "path").mkdir()
        script(self.checkout / "path" / "cmake", "exit 0\n")
        self.port = free_port(2)
        self.var = self.checkout / "var"
        self.addCleanup(self.run_script, "stop")

    def run_script(self, name, *words, **more):
        environment = {k: v for k, v in os.environ.items() if k != "VACUFORM_DATA"} | more
        environment["PATH"] = f"{self.checkout / 'path'}:{environment['PATH']}"
        return subprocess.run([self.checkout / "deploy" / name, *words], env=environment, capture_output=True, text=True,
                              timeout=PATIENCE)

    def start(self, *words, **more):
        return self.run_script("start", "--listen", f"127.0.0.1:{self.port}", "--workers", "1", *words, **more)

    def pid(self):
        return int((self.var / "server.pid").read_text())

    def healthy(self):
        return curl(f"http://127.0.0.1:{self.port}/healthz").status == 200

    def test_starts_runs_the_sample_restarts_what_changed_and_stops(self):
        first = self.start()
        self.assertEqual(first.returncode, 0, first.stderr)
        self.assertIn(f"Vacuform is running at http://127.0.0.1:{self.port} with 1 worker(s).", first.stdout)
        self.assertIn(f"The sample's artifacts are in {self.var / 'sample'}", first.stdout)
        report = json.loads((self.var / "sample" / "report.json").read_text())
        self.assertEqual(report["scan"]["size_mm"], [152.0, 195.0, 183.0])
        self.assertEqual((self.var / "sample" / "print.png").read_bytes()[:4], b"\x89PNG")
        self.assertEqual(self.var.stat().st_mode & 0o777, 0o700)
        self.assertIn(f"Programs use the token in {self.var / 'token'}", first.stdout)
        self.assert_link_signs_in_once(first.stdout)
        self.assertEqual((self.var / "token").stat().st_mode & 0o777, 0o600)
        token = (self.var / "token").read_text()
        self.assertTrue(self.healthy())
        metrics = curl(f"http://127.0.0.1:{self.port + 1}/metrics").body.decode()
        self.assertIn('\nvacuform_jobs{state="succeeded"} 1\n', metrics)
        pid = self.pid()
        if os.geteuid() == 0:
            self.assert_workers_are_strangers(pid)
        listed = curl(f"http://127.0.0.1:{self.port}/api/v1/profiles", "-H", f"Authorization: Bearer {token.strip()}")
        self.assertIn("formech-300xq", [profile["name"] for profile in json.loads(listed.body)["profiles"]])

        second = self.start()
        self.assertEqual(second.returncode, 0, second.stderr)
        self.assertIn(f"Vacuform is already running at http://127.0.0.1:{self.port} (process {pid}).", second.stdout)
        self.assertNotIn("Running the bundled sample", second.stdout)
        self.assert_link_signs_in_once(second.stdout)
        self.assertEqual(self.pid(), pid)

        mask = self.start("--sample", "mask")
        self.assertEqual(mask.returncode, 0, mask.stderr)
        self.assertIn(f"The sample's artifacts are in {self.var / 'sample-mask'}", mask.stdout)
        report = json.loads((self.var / "sample-mask" / "report.json").read_text())
        self.assertGreater(report["pattern"]["colours"]["full_mm2"], 30000)

        other = self.run_script("start", "--listen", f"127.0.0.1:{free_port(2)}")
        self.assertIn(f"already running at http://127.0.0.1:{self.port}", other.stdout)
        self.assertIn("run deploy/stop first", other.stdout)

        rebuilt = self.bin / "rebuilt"  # as a linker does it: a new file under the old name
        rebuilt.write_bytes((self.bin / "vacuform-worker").read_bytes() + b"\0")
        rebuilt.chmod(0o755)
        rebuilt.rename(self.bin / "vacuform-worker")
        third = self.start()
        self.assertEqual(third.returncode, 0, third.stderr)
        self.assertIn("The programs have changed since Vacuform was started; restarting it.", third.stdout)
        self.assertNotEqual(self.pid(), pid)
        self.assertEqual((self.var / "token").read_text(), token)
        self.assertTrue(self.healthy())
        pid = self.pid()

        stopped = self.run_script("stop")
        self.assertEqual(stopped.returncode, 0, stopped.stderr)
        self.assertIn("Vacuform has stopped.", stopped.stdout)
        self.assertFalse(runs(pid))
        self.assertEqual(self.run_script("stop").stdout, "Vacuform is not running.\n")

    def assert_link_signs_in_once(self, said):
        (link,) = re.findall(rf"^  (http://127\.0\.0\.1:{self.port}/sign-in\?link=[0-9a-f]{{64}})$", said, re.MULTILINE)
        opened = curl(link)
        self.assertEqual((opened.status, opened.headers["location"]), (303, "/"))
        cookie = opened.headers["set-cookie"].partition(";")[0]
        session = curl(f"http://127.0.0.1:{self.port}/api/v1/session", "-H", f"Cookie: {cookie}")
        self.assertEqual(json.loads(session.body)["owner"], "local")
        self.assertEqual(curl(link).status, 401)

    def test_says_so_where_there_is_no_link(self):
        self.assertEqual(self.start().returncode, 0)
        token = (self.var / "token").read_text()
        done = subprocess.run([self.bin / "vacuform-server", "token", "revoke", "--data", self.var / "store", token.split("_")[1]])
        self.assertEqual(done.returncode, 0)
        again = self.start()
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertIn("the token was revoked or has expired", again.stderr)
        self.assertIn(f"open http://127.0.0.1:{self.port} in a browser and sign in with a token", again.stdout)

    def assert_workers_are_strangers(self, server):
        """Started by root, the workers have a user of their own, who can read nothing of the service."""
        (worker,) = children(server)
        user = pwd.getpwnam("vacuform-worker")
        status = pathlib.Path(f"/proc/{worker}/status").read_text()
        self.assertRegex(status, rf"\nUid:(\t{user.pw_uid}){{4}}\nGid:(\t{user.pw_gid}){{4}}\n")
        self.assertRegex(status, r"\nGroups:\s*\n")
        self.assertEqual((self.var / "store" / "workers").stat().st_uid, user.pw_uid)
        for secret in self.var / "store" / "admin-token", self.var / "store" / "worker-token", self.var / "token", self.var / "server.log":
            done = subprocess.run(["setpriv", f"--reuid={user.pw_uid}", f"--regid={user.pw_gid}", "--clear-groups", "cat", secret], capture_output=True)
            self.assertNotEqual(done.returncode, 0, secret)

    def test_names_a_port_that_another_program_has(self):
        with socket.create_server(("127.0.0.1", self.port)):
            refused = self.start()
        self.assertEqual(refused.returncode, 1)
        self.assertIn(f"127.0.0.1:{self.port} is taken by another program", refused.stderr)
        self.assertFalse((self.var / "server.pid").exists())

    def test_shows_why_the_server_did_not_come_up(self):
        refused = self.run_script("start", "--listen", f"0.0.0.0:{self.port}")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("refusing to listen on 0.0.0.0 without a TLS front", refused.stderr)
        self.assertIn("the server did not come up", refused.stderr)

    def test_foreground_becomes_the_server_in_the_folder_asked_for(self):
        data = self.checkout / "elsewhere"
        environment = dict(os.environ, VACUFORM_DATA=str(data), PATH=f"{self.checkout / 'path'}:{os.environ['PATH']}")
        with subprocess.Popen([self.checkout / "deploy" / "start", "--foreground", f"--listen=127.0.0.1:{self.port}"],
                              env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as supervised:
            def answers():
                try:
                    return self.healthy()
                except ConnectionError:
                    return False
            wait_for(answers, "the server in the foreground")
            self.assertEqual(int((data / "server.pid").read_text()), supervised.pid)
            self.assertTrue((data / "store").is_dir())
            supervised.send_signal(signal.SIGTERM)
            self.assertEqual(supervised.wait(timeout=PATIENCE), 0)

    def test_a_process_id_of_another_program_is_not_the_server(self):
        self.var.mkdir()
        with subprocess.Popen(["sleep", "600"]) as bystander:
            (self.var / "server.pid").write_text(f"{bystander.pid}\n")
            self.assertEqual(self.run_script("stop").stdout, "Vacuform is not running.\n")
            self.assertTrue(runs(bystander.pid))
            bystander.kill()

    def test_options_that_make_no_sense(self):
        for words, complaint in ((["--listen"], "lacks its value"), (["--listen", "8080"], "HOST:PORT"),
                                 (["--workers", "0"], "from 1 to 99"), (["--colour"], "unknown option --colour")):
            refused = self.run_script("start", *words)
            self.assertEqual(refused.returncode, 2, words)
            self.assertIn(complaint, refused.stderr)
        refused = subprocess.run([DEPLOY / "packages", "--all"], capture_output=True, text=True)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("unknown option --all", refused.stderr)


if __name__ == "__main__":
    unittest.main()
