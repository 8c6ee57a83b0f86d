"""Sources of the programs' settings: a file, the environment, the command line; each overrides the one before.

Both programs share the mechanism and its tests; settings that only one of them has are tested after that.
"""
import json
import os
import subprocess
import unittest

from harness import BIN, VERSION, Case, Program, wait_for


class Configuration:
    """Tests that apply to each program. A subclass names the program and the settings that --check-config needs."""
    program = None       # "server"
    needed = {}          # settings without which it does not start
    number, largest = None, None   # a setting that is a whole number, and its maximum
    text = None          # a setting that accepts any text
    first_names = None   # the beginning of the list of all settings

    def variable(self, name):
        return f"VACUFORM_{self.program.upper()}_{name.upper()}"

    def ask(self, *words, file=None, **environment):
        """The output of --check-config for these sources."""
        variables = {k: v for k, v in os.environ.items() if not k.startswith("VACUFORM_")}
        path = self.folder / f"{self.program}.json"
        content = {} if file is None else file
        path.write_text(content if isinstance(content, str) else json.dumps({**self.needed, **content}))
        variables[self.variable("config")] = str(path)
        return subprocess.run([BIN / f"vacuform-{self.program}", "--check-config", *map(str, words)], capture_output=True,
                              text=True, env=variables | environment)

    def settings(self, *words, **more):
        done = self.ask(*words, **more)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def refused(self, *words, **more):
        done = self.ask(*words, **more)
        self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
        self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
        self.assertTrue(done.stderr.startswith(f"vacuform-{self.program}: "), done.stderr)
        return done.stderr

    def option(self, name):
        return "--" + name.replace("_", "-")

    def test_the_environment_beats_the_file_and_the_command_line_beats_both(self):
        def taken(*words, **more):
            found = self.settings(*words, **more)
            return found[self.number], found[self.text]
        file = {self.number: 10, self.text: "file"}
        self.assertEqual(taken(file=file), (10, "file"))
        environment = {self.variable(self.number): "11", self.variable(self.text): "environment"}
        self.assertEqual(taken(file=file, **environment), (11, "environment"))
        self.assertEqual(taken(self.option(self.number), 12, file=file, **environment), (12, "environment"))
        self.assertEqual(taken(self.option(self.text) + "=words", file=file, **environment), (11, "words"))

    def test_what_it_prints_is_a_file_of_its_own(self):
        settings = self.settings(self.option(self.number), 12, self.option(self.text), "words")
        self.assertEqual(self.settings(file=settings), settings)

    def test_an_empty_text_says_nothing(self):
        environment = {self.variable(self.number): "", self.variable(self.text): ""}
        self.assertEqual(self.settings(file={self.number: ""}, **environment)[self.number], self.settings()[self.number])
        self.assertEqual(self.settings(file={self.text: "file"}, **environment)[self.text], "file")

    def test_the_command_line_names_another_file_than_the_environment(self):
        path = self.folder / "other.json"
        path.write_text(json.dumps({**self.needed, self.number: 12}))
        for words in (["--config", path], [f"--config={path}"]):
            self.assertEqual(self.settings(*words, file={self.number: 10})[self.number], 12)
        self.assertRegex(self.refused("--config", self.folder / "absent.json"), r"cannot be read.*absent\.json")

    def test_unknown_names_are_refused_and_the_known_ones_listed(self):
        for refusal, source in ((self.refused(file={"colour": 1}), f"{self.program}.json"),
                                (self.refused(**{self.variable("colour"): "1"}), self.variable("colour"))):
            self.assertIn("there is no such setting: colour", refusal)
            self.assertIn(source, refusal)
            self.assertIn("known are " + self.first_names, refusal)
        self.assertIn("--colour=1", self.refused("--colour=1"))
        self.assertIn("there is no such setting: config", self.refused(file={"config": "other.json"}))

    def test_bad_values_are_refused_with_their_source(self):
        option = self.option(self.number)
        self.assertRegex(self.refused(file={self.number: self.largest + 1}), rf"{option}.*{self.largest + 1}.*{self.program}\.json")
        self.assertRegex(self.refused(file={self.number: 1.5}), rf"{option}.*1\.5.*{self.program}\.json")
        self.assertRegex(self.refused(file={self.number: [1]}), rf"neither a text, .*: {self.number}.*{self.program}\.json")
        self.assertRegex(self.refused(file="{"), rf"not valid JSON.*{self.program}\.json")
        variable = self.variable(self.number)
        self.assertRegex(self.refused(**{variable: "0"}), rf"{option}.*{variable}")
        self.assertIn(option, self.refused(option, 0))

    def test_nothing_is_made_by_looking(self):
        self.settings(self.option(self.made), self.folder / "made")
        self.assertFalse((self.folder / "made").exists())

    def test_help_and_version_are_no_errors(self):
        self.assertIn(f"/etc/vacuform/{self.program}.json", self.ask("--help").stdout)
        self.assertRegex(self.ask("--version").stdout, VERSION.format(f"vacuform-{self.program}"))


class ServerConfiguration(Configuration, Case):
    program, number, largest, text, made = "server", "lease_seconds", 3600, "port_file", "data"
    first_names = "listen, status_listen, front, data, store, blobs, blobs_credentials, workers, lease_seconds"

    def test_defaults(self):
        settings = self.settings()
        self.assertEqual((settings["listen"], settings["workers"], settings["lease_seconds"], settings["front"]),
                         ("127.0.0.1:8080", 0, 30, ""))
        self.assertEqual(settings["worker_program"], str(BIN.resolve() / "vacuform-worker"))

    def test_what_cannot_be_begun(self):
        self.assertIn("refusing to listen on 0.0.0.0", self.refused(file={"listen": "0.0.0.0:80"}))
        self.assertEqual(self.settings("--front", "https://vacuform.example.org", "--listen", "0.0.0.0:80")["listen"], "0.0.0.0:80")
        self.assertIn("no worker program", self.refused("--workers", 1, "--worker-program", "/none"))

    def test_the_commands_find_the_jobs_where_the_settings_say(self):
        """`token` and `backup` without --data use the store of the configured service."""
        data = self.folder / "configured"
        (self.folder / "server.json").write_text(json.dumps({"data": str(data)}))
        def command(*words):
            done = subprocess.run([BIN / "vacuform-server", "--config", self.folder / "server.json", *words], capture_output=True,
                                  text=True, cwd=self.folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            return done.stdout
        self.assertRegex(command("token", "create", "--owner", "station-3", "--scopes", "read"), r"\Avft_\S+\n\Z")
        self.assertTrue((data / "jobs.sqlite").exists())
        self.assertIn("owner station-3", command("token", "list"))
        self.assertEqual(json.loads(command("backup", "--to", self.folder / "copy"))["damaged"], [])
        self.assertIn("owner station-3", command("token", "list", "--data", self.folder / "copy"))
        for words in ["token", "list"], ["token", "create", "--owner", "a", "--scopes", "read"], ["backup", "--to", self.folder / "b"]:
            done = subprocess.run([BIN / "vacuform-server", *words, "--data", self.folder / "mistyped"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 2)
            self.assertIn("there is no job store in this folder", done.stderr)
            self.assertFalse((self.folder / "mistyped").exists())


    def test_its_own_workers_do_not_hear_from_the_file_of_others(self):
        """/etc/vacuform/worker.json names the folders of another user on machines where workers run as services."""
        worker = self.folder / "worker"
        worker.write_text('#!/bin/sh\necho "${VACUFORM_WORKER_CONFIG-/etc/vacuform/worker.json}" > "$0.said"\nexec sleep 600\n')
        worker.chmod(0o755)
        said = self.folder / "worker.said"
        server = Program([BIN / "vacuform-server", "--listen", "127.0.0.1:0", "--data", self.folder / "data", "--workers", 1,
                          "--worker-program", worker], self.folder / "log")
        self.addCleanup(server.end)
        wait_for(lambda: said.exists() and said.read_text(), "the worker")
        self.assertEqual(said.read_text(), "\n")


class WorkerConfiguration(Configuration, Case):
    program, number, largest, text, made = "worker", "cache_days", 3650, "name", "work"
    first_names = "server, token_file, name, work, poll_seconds, drain, max_jobs"

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        token = cls.folder / "worker.token"
        token.write_text("vft_0123456789abcdef_" + "0" * 64 + "\n")
        cls.needed = {"server": "http://127.0.0.1:1", "token_file": str(token)}

    def test_defaults(self):
        settings = self.settings(file={})
        self.assertEqual((settings["poll_seconds"], settings["cache"], settings["cache_days"], settings["no_cache"], settings["sandbox"]),
                         (1.0, "", 7, False, "required"))

    def test_yes_and_no(self):
        self.assertIs(self.settings(file={"no_cache": True})["no_cache"], True)
        self.assertIs(self.settings("--no-cache")["no_cache"], True)
        self.assertIs(self.settings(file={"no_cache": True}, VACUFORM_WORKER_NO_CACHE="0")["no_cache"], False)
        self.assertIs(self.settings("--no-cache=false", VACUFORM_WORKER_NO_CACHE="1")["no_cache"], False)
        self.assertRegex(self.refused(file={"no_cache": "perhaps"}), r"perhaps.*worker\.json")

    def test_parts_of_a_second(self):
        self.assertEqual(self.settings(file={"poll_seconds": 0.25})["poll_seconds"], 0.25)
        self.assertIn("--poll-seconds", self.refused(file={"poll_seconds": 0.01}))

    def test_what_cannot_be_begun(self):
        self.assertIn("there is no server", self.refused(file="{}"))
        self.assertIn("ftp://", self.refused("--server", "ftp://127.0.0.1"))
        self.assertIn("none.token", self.refused(VACUFORM_WORKER_TOKEN_FILE="none.token"))
        self.assertIn("there is no token", self.refused(file='{"server": "http://127.0.0.1:1"}'))

    def test_the_token_is_not_printed(self):
        self.assertNotIn("vft_", self.ask().stdout)


if __name__ == "__main__":
    unittest.main()
