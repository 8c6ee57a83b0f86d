"""Where vacuform-server takes its settings from: a file, the environment, the command line, each stronger than the one before."""
import json
import os
import subprocess
import unittest

from harness import BIN, Case


class Configuration(Case):
    def ask(self, *words, file=None, **environment):
        """What --check-config says of this."""
        variables = {k: v for k, v in os.environ.items() if not k.startswith("VACUFORM_SERVER_")}
        variables["VACUFORM_SERVER_CONFIG"] = str(self.folder / "none.json")
        (self.folder / "none.json").write_text("{}")
        if file is not None:
            path = self.folder / "server.json"
            path.write_text(file if isinstance(file, str) else json.dumps(file))
            words = ["--config", path, *words]
        return subprocess.run([BIN / "vacuform-server", "--check-config", *map(str, words)], capture_output=True, text=True,
                              env=variables | environment)

    def settings(self, *words, **more):
        done = self.ask(*words, **more)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def refused(self, *words, **more):
        done = self.ask(*words, **more)
        self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
        self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
        return done.stderr

    def test_defaults(self):
        settings = self.settings()
        self.assertEqual((settings["listen"], settings["workers"], settings["lease_seconds"], settings["front"]),
                         ("127.0.0.1:8080", 0, 30, ""))
        self.assertEqual(settings["worker_program"], str(BIN.resolve() / "vacuform-worker"))

    def test_the_environment_beats_the_file_and_the_command_line_beats_both(self):
        file = {"workers": 1, "lease_seconds": 10, "listen": "127.0.0.1:9001"}
        settings = self.settings(file=file)
        self.assertEqual((settings["workers"], settings["lease_seconds"], settings["listen"]), (1, 10, "127.0.0.1:9001"))
        environment = {"VACUFORM_SERVER_LEASE_SECONDS": "11", "VACUFORM_SERVER_LISTEN": "127.0.0.1:9002"}
        settings = self.settings(file=file, **environment)
        self.assertEqual((settings["workers"], settings["lease_seconds"], settings["listen"]), (1, 11, "127.0.0.1:9002"))
        settings = self.settings("--listen=127.0.0.1:9003", file=file, **environment)
        self.assertEqual((settings["workers"], settings["lease_seconds"], settings["listen"]), (1, 11, "127.0.0.1:9003"))

    def test_what_it_prints_is_a_file_of_its_own(self):
        settings = self.settings("--workers", 2, "--front", "https://vacuform.example.org", "--listen", "0.0.0.0:8080")
        self.assertEqual(self.settings(file=settings), settings)

    def test_the_environment_names_the_file(self):
        path = self.folder / "other.json"
        path.write_text('{"lease_seconds": 12}')
        self.assertEqual(self.settings(VACUFORM_SERVER_CONFIG=str(path))["lease_seconds"], 12)
        self.assertIn("cannot be read", self.refused("--config", self.folder / "absent.json"))

    def test_unknown_names_are_refused_and_the_known_ones_listed(self):
        for refusal in (self.refused(file={"worker": 1}), self.refused(VACUFORM_SERVER_WORKER="1")):
            self.assertIn("there is no such setting: worker", refusal)
            self.assertIn("listen, status_listen, front, data, workers, lease_seconds", refusal)
        self.assertIn("--worker=1", self.refused("--worker=1"))

    def test_bad_values_are_refused_with_their_source(self):
        self.assertRegex(self.refused(file={"workers": 1000}), r"workers.*1000.*server\.json")
        self.assertRegex(self.refused(file={"workers": [1]}), r"neither a text nor a whole number: workers.*server\.json")
        self.assertRegex(self.refused(file="{"), r"not a JSON object.*server\.json")
        self.assertRegex(self.refused(VACUFORM_SERVER_LEASE_SECONDS="1"), r"VACUFORM_SERVER_LEASE_SECONDS")
        self.assertIn("--lease-seconds", self.refused("--lease-seconds", 1))
        self.assertIn("refusing to listen on 0.0.0.0", self.refused(file={"listen": "0.0.0.0:80"}))
        self.assertIn("no worker program", self.refused("--workers", 1, "--worker-program", "/none"))

    def test_nothing_is_made_by_looking(self):
        self.settings("--data", self.folder / "store")
        self.assertFalse((self.folder / "store").exists())

    def test_a_worker_takes_its_options_from_the_environment_too(self):
        def worker(*words, **environment):
            done = subprocess.run([BIN / "vacuform-worker", *words], capture_output=True, text=True, env=os.environ | environment)
            self.assertEqual(done.returncode, 2, done.stderr)
            return done.stderr
        self.assertIn("--server", worker())
        self.assertIn("--poll-seconds", worker(VACUFORM_WORKER_SERVER="http://127.0.0.1:1", VACUFORM_WORKER_POLL_SECONDS="0"))
        self.assertIn("none.token", worker("--poll-seconds", "1", VACUFORM_WORKER_SERVER="http://127.0.0.1:1",
                                           VACUFORM_WORKER_POLL_SECONDS="2", VACUFORM_WORKER_TOKEN_FILE="none.token"))


if __name__ == "__main__":
    unittest.main()
