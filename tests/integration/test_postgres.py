"""The service with its jobs in PostgreSQL: from a scan to its findings, a killed database, commands, and refusals."""
import json
import pathlib
import signal
import subprocess
import unittest

import made_scans
from harness import BIN, Case, Server, curl, wait_for
from postgres import Postgres


class InPostgres(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.postgres = cls.enterClass(Postgres())
        cls.server = cls.enterClass(Server(cls.folder, workers=1, options=["--store", cls.postgres.url]))

    def command(self, *words):
        return subprocess.run([BIN / "vacuform-server", *map(str, words)], capture_output=True, text=True)

    def inspection(self, key):
        return curl("-H", f"Idempotency-Key: {key}", "-F", f"scan=@{made_scans.newborn()}", "-F", "kind=inspection",
                    self.server.api + "/jobs")

    def ready(self):
        return curl(f"http://127.0.0.1:{self.status_port}/readyz")

    @property
    def status_port(self):
        for line in self.server.program.says().splitlines():
            if '"event":"server-started"' in line:
                port = json.loads(line)["status_url"].rpartition(":")[2]
        return port

    def test_a_job_runs_and_survives_a_killed_database_and_server(self):
        self.assertEqual(self.ready().json, {"status": "ready", "durability": "local"})
        metrics = curl(f"http://127.0.0.1:{self.status_port}/metrics").body.decode()
        self.assertRegex(metrics, r"(?m)^vacuform_database_oldest_transaction_seconds [0-9]")
        first = self.inspection("the-first-job")
        self.assertEqual(first.status, 202, first)
        self.assertEqual(self.server.wait(first.json["id"])["state"], "succeeded")
        self.assertEqual(self.postgres.answer("SELECT state FROM job"), "succeeded")
        self.assertFalse((self.server.data / "jobs.sqlite").exists())

        self.postgres.end(signal.SIGKILL)
        self.assertEqual(self.ready().status, 503)
        refused = self.inspection("the-second-job")
        self.assertEqual(refused.status, 503, refused)
        self.server.stop(signal.SIGKILL)
        self.postgres.start()
        self.server.start()
        self.assertEqual(self.ready().status, 200)
        self.assertEqual(self.inspection("the-first-job").json["id"], first.json["id"])
        second = self.inspection("the-second-job")
        self.assertEqual(self.server.wait(second.json["id"])["state"], "succeeded")
        self.assertEqual(len(self.server.jobs()), 2)

    def test_commands_reach_the_same_jobs(self):
        made = self.command("--store", self.postgres.url, "token", "create", "--data", self.server.data, "--owner", "station-7",
                            "--scopes", "read")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertEqual(self.postgres.answer("SELECT count(*) FROM token WHERE owner='station-7'"), "1")
        copy = self.folder / "copy"
        saved = self.command("--store", self.postgres.url, "backup", "--data", self.server.data, "--to", copy)
        self.assertEqual(saved.returncode, 0, saved.stderr)
        listed = self.command("token", "list", "--data", copy)  # a store of SQLite
        self.assertIn("owner station-7", listed.stdout, listed.stderr)

    def test_servers_on_one_database_share_sessions(self):
        self.postgres.answer("CREATE SCHEMA sessions")
        servers = []
        for name in ("one", "two"):
            folder = self.folder / name
            folder.mkdir()
            servers.append(Server(folder, workers=0, options=["--store", self.postgres.url + "&options=-csearch_path%3Dsessions"]))
            self.addCleanup(servers[-1].start().stop)
        one, two = servers
        browser = two.sign_in()

        def seen():
            return [curl(*browser, server.api + "/session").status for server in servers]

        self.assertEqual(seen(), [200, 200])
        self.postgres.end(signal.SIGKILL)
        refused = one.sign_out(browser)
        self.assertEqual(refused.status, 503, refused)
        self.assertNotIn("set-cookie", refused.headers)
        self.assertEqual(seen(), [503, 503])
        self.postgres.start()
        self.assertEqual(seen(), [200, 200])
        self.assertEqual(one.sign_out(browser).status, 303)
        self.assertEqual(seen(), [401, 401])

    def test_a_password_in_the_address_is_refused_and_not_shown(self):
        for words in (["--check-config"], []):
            done = self.command("--data", self.folder / "other", "--store", "postgresql://vacuform:open-sesame@/vacuform", *words)
            self.assertEqual(done.returncode, 2)
            self.assertIn("contains a password", done.stderr)
            self.assertNotIn("open-sesame", done.stdout + done.stderr)
        self.assertFalse((self.folder / "other").exists())

    def test_a_data_folder_of_postgresql_does_not_open_without_it(self):
        wait_for(lambda: (self.server.data / "database-id").exists(), "the mark of the data folder")
        other = pathlib.Path(self.folder / "without")
        other.mkdir()
        (other / "database-id").write_text((self.server.data / "database-id").read_text())
        done = self.command("--data", other, "--listen", "127.0.0.1:0")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("the jobs of this data folder are in PostgreSQL", done.stderr)


if __name__ == "__main__":
    unittest.main()
