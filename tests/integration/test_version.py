"""The commit that --version prints: where it comes from, and that the programs agree."""
import pathlib
import subprocess
import tempfile
import unittest

from harness import BIN

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "cmake/commit.cmake"


class Tree(unittest.TestCase):
    """cmake/commit.cmake in trees that the tests make."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="vacuform-version-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.tree = self.make(self.folder / "tree")
        self.git("init", "-q")
        self.git("add", "-A")
        self.git("commit", "-q", "-m", "First")

    def make(self, tree):
        (tree / "cmake").mkdir(parents=True)
        (tree / "cmake/commit.txt").write_bytes((ROOT / "cmake/commit.txt").read_bytes())
        (tree / ".gitattributes").write_bytes((ROOT / ".gitattributes").read_bytes())
        return tree

    def git(self, *words):
        done = subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@example.org", *words], cwd=self.tree,
                              capture_output=True, check=True)
        return done.stdout

    def head(self):
        return self.git("rev-parse", "--short=12", "HEAD").decode().strip()

    def commit(self, tree):
        (self.folder / "in").write_text("@COMMIT@")
        subprocess.run(["cmake", f"-DTREE={tree}", f"-DINPUT={self.folder / 'in'}", f"-DOUTPUT={self.folder / 'out'}", "-P", SCRIPT],
                       check=True, cwd=self.folder)
        return (self.folder / "out").read_text().strip()

    def test_of_a_checkout(self):
        self.assertEqual(self.commit(self.tree), self.head())

    def test_a_changed_file_counts_and_a_new_one_does_not(self):
        (self.tree / "notes").write_text("mine")
        self.assertEqual(self.commit(self.tree), self.head())
        (self.tree / ".gitattributes").write_text("")
        self.assertEqual(self.commit(self.tree), self.head() + ", modified")

    def test_of_a_worktree_of_git(self):
        self.git("worktree", "add", "-q", self.folder / "beside")
        self.assertEqual(self.commit(self.folder / "beside"), self.head())

    def test_of_an_archive(self):
        export = self.folder / "export"
        export.mkdir()
        subprocess.run(["tar", "-x"], input=self.git("archive", "HEAD"), cwd=export, check=True)
        self.assertEqual(self.commit(export), self.head())

    def test_of_a_copy_inside_another_repository(self):
        self.assertEqual(self.commit(self.make(self.tree / "copy")), "unknown")

    def test_without_git_and_without_a_file(self):
        (self.folder / "bare").mkdir()
        self.assertEqual(self.commit(self.folder / "bare"), "unknown")

    def test_of_a_repository_without_commits(self):
        subprocess.run(["git", "init", "-q"], cwd=self.make(self.folder / "new"), check=True)
        self.assertEqual(self.commit(self.folder / "new"), "unknown")

    def test_the_same_commit_leaves_the_file_untouched(self):
        self.commit(self.tree)
        before = (self.folder / "out").stat().st_mtime_ns
        self.commit(self.tree)
        self.assertEqual((self.folder / "out").stat().st_mtime_ns, before)


class Programs(unittest.TestCase):
    def test_agree(self):
        said = [subprocess.run([BIN / name, "--version"], capture_output=True, text=True, check=True).stdout.removeprefix(name)
                for name in ("vacuform", "vacuform-server", "vacuform-worker")]
        self.assertEqual(said, said[:1] * 3)


if __name__ == "__main__":
    unittest.main()
