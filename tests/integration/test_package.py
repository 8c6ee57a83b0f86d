"""The Debian package that cpack makes of the programs that were built. tests/check/package also installs it."""
import gzip
import pathlib
import re
import subprocess
import tempfile
import unittest

from harness import BIN

BUILD = BIN.resolve().parent
SCRIPTS = ("postinst", "postrm", "prerm")


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(prefix="vacuform-package-")
        cls.addClassCleanup(holder.cleanup)
        folder = pathlib.Path(holder.name)
        done = subprocess.run(["cpack", "-G", "DEB", "--config", BUILD / "CPackConfig.cmake", "-B", folder], capture_output=True, text=True)
        if done.returncode != 0:
            raise AssertionError(done.stdout + done.stderr)
        (cls.deb,) = folder.glob("*.deb")
        cls.root, cls.control = folder / "root", folder / "control"
        subprocess.run(["dpkg-deb", "-x", cls.deb, cls.root], check=True)
        subprocess.run(["dpkg-deb", "-e", cls.deb, cls.control], check=True)

    def field(self, name):
        return subprocess.run(["dpkg-deb", "-f", self.deb, name], capture_output=True, text=True, check=True).stdout.strip()

    def test_name_and_version(self):
        version = subprocess.run([BIN / "vacuform", "--version"], capture_output=True, text=True, check=True).stdout.split()[1]
        self.assertRegex(self.field("Version"), rf"\A{re.escape(version)}(\+deb\d+)?\Z")
        self.assertEqual(self.deb.name, f"vacuform_{self.field('Version')}_{self.field('Architecture')}.deb")

    def test_depends_on_the_libraries_and_on_what_its_scripts_run(self):
        depends = re.findall(r"(?:^|, )([a-z0-9.+-]+)", self.field("Depends"))
        for prefix in "libembree", "libcholmod", "libsqlite3-0", "libsodium", "curl", "passwd", "ca-certificates":
            self.assertTrue(any(name.startswith(prefix) for name in depends), f"{prefix}: {depends}")

    def test_files_belong_to_root_and_only_programs_are_executable(self):
        listed = subprocess.run(["dpkg-deb", "-c", self.deb], capture_output=True, text=True, check=True).stdout.splitlines()
        self.assertGreater(len(listed), 40)
        executable = set()
        for line in listed:
            modes, owner, _, _, _, path = line.split(maxsplit=5)
            self.assertEqual(owner, "root/root", line)
            if not modes.startswith("l"):
                self.assertIn(modes, ("drwxr-xr-x", "-rwxr-xr-x", "-rw-r--r--"), line)
            if modes == "-rwxr-xr-x":
                executable.add(path)
            self.assertRegex(path, r"\A\./(etc|usr)/\Z|\A\./etc/vacuform/|\A\./usr/(bin|sbin|lib|share)/")
        self.assertEqual(executable, {"./usr/bin/vacuform", "./usr/bin/vacuform-server", "./usr/bin/vacuform-worker",
                                      "./usr/lib/vacuform/setup", "./usr/lib/vacuform/front"})

    def test_units_run_the_programs_of_the_package(self):
        units = self.root / "usr/lib/systemd/system"
        self.assertEqual(sorted(p.name for p in units.iterdir()), ["vacuform-server.service", "vacuform-worker@.service"])
        for unit in units.iterdir():
            text = unit.read_text()
            program = re.search(r"^ExecStart=(\S+)", text, re.M)[1]
            self.assertTrue((self.root / program[1:]).exists(), program)
            self.assertNotRegex(text, "@[A-Z]+@")

    def test_the_programs_accept_the_settings_which_an_upgrade_keeps(self):
        self.assertEqual((self.control / "conffiles").read_text().split(), ["/etc/vacuform/server.json", "/etc/vacuform/worker.json"])
        for program in "server", "worker":
            checked = subprocess.run([BIN / f"vacuform-{program}", "--check-config", "--config", self.root / f"etc/vacuform/{program}.json"],
                                     env={"VACUFORM_TOKEN": "vft_0123456789abcdef_" + "0" * 64}, capture_output=True, text=True)
            self.assertEqual(checked.returncode, 0, checked.stderr)
            self.assertIn('"127.0.0.1:8080"' if program == "server" else '"http://127.0.0.1:8080"', checked.stdout)

    def test_every_command_has_a_manual_page(self):
        commands = {p.name for folder in ("bin", "sbin") for p in (self.root / "usr" / folder).iterdir()}
        pages = {p.name.partition(".")[0]: p for p in (self.root / "usr/share/man").glob("man*/*.gz")}
        self.assertEqual(set(pages), commands)
        self.assertEqual(pages["vacuform"].parent.name, "man1")
        for name, page in pages.items():
            text = gzip.decompress(page.read_bytes()).decode()
            self.assertIn(".SH NAME\n" + name.replace("-", r"\-") + r" \- ", text)
        self.assertIn(".SS vacuform run\n", gzip.decompress(pages["vacuform"].read_bytes()).decode())

    def test_scripts_parse_and_commands_lead_to_their_scripts(self):
        for name in SCRIPTS:
            self.assertEqual(subprocess.run(["sh", "-n", self.control / name]).returncode, 0, name)
        for name in "setup", "front":
            self.assertTrue((self.root / "usr/sbin" / f"vacuform-{name}").resolve().samefile(self.root / "usr/lib/vacuform" / name))
            said = subprocess.run([self.root / "usr/sbin" / f"vacuform-{name}", "--help"], capture_output=True, text=True)
            self.assertEqual((said.returncode, said.stderr), (0, ""))

    def test_has_profiles_licence_and_changes(self):
        for path in ("share/vacuform/profiles/sheet-a4.json", "share/doc/vacuform/copyright", "share/doc/vacuform/CHANGELOG.md",
                     "share/doc/vacuform/changelog.gz", "share/doc/vacuform/docs/operate/install.md"):
            self.assertTrue((self.root / "usr" / path).exists(), path)


if __name__ == "__main__":
    unittest.main()
