"""deploy/kubernetes against the types of Kubernetes and KEDA, generated from their own schemas, and against the programs."""
import json
import pathlib
import re
import subprocess
import unittest

import yaml

from harness import BIN, Case

ROOT = pathlib.Path(__file__).resolve().parents[2]
TYPES = ROOT / "tests" / "manifests"
FOLDER = ROOT / "deploy" / "kubernetes"


def objects(folder=FOLDER):
    """(file name, object) of every document that kustomization.yaml names."""
    for name in yaml.safe_load((folder / "kustomization.yaml").read_text())["resources"]:
        for document in yaml.safe_load_all((folder / name).read_text()):
            yield name, document


def checked(documents, folder):
    """What the compiler says against objects as values of their types: unknown and missing members, wrong values."""
    lines = []
    for number, (name, document) in enumerate(documents):
        version, kind = document["apiVersion"], document["kind"]
        package = "@kubernetes-models/keda" if version.startswith("keda.sh/") else "kubernetes-models"
        lines.append(f"import type {{I{kind} as T{number}}} from '{package}/{version}';  // {name}\n"
                     f"export const o{number}: T{number} = {json.dumps(document)};\n")
    (folder / "objects.ts").write_text("".join(lines))
    if not (folder / "node_modules").exists():
        (folder / "node_modules").symlink_to(TYPES / "node_modules")
    done = subprocess.run([TYPES / "node_modules/.bin/tsc", "--noEmit", "--strict", "--skipLibCheck", "--module", "preserve",
                           folder / "objects.ts"], capture_output=True, text=True, cwd=folder)
    return done.stdout + done.stderr


class Manifests(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        done = subprocess.run([ROOT / "web" / "install", TYPES], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr

    def test_every_object_is_valid(self):
        kinds = {document["kind"] for _, document in objects()}
        self.assertEqual(kinds, {"Namespace", "Deployment", "StatefulSet", "PodDisruptionBudget", "Job", "Service", "Ingress", "ScaledObject",
                                 "TriggerAuthentication", "NetworkPolicy"})
        self.assertEqual(checked(objects(), self.folder), "")

    def test_faults_are_found(self):
        def deployment(change):
            found = next(d for _, d in objects() if d["kind"] == "Deployment")
            change(found)
            return checked([("workers.yaml", found)], self.folder)
        self.assertIn("replica", deployment(lambda d: d["spec"].update(replica=1)))
        self.assertIn("string", deployment(lambda d: d["spec"].update(replicas="one")))
        self.assertIn("selector", deployment(lambda d: d["spec"].pop("selector")))
        container = lambda d: d["spec"]["template"]["spec"]["containers"][0]
        self.assertIn("livenesProbe", deployment(lambda d: container(d).update(livenesProbe={})))

    def test_every_setting_is_known_to_its_program(self):
        for _, document in objects():
            if document["kind"] not in ("Deployment", "StatefulSet", "Job"):
                continue
            (container,) = document["spec"]["template"]["spec"]["containers"]
            program, *words = [word for word in container["args"] if word != "migrate"]  # it reads the same settings
            environment = {"PATH": "/usr/bin:/bin", "VACUFORM_TOKEN": "none"}
            for variable in container["env"]:
                environment.setdefault(variable["name"], variable.get("value", "x"))
            done = subprocess.run([BIN / program, *words, "--check-config"], env=environment, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            prefix = "VACUFORM_" + program.removeprefix("vacuform-").upper() + "_"
            settings = json.loads(done.stdout)
            for name, value in environment.items():
                if name.startswith(prefix):
                    self.assertEqual(str(settings[name.removeprefix(prefix).lower()]), value)

    def test_every_secret_is_in_the_documentation(self):
        text = "\n".join(json.dumps(document) for _, document in objects())
        page = (ROOT / "docs/operate/worker-fleets.md").read_text()
        secrets = set(re.findall(r'"secretKeyRef": {"name": "([a-z-]+)"', text)) | set(re.findall(r'"secretName": "([a-z-]+)"', text))
        self.assertEqual(secrets, {"vacuform-objects", "vacuform-postgresql", "vacuform-tls", "vacuform-tokens"})
        for secret in secrets:
            self.assertIn(f" {secret} ", page)


if __name__ == "__main__":
    unittest.main()
