"""docs/operate/promises.md: every promise names a test, and every test that it names is one that ctest runs."""
import os
import pathlib
import re
import subprocess
import unittest

HERE = pathlib.Path(__file__).resolve().parent
PROMISES = (HERE.parents[1] / "docs" / "operate" / "promises.md").read_text()


class Promises(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        build = pathlib.Path(os.environ["VACUFORM_BIN"]).parent
        listed = subprocess.run(["ctest", "-N", "--test-dir", build], capture_output=True, text=True, check=True).stdout
        cls.known = set(re.findall(r"Test +#\d+: (\S+)", listed))
        for program in [name for name in cls.known if "." not in name and (build / "bin" / name).exists()]:
            cls.known.update(cls.listed_by(build / "bin" / program))  # of a program that ctest runs as one test

    @staticmethod
    def listed_by(program):
        suite = ""
        for line in subprocess.run([program, "--gtest_list_tests"], capture_output=True, text=True, check=True).stdout.splitlines():
            if not line.startswith(" "):
                suite = line.split()[0]
            else:
                yield f"{program.name}.{suite}{line.split()[0]}"

    def exists(self, name):
        file, colons, method = name.partition("::")
        if colons:
            return (f"integration.{file.removeprefix('test_')}" in self.known and
                    re.search(rf"^    def {method}\(self", (HERE / f"{file}.py").read_text(), re.M) is not None)
        # "server_test.Each/StoreTest.OneKeyMakesOneJob/SQLite": the program before it, a parameter around it.
        return any(re.search(rf"(^|[./]){re.escape(name)}(/|$)", known) for known in self.known)

    def test_every_promise_names_tests_that_exist(self):
        promises = re.findall(r"^- (.*)$", PROMISES, re.M)
        self.assertGreater(len(promises), 30)
        for promise in promises:
            with self.subTest(promise[:70]):
                sentence, bracket, names = promise.rpartition(" [")
                self.assertTrue(bracket and sentence.endswith("."), "a sentence, then its tests in brackets")
                tests = re.findall(r"`([^`]+)`", names)
                self.assertTrue(tests)
                for test in tests:
                    self.assertTrue(self.exists(test), f"there is no test {test}")

    def test_a_test_that_does_not_exist_is_noticed(self):
        for name in ("StoreTest.KeepsAJobWithItsFile", "test_chaos::test_nothing", "fuzz.doc"):
            self.assertFalse(self.exists(name), name)


if __name__ == "__main__":
    unittest.main()
