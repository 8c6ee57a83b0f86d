"""README, CONTRIBUTING and docs/: generated pages are up to date, links lead somewhere, commands exist, and the sessions work."""
import json
import os
import pathlib
import re
import shlex
import stat
import subprocess
import tempfile
import unittest
import zipfile

import hostile
from harness import BIN, PATIENCE, Case, Server

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = ("vacuform", "vacuform-server", "vacuform-worker")
FENCE = re.compile(r"^```(\w*)[^\n]*\n(.*?)^```$", re.M | re.S)


def tracked():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    return {path for path in listed.stdout.splitlines() if (ROOT / path).exists()}


FILES = tracked()
PAGES = {path: (ROOT / path).read_text() for path in FILES if path.endswith(".md")}


def shell_blocks(page):
    """The blocks of shell commands of a page, in their order."""
    return [text for language, text in FENCE.findall(PAGES[page]) if language == "sh"]


def prose(text):
    return FENCE.sub("", text)


def anchors(text):
    """What GitHub makes of the headings."""
    found = []
    for heading in re.findall(r"^#+ (.*)$", prose(text), re.M):
        slug = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        found.append(slug if slug not in found else f"{slug}-{sum(f.rstrip('-0123456789') == slug for f in found)}")
    return found


def links(text):
    without_code = re.sub(r"`[^`\n]*`", "", prose(text))
    return re.findall(r"\]\(([^()\s]+)\)", without_code)


def broken(page, link):
    """What is wrong with a link of a page, or nothing."""
    if re.match(r"https?://|mailto:", link):
        return None
    file, _, anchor = link.partition("#")
    target = os.path.normpath(os.path.join(os.path.dirname(page), file)) if file else page
    if target not in FILES:
        return f"{target} is not in the repository"
    if anchor and anchor not in anchors(PAGES[target]):
        return f"{target} has no heading {anchor}"
    return None


class Pages(unittest.TestCase):
    def test_every_link_leads_to_a_file_and_a_heading(self):
        count = 0
        for page, text in PAGES.items():
            for link in links(text):
                count += 1
                self.assertIsNone(broken(page, link), f"{page}: ({link})")
        self.assertGreater(count, 60)

    def test_a_broken_link_is_noticed(self):
        self.assertIn("is not in the repository", broken("README.md", "docs/no-such-page.md"))
        self.assertIn("has no heading", broken("README.md", "docs/reference/warnings.md#no-such-heading"))
        self.assertIn("has no heading", broken("CONTRIBUTING.md", "#no-such-heading"))

    def test_every_page_of_docs_is_reached_from_the_readme(self):
        reached, new = {"README.md"}, ["README.md"]
        while new:
            page = new.pop()
            for link in links(PAGES[page]):
                target = os.path.normpath(os.path.join(os.path.dirname(page), link.partition("#")[0]))
                if target in PAGES and target not in reached:
                    reached.add(target)
                    new.append(target)
        self.assertEqual(sorted(p for p in PAGES if p.startswith("docs/") and p not in reached), [])

    def test_every_page_that_a_file_names_exists(self):
        for path in FILES:
            if path.endswith((".png", ".pdf")) or not (ROOT / path).is_file():
                continue
            for name in re.findall(r"\bdocs/[\w/-]+\.(?:md|png)\b", (ROOT / path).read_text(errors="replace")):
                self.assertTrue(name in FILES or name.startswith("docs/no-such"), f"{path} names {name}")

    def test_the_readme_is_short(self):
        self.assertLessEqual(len(PAGES["README.md"].splitlines()), 120)


def commands(block):
    """The commands of a block as words, without heredocs."""
    block = re.sub(r"<<'?(\w+)'?\n.*?^\1$", "", block.replace("\\\n", " "), flags=re.M | re.S)
    for line in block.splitlines():
        words = []
        for word in shlex.split(line, comments=True):
            if word in ("&&", "||", "|"):
                yield words
                words = []
            else:
                words.append(word)
        yield words


class Commands(unittest.TestCase):
    """Shell blocks of all pages: they parse, and the options of our programs and scripts exist."""

    @classmethod
    def setUpClass(cls):
        cls.helps = {}

    def help_of(self, command):
        if command not in self.helps:
            done = subprocess.run([BIN / command[0], *command[1:], "--help"], capture_output=True, text=True, check=True)
            self.helps[command] = done.stdout
        return self.helps[command]

    def wrong_options(self, words):
        """Options that the command does not have."""
        for place, word in enumerate(words):
            name = word.rpartition("/")[2]
            if place > 0 and words[place - 1] not in ("--", "--args"):
                continue
            if name in PROGRAMS and "=" not in word:
                command = (name,)
                for sub in words[place + 1:]:
                    if sub.startswith("-") or not re.search(rf"^\s+{re.escape(sub)}\s", self.help_of(command), re.M):
                        break
                    command += (sub,)
                text = self.help_of(command)
            elif re.fullmatch(r"(deploy|tests/check)/[\w-]+", word) or word == "tests/run":
                text = (ROOT / word).read_text() + (" -R " if word == "tests/run" else "")
            else:
                continue
            options = [w.partition("=")[0] for w in words[place + 1:] if re.match(r"--?[a-zA-Z]", w)]
            return [o for o in options if not re.search(rf"(^|[\s(|,\"])(\[ =)?{re.escape(o)}\b", text, re.M)]
        return []

    def test_shell_blocks_parse(self):
        count = 0
        for page in PAGES:
            for block in shell_blocks(page):
                count += 1
                done = subprocess.run(["bash", "-n"], input=block, capture_output=True, text=True)
                self.assertEqual((done.returncode, done.stderr), (0, ""), f"{page}:\n{block}")
        self.assertGreater(count, 30)

    def test_options_exist(self):
        count = 0
        for page in PAGES:
            for block in shell_blocks(page):
                for words in commands(block):
                    count += any(w.rpartition("/")[2] in PROGRAMS for w in words[:5])
                    self.assertEqual(self.wrong_options(words), [], f"{page}: {' '.join(words)}")
        self.assertGreater(count, 25)

    def test_an_option_that_does_not_exist_is_noticed(self):
        self.assertEqual(self.wrong_options("vacuform run --scan a --patern b".split()), ["--patern"])
        self.assertEqual(self.wrong_options("deploy/install --frontt x".split()), ["--frontt"])
        self.assertEqual(self.wrong_options("runuser -u vacuform -- vacuform-server token create --owners x".split()), ["--owners"])

    def test_settings_exist(self):
        settings = set(re.findall(r"^\| `([a-z]+\.[a-z_0-9]+)` \|", PAGES["docs/reference/settings.md"], re.M))
        self.assertGreater(len(settings), 60)
        groups = "|".join({s.partition(".")[0] for s in settings})
        count = 0
        for page, text in PAGES.items():
            for line in text.splitlines():
                named = re.findall(rf"--set ({groups})\.([a-z_0-9]+)=", line) + re.findall(rf"`({groups})\.([a-z_0-9]+)(?:=[^`]*)?`", line)
                for group, key in named:
                    name = f"{group}.{key}"
                    if key in ("png", "svg", "pdf", "json", "csv") or "report.json" in line:
                        continue
                    count += 1
                    self.assertIn(name, settings, f"{page}: {line}")
        self.assertGreater(count, 100)


class Architecture(unittest.TestCase):
    def test_where_to_begin_a_change_exists(self):
        table = re.search(r"## Where to begin a change\n(.*?)\n## ", PAGES["docs/develop/architecture.md"], re.S)[1]
        named = [path for row in re.findall(r"^\|.*\|$", table, re.M) for path in re.findall(r"`([^`]+)`", row)]
        self.assertGreater(len(named), 30)
        self.assertEqual([path for path in named if path not in FILES and not any(file.startswith(path) for file in FILES if path.endswith("/"))], [])


class GeneratedPages(unittest.TestCase):
    def test_are_what_the_programs_say(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([ROOT / "docs/generate", folder], check=True, timeout=PATIENCE, env={**os.environ, "VACUFORM_BIN": str(BIN)})
            pages = sorted(os.listdir(folder))
            self.assertEqual(pages, ["cli.md", "problems.md", "settings.md", "warnings.md"])
            for name in pages:
                self.assertEqual((ROOT / "docs/reference" / name).read_text(), pathlib.Path(folder, name).read_text(),
                                 f"docs/reference/{name} is out of date; run docs/generate")

    def test_every_problem_and_warning_of_the_code_is_listed(self):
        for name, source, row in (("problems", "problem", r"\d{3} \| \d+"), ("warnings", "warning_kinds", "(?:note|warning|serious)")):
            codes = re.findall(r'^    \{"([a-z-]+)", ', (ROOT / f"api/{source}.cpp").read_text(), re.M)
            self.assertGreater(len(codes), 20)
            self.assertEqual(re.findall(rf"^\| `([a-z-]+)` \| {row} \|", PAGES[f"docs/reference/{name}.md"], re.M), codes)

    def test_every_setting_that_any_text_names_exists(self):
        named = re.findall(r"^\| `((\w+)\.\w+)` \|", PAGES["docs/reference/settings.md"], re.M)
        settings, groups = {name for name, _ in named}, sorted({group for _, group in named})
        self.assertGreater(len(settings), 60)
        # Members of the programs' own structures have the same names as settings: of C++ only texts count.
        texts = {path: "\n".join(re.findall(r'"((?:[^"\\\n]|\\.)*)"', (ROOT / path).read_text())) for path in FILES
                 if path.endswith((".cpp", ".hpp")) and not path.startswith("tests/")}
        texts |= {path: "\n".join(json.loads((ROOT / path).read_text()).values()) for path in FILES if path.startswith("web/lang/")}
        texts |= {path: (ROOT / path).read_text() for path in FILES if re.fullmatch(r"web/plain/.*|README\.md|docs/.*\.md|api/openapi\.yaml", path)}
        setting = re.compile(rf"(?<![\w./-])(({'|'.join(groups)})\.[a-z]\w*)(?!\w*[.(/])")
        files = {"stl", "obj", "ply", "off", "glb", "zip", "svg", "png", "jpg", "pdf", "json", "mtl", "html", "ini", "csv", "icc", "txt", "md"}
        unknown = [f"{path}: {name}" for path, text in sorted(texts.items()) for name, _ in setting.findall(text)
                   if name not in settings and name.partition(".")[2] not in files]
        self.assertEqual(unknown, [])


class Sessions(Case):
    """The commands of the pages, run as they are written."""

    def run_blocks(self, blocks, here, **environment):
        self.assertTrue(blocks)
        # Files and not pipes: a process that outlives the session would hold a pipe open.
        with open(here.with_suffix(".out"), "w+") as out, open(here.with_suffix(".err"), "w+") as err:
            done = subprocess.run(["bash", "-euo", "pipefail", "-c", "\n".join(blocks)], cwd=here, stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                                  timeout=3 * PATIENCE, env={**os.environ, "no_proxy": "*", **environment})
            err.seek(0)
            out.seek(0)
            self.assertEqual(done.returncode, 0, err.read())
            return out.read()

    def with_server(self, name, server):
        """A folder as the pages of the service presuppose it: a token, a scan and a pattern."""
        here = self.folder / name
        (here / "var").mkdir(parents=True)
        (here / "api").symlink_to(ROOT / "api")
        (here / "var" / "token").write_bytes(server.token_file.read_bytes())
        (here / "head.stl").write_bytes(hostile.stl(hostile.dome_triangles()))
        (here / "coils.svg").write_bytes(hostile.GOOD_SVG)
        return here

    def test_tutorial(self):
        here = self.folder / "tutorial"
        programs = here / "build/release/bin"
        programs.mkdir(parents=True)
        # In the place of the program: the same, with a coarser grid where the tutorial waits for the default one.
        (programs / "vacuform").write_text(f"""#!/bin/bash
case " $* " in
  " run "*" --preview "*) ;;
  " run "*) set -- "$@" --set sheet.resolution_mm=4 --set print.dpi=100 ;;
esac
exec {shlex.quote(str(BIN / "vacuform"))} "$@"
""")
        (programs / "vacuform").chmod(0o755)
        said = self.run_blocks(shell_blocks("docs/tutorial-first-print.md"), here)
        self.assertRegex(said, r"(?m)^trim +85\.\d mm")
        for folder in "preview", "array", "print", "turned":
            self.assertEqual((here / folder / "print.pdf").read_bytes()[:5], b"%PDF-", folder)
            self.assertTrue((here / folder / "report.html").exists())
        self.assertFalse((here / "cache").exists())
        # What the tutorial says that one sees there.
        self.assertRegex(said, r"Circles out of round, mean \(worst\) +1[23]\.\d\d % .* 0\.0\d % ")
        alone, parted, *_ = said.split("Files: ")
        self.assertIn("1 serious warning, 3 warnings", alone)
        self.assertIn("19 loops: 1 net,", alone)
        self.assertIn("0 serious warnings, ", parted)
        self.assertIn("19 loops: 19 nets, 0 shorts, 0 opens; 84 bridges, 76 gaps.", parted)
        self.assertTrue((here / "print/print-bridges.pdf").exists())
        self.assertIn("Largest coupling", said)

    def test_sessions_of_readme_and_api(self):
        here = self.folder / "server"
        here.mkdir()
        with Server(here, workers=2) as server:
            address = "http://127.0.0.1:8080"
            for page, wanted in (("README.md", [b for b in shell_blocks("README.md") if "ask()" in b]),
                                 ("docs/reference/api.md", shell_blocks("docs/reference/api.md"))):
                self.assertIn(address, wanted[0])
                there = self.with_server(page.replace("/", "-"), server)
                self.run_blocks([b.replace(address, server.url) for b in wanted], there)
                with zipfile.ZipFile(there / "job.zip") as archive:
                    self.assertIsNone(archive.testzip())
                    self.assertIn("report.json", {n.rpartition("/")[2] for n in archive.namelist()})
            self.assertEqual((self.folder / "README.md" / "print.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
            self.assertEqual((self.folder / "docs-reference-api.md" / "print.pdf").read_bytes()[:5], b"%PDF-")


class Scripts(unittest.TestCase):
    def test_the_generator_can_be_run(self):
        self.assertTrue((ROOT / "docs/generate").stat().st_mode & stat.S_IXUSR)


if __name__ == "__main__":
    unittest.main()
