#!/usr/bin/env python3
"""Writes src/api/types.ts from api/openapi.yaml: what the API sends, as the web application uses it.

    web/types.py            writes the file
    web/types.py --check    fails if the file is out of date
"""
import pathlib
import sys
import textwrap

import yaml

HERE = pathlib.Path(__file__).resolve().parent
SOURCE, TARGET = HERE.parent / "api" / "openapi.yaml", HERE / "src" / "api" / "types.ts"

# The interfaces by their names in the application: a schema of the description, or what an operation answers.
NAMES = {
    "JobKind": "JobKind", "JobState": "JobState", "Stage": "Stage", "Scope": ("Scopes", "items"),
    "ArtifactName": "ArtifactName", "ProblemBody": "Problem", "Input": "Input", "Artifact": "Artifact", "Warning": "Warning",
    "Links": ("ListedJob", "properties", "links"), "ListedJob": "ListedJob", "Estimates": ("GET /api/v1/jobs/{id}", "allOf", 1),
    "LogLine": "LogLine", "ReferenceChange": "ReferenceChange", "JobPage": "GET /api/v1/jobs", "LogPage": "GET /api/v1/jobs/{id}/log", "Plan": "POST /api/v1/validate",
    "Session": "GET /api/v1/session", "Profile": "Profile", "TokenInfo": "Token", "Service": "GET /api/v1/service",
}
# Members of lists that only a full job has.
ONLY_FULL = ["settings", "inputs", "artifacts", "reference_changes", "printed_reference", "links"]
# Members that the application leaves out of problems that it makes itself, such as when the server does not answer.
OPTIONAL = {("ProblemBody", member) for member in ("detail", "what", "where", "fix", "proposals")}
# What a kind has besides: the estimates are only in the answer for one job, the format only in a plan.
EXTENDS = {"ListedJob": " extends Partial<Estimates>"}
MORE = {"Input": ["  format?: string;"]}
# Members that are an object whose content another document describes.
SETTINGS = {("ListedJob", "settings"), ("Plan", "settings"), ("Profile", "settings")}

# The schema of the settings is JSON Schema itself; the description says no more of it than "object".
TAIL = """
export type Settings = Record<string, Record<string, unknown>>;

export interface Job extends ListedJob {
  settings: Settings;
  inputs: Record<string, Input>;
  artifacts: Artifact[];
  reference_changes: ReferenceChange[];
  printed_reference: string | null;
  links: Links;
}

// The JSON Schema of the settings, as far as the form uses it.
export interface FieldSchema {
  type?: string;
  title?: string;
  description?: string;
  default?: unknown;
  enum?: string[];
  minimum?: number;
  maximum?: number;
  minItems?: number;
  maxItems?: number;
  items?: FieldSchema;
  oneOf?: FieldSchema[];
  'x-unit'?: string;
}
export interface SettingsSchema {
  properties: Record<string, {title?: string; description?: string; properties: Record<string, FieldSchema>}>;
}

export const ended = (state: JobState): boolean => state === 'succeeded' || state === 'failed' || state === 'cancelled';
"""


class Loader(yaml.SafeLoader):
    """Reads `off` as text, as YAML 1.2 does; only true and false are booleans."""


Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag != "tag:yaml.org,2002:bool" or first in "tTfF"]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()}


class Types:
    def __init__(self, description):
        self.description = description
        self.schemas = description["components"]["schemas"]
        self.named = {}  # a schema's name or address: the name of its interface
        for name, source in NAMES.items():
            if isinstance(source, str):
                self.named[source] = name

    def schema(self, source):
        if isinstance(source, tuple):
            schema = self.schema(source[0])
            for step in source[1:]:
                schema = schema[step]
            return schema
        if " " not in source:
            return self.schemas[source]
        method, path = source.split(" ")
        responses = self.description["paths"][path][method.lower()]["responses"]
        answer = next(responses[code] for code in ("200", "201", "202") if code in responses)
        return answer["content"]["application/json"]["schema"]

    def type(self, schema, owner="", member=""):
        """The TypeScript type of a schema."""
        if (owner, member) in SETTINGS:
            return "Settings"
        if "$ref" in schema:
            name = schema["$ref"].rsplit("/", 1)[1]
            if name in self.named:
                return self.named[name]
            if name == "Scopes":
                return "Scope[]"
            if name == "Inputs":
                return "Record<string, Input>"
            return self.type(self.schemas[name])
        if "const" in schema:
            return literal(schema["const"])
        if "enum" in schema:
            return " | ".join(literal(value) for value in schema["enum"])
        if "oneOf" in schema:
            return " | ".join(dict.fromkeys(self.type(one) for one in schema["oneOf"]))
        if "allOf" in schema:
            return " & ".join(dict.fromkeys(self.type(one) for one in schema["allOf"] if set(one) != {"required"}))
        kinds = schema.get("type", "object")
        kinds = kinds if isinstance(kinds, list) else [kinds]
        return " | ".join(self.simple(kind, schema) for kind in kinds)

    def simple(self, kind, schema):
        if kind in ("integer", "number"):
            return "number"
        if kind in ("string", "boolean", "null"):
            return kind
        if kind == "array":
            of = self.type(schema["items"])
            fixed = schema.get("minItems")
            if fixed and fixed == schema.get("maxItems"):
                return f"[{', '.join([of] * fixed)}]"
            return f"({of})[]" if "|" in of or "&" in of else f"{of}[]"
        if "properties" in schema:
            return "{" + "; ".join(f"{name}{self.mark(schema, name)}: {self.type(one)}"
                                   for name, one in schema["properties"].items()) + "}"
        inner = schema.get("additionalProperties")
        return f"Record<string, {self.type(inner) if isinstance(inner, dict) else 'unknown'}>"

    @staticmethod
    def mark(schema, name):
        return "" if name in schema.get("required", []) else "?"

    def declaration(self, name, source):
        schema = self.schema(source)
        if "properties" not in schema:
            return wrapped(f"export type {name} = {self.type(schema)};")
        lines = [f"export interface {name}{EXTENDS.get(name, '')} {{"]
        for member, one in schema["properties"].items():
            if name == "ListedJob" and member in ONLY_FULL:
                continue
            mark = "?" if (name, member) in OPTIONAL else self.mark(schema, member)
            lines.append(wrapped(f"  {member}{mark}: {self.type(one, name, member)};"))
        return "\n".join([*lines, *MORE.get(name, []), "}"])

    def text(self):
        parts = [self.declaration(name, source) for name, source in NAMES.items()]
        return ("// Written by web/types.py from api/openapi.yaml. Change the description, then run web/types.py.\n\n" +
                "\n\n".join(parts) + "\n" + TAIL)


def wrapped(line):
    """A long line in several, of at most 120 columns."""
    return "\n".join(textwrap.wrap(line, 120, break_on_hyphens=False, initial_indent="", subsequent_indent=" " * (len(line) - len(line.lstrip()) + 2),
                                   break_long_words=False, drop_whitespace=True))


def literal(value):
    return f"'{value}'" if isinstance(value, str) else str(value).lower()


def main():
    text = Types(yaml.load(SOURCE.read_text(), Loader)).text()
    if "--check" in sys.argv:
        if not TARGET.exists() or TARGET.read_text() != text:
            sys.exit(f"{TARGET.name} is out of date: run web/types.py")
    else:
        TARGET.write_text(text)


if __name__ == "__main__":
    main()
