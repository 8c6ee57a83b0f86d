"""The order of the folders: a file includes files of its own folder and of folders before it, never of one after it."""
import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
INCLUDE = re.compile(r'^#include "([^"]+)"', re.M)

# Each folder with those that it may include. `+` is all that the named folder may include, too.
MAY_INCLUDE = {
    "api/base": "",
    "api/redaction": "api/base api/print_step.hpp",
    "api": "api/base",
    "api/client": "api +",
    "server/store": "api/client +",
    "server/store/blobs/files": "server/store +",
    "server/store/blobs/s3": "server/store +",
    "server/store/sqlite": "server/store +",
    "server/store/postgres": "server/store +",
    "server/store/sql": "server/store/blobs/files + server/store/blobs/s3 server/store/sqlite server/store/postgres",
    "server/messages": "api +",
    "server/http": "server/messages +",
    "server/access": "server/store + server/messages",
    "server/jobs": "server/access + api/redaction",
    "server/pages": "server/jobs +",
    "server/routes": "server/pages + server/http",
    "server/commands": "server/routes + server/store/sql + api/client",
    "worker/stage": "api +",
    "worker/png": "api/base",
    "worker/numerics": "worker/stage +",
    "worker/surface": "worker/numerics +",
    "worker/gltf": "worker/surface +",
    "worker/scan": "worker/surface +",
    "worker/forming/heat": "worker/scan + worker/png worker/forming/material.hpp",
    "worker/forming": "worker/forming/heat +",
    "worker/flattening": "worker/forming +",
    "worker/pattern": "worker/numerics + worker/png api/redaction",
    "worker/colour": "worker/forming + worker/pattern",
    "worker/placement": "worker/flattening + worker/pattern",
    "worker/coils": "worker/placement +",
    "worker/electrical": "worker/coils +",
    "worker/conductors": "worker/electrical +",
    "worker/printing": "worker/conductors + worker/colour",
    "worker/inspection": "worker/printing + worker/gltf",
    "worker/studies": "worker/printing +",
    "worker/sample": "worker/gltf + worker/png",
    "worker/pipeline": "worker/inspection + worker/studies",
    "worker/cli": "worker/pipeline + worker/sample api/client api/redaction",
    "worker/agent": "api + api/client",
}


def allowed(folder):
    found = {folder}
    words = MAY_INCLUDE[folder].split()
    for place, word in enumerate(words):
        if word == "+":
            found |= allowed(words[place - 1])
        else:
            found.add(word)
    return found


def wrong_includes(path, text):
    """The files that a file includes and must not."""
    folder = path.rpartition("/")[0]
    return [name for name in INCLUDE.findall(text)
            if not {name, name.rpartition("/")[0]} & allowed(folder)]


class Layout(unittest.TestCase):
    def test_no_file_includes_one_above_it(self):
        listed = subprocess.run(["git", "ls-files", "api/*.?pp", "server/*.?pp", "worker/*.?pp"], cwd=ROOT, capture_output=True, text=True,
                                check=True)
        files = listed.stdout.split()
        self.assertGreater(len(files), 400)
        wrong = {path: found for path in files if (found := wrong_includes(path, (ROOT / path).read_text()))}
        self.assertEqual(wrong, {})

    def test_an_include_of_a_folder_above_is_noticed(self):
        self.assertEqual(wrong_includes("worker/surface/adjacency.cpp", '#include "worker/forming/formed_sheet.hpp"\n'),
                         ["worker/forming/formed_sheet.hpp"])
        self.assertEqual(wrong_includes("server/store/blobs.cpp", '#include "server/messages/message.hpp"\n#include "api/job.hpp"\n'),
                         ["server/messages/message.hpp"])


if __name__ == "__main__":
    unittest.main()
