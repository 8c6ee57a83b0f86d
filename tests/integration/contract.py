"""Holds exchanges with the API against api/openapi.yaml: every route, parameter, status, media type and JSON body.

A small validator of our own for the part of JSON Schema that the description uses; a keyword that it does not know is a
fault of the test, not something to pass over.
"""
import json
import pathlib
import re
import urllib.parse

import yaml

DESCRIPTION = pathlib.Path(__file__).resolve().parents[2] / "api" / "openapi.yaml"
ANNOTATIONS = {"description", "title", "format", "examples", "default", "contentMediaType"}
TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None), "number": (int, float),
         "integer": int}


class Broken(AssertionError):
    """The service does not do what it says."""


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
        """The operation, its parameters and where it stands; None when nothing like it is described."""
        method = "get" if method == "HEAD" else method.lower()
        for pattern, template, item in self.routes:
            if pattern.fullmatch(path) and method in item:
                operation = item[method]
                parameters = [self.resolved(p) for p in item.get("parameters", []) + operation.get("parameters", [])]
                return operation, parameters, f"{method.upper()} {template}"
        return None

    def check(self, method, url, sent, status, headers, body):
        """One exchange. `sent`: headers of the request, names in lower case; `headers`: those of the answer."""
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
            self.check_request(operation, parameters, parts.query, sent, where)
        self.check_answer(operation, where, method, status, headers, body)

    def check_request(self, operation, parameters, query, sent, where):
        """Only of requests that were taken: others may break any rule."""
        known = {p["name"]: p for p in parameters if p["in"] == "query"}
        for name, values in urllib.parse.parse_qs(query, keep_blank_values=True).items():
            if name not in known:
                raise Broken(f"{where}: takes a query {name} that is not described")
            kind = self.resolved(known[name]["schema"]).get("type")
            value = int(values[0]) if kind == "integer" else values[0]
            self.check_value(value, known[name]["schema"], f"{where}?{name}")
        for p in parameters:
            if p["in"] == "header" and p.get("required") and p["name"].lower() not in sent and "HEAD" not in where \
                    and p["name"] != "Tus-Resumable":
                raise Broken(f"{where}: taken without {p['name']}")
        if "content-type" in sent and "requestBody" in operation:
            media = sent["content-type"].split(";")[0].strip()
            if media not in operation["requestBody"]["content"]:
                raise Broken(f"{where}: takes {media}, which is not described")

    def check_answer(self, operation, where, method, status, headers, body):
        answers = operation["responses"]
        answer = answers.get(str(status), answers.get("default") if status >= 400 else None)
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


def of_curl(words):
    """Method, URL and headers of a request as curl's words say them; no URL: nothing to check."""
    method, url, headers = None, None, {}
    words = [str(w) for w in words]
    for word, after in zip(words, words[1:] + [""]):
        if word == "-X":
            method = after
        elif word == "-H" and ":" in after:
            name, _, value = after.partition(":")
            headers[name.strip().lower()] = value.strip()
        elif word in ("-I", "--head"):
            method = method or "HEAD"
        elif word == "-T":
            method = method or "PUT"
        elif word.startswith("-F"):
            method = method or "POST"
            headers.setdefault("content-type", "multipart/form-data")
        elif word in ("-d", "--data", "--data-binary", "--json"):
            method = method or "POST"
        elif word.startswith("http://127.0.0.1:"):
            url = word
    return method or "GET", url, headers
