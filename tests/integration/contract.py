"""Checks exchanges with the API against api/openapi.yaml: every route, parameter, status, media type and JSON body.

A small validator for the part of JSON Schema that the description uses; an unknown keyword is an error of the test and
is not skipped.
"""
import dataclasses
import email
import email.policy
import json
import pathlib
import re
import urllib.parse

import yaml

DESCRIPTION = pathlib.Path(__file__).resolve().parents[2] / "api" / "openapi.yaml"
ANNOTATIONS = {"description", "title", "format", "examples", "default", "contentMediaType"}
METHODS = {"get", "post", "put", "patch", "delete", "options"}
TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None), "number": (int, float),
         "integer": int}


class Broken(AssertionError):
    """The service does not match its description."""


@dataclasses.dataclass
class Part:
    """One part of a form: the bytes of a file, or a text."""
    name: str
    content: bytes
    is_file: bool


def is_of(value, kind):
    if isinstance(value, bool) and kind != "boolean":
        return False
    return isinstance(value, TYPES[kind]) or (kind == "integer" and isinstance(value, float) and value.is_integer())


class Contract:
    def __init__(self, text=None):
        self.root = yaml.safe_load(text or DESCRIPTION.read_text())
        self.routes = []
        for path in sorted(self.root["paths"], key=lambda p: p.count("{")):
            pattern = re.sub(r"\\\{\w+\\\}", "[^/]+", re.escape(path))
            self.routes.append((re.compile(pattern), path, self.root["paths"][path]))
        # Headers that some operation describes are ignored by the operations that do not.
        self.special_headers = {p["name"].lower() for p in self.all_parameters() if p["in"] == "header"}
        self.taken = set()  # operations that accepted a request

    def all_parameters(self):
        for item in self.root["paths"].values():
            for place in (item, *(item[m] for m in item.keys() & METHODS)):
                yield from map(self.resolved, place.get("parameters", []))

    def all_operations(self):
        return {f"{method.upper()} {path}" for path, item in self.root["paths"].items() for method in item.keys() & METHODS}

    def resolved(self, node):
        while isinstance(node, dict) and "$ref" in node:
            target = self.root
            for key in node["$ref"].removeprefix("#/").split("/"):
                target = target[key]
            node = {**target, **{k: v for k, v in node.items() if k != "$ref"}}
        return node

    def check_value(self, value, schema, where):
        schema = self.resolved(schema)
        if schema is True or schema == {}:
            return
        def fail(why):
            raise Broken(f"{where}: {why}: {json.dumps(value)[:300]}")
        for key, rule in schema.items():
            if key in ANNOTATIONS or key.startswith("x-"):
                continue
            if key == "type":
                kinds = rule if isinstance(rule, list) else [rule]
                if not any(is_of(value, kind) for kind in kinds):
                    fail(f"not of type {rule}")
            elif key == "enum":
                if value not in rule:
                    fail(f"not one of {rule}")
            elif key == "const":
                if value != rule:
                    fail(f"not {rule!r}")
            elif key in ("allOf", "oneOf", "anyOf"):
                self.check_combined(value, key, rule, where)
            elif key in ("required", "properties", "patternProperties", "additionalProperties"):
                if isinstance(value, dict):
                    self.check_object(value, key, rule, schema, where)
            elif key == "items":
                for i, item in enumerate(value if isinstance(value, list) else []):
                    self.check_value(item, rule, f"{where}[{i}]")
            elif key in ("minItems", "maxItems", "minLength", "maxLength"):
                if isinstance(value, list if "Items" in key else str):
                    if (len(value) < rule) if key.startswith("min") else (len(value) > rule):
                        fail(f"{key} is {rule}")
            elif key in ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"):
                if is_of(value, "number"):
                    good = {"minimum": value >= rule, "maximum": value <= rule, "exclusiveMinimum": value > rule,
                            "exclusiveMaximum": value < rule}[key]
                    if not good:
                        fail(f"{key} is {rule}")
            elif key == "pattern":
                if isinstance(value, str) and not re.search(rule, value):
                    fail(f"does not match {rule}")
            else:
                raise Broken(f"the validator does not know the keyword {key} ({where})")

    def check_combined(self, value, key, schemas, where):
        faults = []
        for schema in schemas:
            try:
                self.check_value(value, schema, where)
            except Broken as fault:
                faults.append(str(fault))
        fits = len(schemas) - len(faults)
        if (key == "allOf" and faults) or (key == "anyOf" and fits == 0) or (key == "oneOf" and fits != 1):
            raise Broken(f"{where}: {fits} of {len(schemas)} of {key} fit; {'; '.join(faults)}")

    def check_object(self, value, key, rule, schema, where):
        if key == "required":
            lacking = [name for name in rule if name not in value]
            if lacking:
                raise Broken(f"{where}: lacks {lacking}")
        elif key == "properties":
            for name in rule.keys() & value.keys():
                self.check_value(value[name], rule[name], f"{where}.{name}")
        else:
            patterns = schema.get("patternProperties", {})
            for name in value:
                fitting = [p for p in patterns if re.search(p, name)]
                if key == "patternProperties":
                    for pattern in fitting:
                        self.check_value(value[name], patterns[pattern], f"{where}.{name}")
                elif not fitting and name not in schema.get("properties", {}):
                    if rule is False:
                        raise Broken(f"{where}: {name} is not described")
                    self.check_value(value[name], rule, f"{where}.{name}")

    def operation(self, method, path):
        """The operation, its parameters and its place in the description; None if no operation matches."""
        method = "get" if method == "HEAD" else method.lower()
        for pattern, template, item in self.routes:
            if pattern.fullmatch(path) and method in item:
                operation = item[method]
                parameters = [self.resolved(p) for p in item.get("parameters", []) + operation.get("parameters", [])]
                return operation, parameters, f"{method.upper()} {template}"
        return None

    def check(self, method, url, sent, status, headers, body, asked=None):
        """One exchange. `sent`: headers of the request, names in lower case; `asked`: its body, bytes or a list of
        Parts; `headers`, `body`: those of the answer."""
        parts = urllib.parse.urlsplit(url)
        path = urllib.parse.unquote(parts.path)
        if not path.startswith("/api/") and path != "/healthz":
            return
        found = self.operation(method, path)
        if not found:
            if status not in (404, 405, 401, 400, 421, 431, 403):
                raise Broken(f"{method} {path} is not described, and answered {status}")
            return
        operation, parameters, where = found
        if status < 400:
            self.check_request(operation, parameters, parts.query, sent, asked, where)
            self.taken.add(where)
        self.check_answer(operation, where, method, status, headers, body)

    def check_request(self, operation, parameters, query, sent, asked, where):
        """Checks accepted requests only: a refused request may have broken any rule, an accepted one none."""
        known = {p["name"]: p for p in parameters if p["in"] == "query"}
        for name, values in urllib.parse.parse_qs(query, keep_blank_values=True).items():
            if name not in known:
                raise Broken(f"{where}: takes a query {name} that is not described")
            if len(values) > 1:
                raise Broken(f"{where}: takes {name} more than once")
            self.check_text(values[0], known[name]["schema"], f"{where}?{name}")
        described = {p["name"].lower(): p for p in parameters if p["in"] == "header"}
        for name, p in described.items():
            if name in sent:
                self.check_text(sent[name], p["schema"], f"{where}: {p['name']}")
            elif p.get("required"):
                raise Broken(f"{where}: taken without {p['name']}")
        for name in sent.keys() & self.special_headers - described.keys():
            raise Broken(f"{where}: takes {name}, which is not described there")
        self.check_body(self.resolved(operation.get("requestBody")), sent, asked, where)

    def check_text(self, text, schema, where):
        """A parameter, which is text on the wire, converted to the type of its schema."""
        kind = self.resolved(schema).get("type")
        if kind == "integer":
            if not re.fullmatch(r"-?[0-9]+", text):
                raise Broken(f"{where}: not a whole number: {text}")
            text = int(text)
        self.check_value(text, schema, where)

    def check_body(self, described, sent, asked, where):
        if not asked:
            if described and described.get("required"):
                raise Broken(f"{where}: taken without a body")
            return
        if not described:
            raise Broken(f"{where}: takes a body, which is not described")
        media = sent.get("content-type", "").split(";")[0].strip()
        if media not in described["content"]:
            raise Broken(f"{where}: takes {media!r}, which is not described")
        content = described["content"][media]
        schema = self.resolved(content.get("schema", {}))
        if media == "multipart/form-data":
            self.check_form(asked if isinstance(asked, list) else parts_of(sent["content-type"], asked), schema,
                            content.get("encoding", {}), where)
        elif media.endswith("json"):
            self.check_value(json.loads(asked), schema, f"{where} body")

    def check_form(self, parts, schema, encoding, where):
        names = [part.name for part in parts]
        for name in names:
            if names.count(name) > 1:
                raise Broken(f"{where}: takes {name} more than once")
        for part in parts:
            at = f"{where} part {part.name}"
            patterns = [v for k, v in schema.get("patternProperties", {}).items() if re.search(k, part.name)]
            rules = [schema["properties"][part.name]] if part.name in schema.get("properties", {}) else patterns
            if not rules:
                raise Broken(f"{at}: not described")
            for rule in map(self.resolved, rules):
                if part.is_file != ("contentMediaType" in rule):
                    raise Broken(f"{at}: {'a file' if part.is_file else 'no file'}")
                if not part.is_file:
                    self.check_value(part.content.decode(), rule, at)
            if encoding.get(part.name, {}).get("contentType") == "application/json" and part.content.strip() \
                    and not isinstance(json.loads(part.content), dict):
                raise Broken(f"{at}: no JSON object")
        lacking = set(schema.get("required", [])) - set(names)
        if lacking:
            raise Broken(f"{where}: taken without {lacking}")

    def check_answer(self, operation, where, method, status, headers, body):
        answers = operation["responses"]
        answer = answers.get(str(status)) or answers.get(f"{status // 100}XX")
        if answer is None:
            raise Broken(f"{where}: the status {status} is not described")
        answer = self.resolved(answer)
        content = answer.get("content", {})
        media = headers.get("content-type", "").split(";")[0].strip()
        if method == "HEAD":
            return
        if not content:
            if body:
                raise Broken(f"{where}: {status} has a body that is not described: {body[:100]!r}")
            return
        schema = content.get(media) or content.get("*/*")
        if schema is None:
            raise Broken(f"{where}: {status} is of type {media!r}, described are {list(content)}")
        if media.endswith("json") and "schema" in schema and media in content:
            self.check_value(json.loads(body), schema["schema"], f"{where} {status}")


def parts_of(content_type, body):
    """The parts of a form that was assembled by hand."""
    text = b"Content-Type: " + content_type.encode() + b"\r\n\r\n" + body
    message = email.message_from_bytes(text, policy=email.policy.HTTP)
    return [Part(p.get_param("name", header="content-disposition"), p.get_payload(decode=True) or b"",
                 p.get_filename() is not None) for p in message.iter_parts()]


def part_of(word):
    """A part of a form in the syntax of curl's -F: name=text, name=@file, name=<file with text."""
    name, _, value = word.partition("=")
    if value.startswith(("@", "<")):
        path = pathlib.Path(re.split(r";(?:type|filename)=", value[1:])[0])
        # The contract only knows that the part is a file.
        return Part(name, b"" if value[0] == "@" else path.read_bytes(), value[0] == "@")
    return Part(name, value.encode(), False)


def of_curl(words):
    """Method, URL, headers and body (bytes, or a list of Parts) of a request from curl's arguments; without a URL there
    is nothing to check."""
    method, url, headers, body, kind = None, None, {}, None, None
    words = [str(w) for w in words]
    for word, after in zip(words, words[1:] + [""]):
        if word == "-X":
            method = after
        elif word == "-H" and ":" in after:
            name, _, value = after.partition(":")
            headers[name.strip().lower()] = value.strip()
        elif word == "-r":
            headers["range"] = "bytes=" + after
        elif word in ("-I", "--head"):
            method = method or "HEAD"
        elif word == "-T":
            method, body = method or "PUT", pathlib.Path(after).read_bytes()
        elif word.startswith("-F"):
            method, kind = method or "POST", "multipart/form-data"
            body = [*(body or []), part_of(word[2:] or after)]
        elif word in ("-d", "--data-binary"):
            method, kind = method or "POST", "application/x-www-form-urlencoded"
            body = pathlib.Path(after[1:]).read_bytes() if after.startswith("@") else after.encode()
        elif word.startswith("http://127.0.0.1:"):
            url = word
    if kind:
        headers.setdefault("content-type", kind)
    return method or "GET", url, headers, body
