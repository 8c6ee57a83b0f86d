#!/usr/bin/env python3
"""A client of the Vacuform service in one file. Needs Python 3.9 or later and nothing else: copy it where you need it.

As a module:

    import vacuform
    service = vacuform.Service("https://vacuform.example.org", token=open("token").read().strip())
    job = service.submit(scan="head.stl", pattern="coils.svg", settings={"print": {"dpi": 600}})
    job = service.wait(job["id"], lambda j: print(j["state"], j["stage"], j["progress"]))
    service.download_all(job["id"], "out")

As a program, with the token in a file that others cannot read:

    python3 vacuform.py --server https://vacuform.example.org --token-file token --scan head.stl --pattern coils.svg --out out

A request that cannot reach the service, or that the service answers with 429, 502, 503 or 504, is sent again, after
Retry-After where it is given. A submission carries an Idempotency-Key, so that sending it again makes no second job.
"""
import argparse
import base64
import hashlib
import http.client
import json
import os
import pathlib
import ssl
import sys
import time
import urllib.parse
import uuid

ENDED = ("succeeded", "failed", "cancelled")
RETRIED = (429, 502, 503, 504)
LARGE = 64 << 20  # bytes; a larger scan goes as an upload that resumes after a break
PIECE = 16 << 20  # bytes of an upload in one request


class Problem(Exception):
    """An answer of 400 or more: status, type (such as "/problems/bad-settings"), what, where, fix, proposals. Each proposal
    is {"set": {"scan": {"units": "cm"}}, "text": ...}; with_proposal() merges its settings."""

    def __init__(self, status, problem):
        self.status = status
        self.type = problem.get("type", "about:blank")
        self.what, self.where, self.fix = (problem.get(key, "") for key in ("what", "where", "fix"))
        self.proposals = problem.get("proposals") or []
        super().__init__(problem.get("detail") or f"the service answered {status}")


def with_proposal(settings, proposal):
    """The settings with those that a proposal of a problem or a warning sets. Does not change its arguments."""
    merged = {group: dict(values) for group, values in (settings or {}).items()}
    for group, values in proposal["set"].items():
        merged.setdefault(group, {}).update(values)
    return merged


class Answer:
    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    @property
    def json(self):
        return json.loads(self.body)


class Form:
    """The body of a multipart form. Files are read while they are sent."""

    def __init__(self, fields, files):
        mark = uuid.uuid4().hex
        self.type = "multipart/form-data; boundary=" + mark
        self.parts = []
        for name, value in fields:
            self.parts.append(f'--{mark}\r\nContent-Disposition: form-data; name="{name}"\r\n\r\n{value}\r\n'.encode())
        for name, path in files:
            # The service reads only the extension of a file name.
            kind = pathlib.Path(path).suffix
            self.parts += [f'--{mark}\r\nContent-Disposition: form-data; name="{name}"; filename="{name}{kind}"\r\n'
                           f"Content-Type: application/octet-stream\r\n\r\n".encode(), pathlib.Path(path), b"\r\n"]
        self.parts.append(f"--{mark}--\r\n".encode())

    def __len__(self):
        return sum(len(part) if isinstance(part, bytes) else part.stat().st_size for part in self.parts)

    def __iter__(self):
        for part in self.parts:
            if isinstance(part, bytes):
                yield part
            else:
                with open(part, "rb") as file:
                    while piece := file.read(1 << 20):
                        yield piece


class Service:
    """`url` is that of the service, without /api/v1. `patience` is how long a request is sent again, in seconds."""

    def __init__(self, url, token, patience=300, timeout=90, cafile=None):
        parts = urllib.parse.urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError(f"{url!r} is not an address such as https://vacuform.example.org")
        self.url, self.token, self.patience, self.timeout = parts, token, patience, timeout
        self.context = ssl.create_default_context(cafile=cafile) if parts.scheme == "https" else None

    def _connection(self):
        if self.context:
            return http.client.HTTPSConnection(self.url.hostname, self.url.port, timeout=self.timeout,
                                               context=self.context)
        return http.client.HTTPConnection(self.url.hostname, self.url.port, timeout=self.timeout)

    def _once(self, method, path, headers, body, to):
        connection = self._connection()
        try:
            sent = {"Authorization": "Bearer " + self.token, "Accept": "application/json", **headers}
            if isinstance(body, Form):
                sent["Content-Type"] = body.type
            if body is not None:
                sent["Content-Length"] = str(len(body))
            try:
                connection.request(method, self.url.path.rstrip("/") + "/api/v1" + path, body=body, headers=sent)
            except (BrokenPipeError, ConnectionResetError):
                pass  # the service may have refused the body early: its answer says why
            response = connection.getresponse()
            received = {name.lower(): value for name, value in response.getheaders()}
            if to is not None and response.status == 200:
                return Answer(200, received, _store(response, to))
            return Answer(response.status, received, response.read())
        finally:
            connection.close()

    def request(self, method, path, headers=None, body=None, to=None, again=True):
        """The answer to one request below /api/v1. Raises Problem for 400 and above, ConnectionError where the service
        does not answer. `to` is a file for the body; `again` says whether the request may be sent again."""
        until = time.monotonic() + self.patience
        pause = 1
        while True:
            try:
                answer = self._once(method, path, headers or {}, body, to)
                if answer.status < 400:
                    return answer
                try:
                    problem = Problem(answer.status, answer.json)
                except (ValueError, AttributeError):  # a page of some proxy
                    problem = Problem(answer.status, {})
                if answer.status not in RETRIED:
                    raise problem
                delay = answer.headers.get("retry-after", "")
                pause = int(delay) if delay.isdigit() else pause
            except (OSError, http.client.HTTPException) as error:
                problem = ConnectionError(f"{self.url.geturl()} does not answer: {error}")
            if not again or time.monotonic() + pause > until:
                raise problem
            time.sleep(pause)
            pause = min(2 * pause, 30)

    def submit(self, scan=None, pattern=None, settings=None, **fields):
        """The new job. `scan` and `pattern` are paths; other fields are those of the form, for example kind="inspection" or
        kind="layout", profile="studio", reference="CASE-12" (an order or case number, never a name), note=..., scan_id=...,
        rescan="true" (another scan of the patient who has the reference), or from_job=ID for the files and settings of another
        job."""
        if "from_job" in fields:
            fields["from"] = fields.pop("from_job")
        files = []
        for name, path in (("scan", scan), ("pattern", pattern)):
            if path is None:
                continue
            if os.path.getsize(path) > LARGE:
                fields[name + "_upload"] = self.upload(path, name)
            else:
                files.append((name, path))
        if settings is not None:
            fields["settings"] = json.dumps(settings)
        return self.request("POST", "/jobs", {"Idempotency-Key": uuid.uuid4().hex}, Form(fields.items(), files)).json

    def upload(self, path, name="scan"):
        """Sends a file in pieces (tus 1.0.0) and continues after a break. The id, for scan_upload and pattern_upload."""
        tus = {"Tus-Resumable": "1.0.0"}
        size = os.path.getsize(path)
        data = {"filename": "file" + pathlib.Path(path).suffix, "input": name}
        metadata = ",".join(key + " " + base64.b64encode(value.encode()).decode() for key, value in data.items())
        started = self.request("POST", "/uploads", {**tus, "Upload-Length": str(size), "Upload-Metadata": metadata}, b"")
        id = started.headers["location"].rsplit("/", 1)[1]
        until = time.monotonic() + self.patience
        with open(path, "rb") as file:
            offset = 0
            while offset < size:
                file.seek(offset)
                headers = {**tus, "Upload-Offset": str(offset), "Content-Type": "application/offset+octet-stream"}
                try:
                    answer = self.request("PATCH", "/uploads/" + id, headers, file.read(PIECE), again=False)
                    until = time.monotonic() + self.patience
                except (ConnectionError, Problem) as error:  # how much arrived?
                    if isinstance(error, Problem) and error.status not in (409, 423, *RETRIED):
                        raise
                    if time.monotonic() > until:
                        raise
                    time.sleep(1)
                    answer = self.request("HEAD", "/uploads/" + id, tus)
                offset = int(answer.headers["upload-offset"])
        return id

    def job(self, id):
        return self.request("GET", "/jobs/" + id).json

    def jobs(self, **filters):
        """All jobs that this token may see, newest first. Filters: state, kind, owner, created_after,
        created_before, text."""
        query = {"limit": 100, **filters}
        while True:
            page = self.request("GET", "/jobs?" + urllib.parse.urlencode(query)).json
            yield from page["jobs"]
            if not page["next"]:
                return
            query["cursor"] = page["next"]

    def wait(self, id, changed=lambda job: None):
        """The job once it has ended. Calls `changed` with it whenever state or progress change."""
        tag = None
        while True:
            headers = {"If-None-Match": tag} if tag else {}
            answer = self.request("GET", f"/jobs/{id}?wait=30", headers)
            if answer.status == 200:
                job, tag = answer.json, answer.headers.get("etag")
                changed(job)
                if job["state"] in ENDED:
                    return job

    def cancel(self, id):
        return self.request("POST", f"/jobs/{id}/cancel", body=b"").json

    def set_reference(self, id, reference, rescan=False):
        """Gives a job a reference, or another one. The job, whose reference_changes have every change."""
        body = json.dumps({"reference": reference, "rescan": rescan}).encode()
        return self.request("PATCH", "/jobs/" + id, {"Content-Type": "application/json"}, body).json

    def delete(self, id):
        """Deletes a job that has ended, with its files."""
        self.request("DELETE", "/jobs/" + id)

    def artifacts(self, id):
        return self.request("GET", f"/jobs/{id}/artifacts").json["artifacts"]

    def download(self, id, name, path, sha256=None):
        """One artifact into a file, which appears whole or not at all. Raises ValueError where `sha256` differs."""
        path = pathlib.Path(path)
        partial = path.with_name(path.name + ".part")
        try:
            found = self.request("GET", f"/jobs/{id}/artifacts/{urllib.parse.quote(name)}", to=partial).body
            if sha256 and found != sha256:
                raise ValueError(f"{name} arrived damaged; download it again")
            partial.replace(path)
        finally:
            partial.unlink(missing_ok=True)

    def download_all(self, id, folder):
        """All artifacts of a job, each checked against its SHA-256. Their paths."""
        folder = pathlib.Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        paths = []
        for artifact in self.artifacts(id):
            paths.append(folder / pathlib.PurePosixPath(artifact["name"]).name)
            self.download(id, artifact["name"], paths[-1], artifact.get("sha256"))
        return paths


def _store(response, path):
    """Writes the body into a file. Its SHA-256."""
    digest = hashlib.sha256()
    length = response.getheader("Content-Length")
    written = 0
    with open(path, "wb") as file:
        while piece := response.read(1 << 20):
            digest.update(piece)
            file.write(piece)
            written += len(piece)
    if length is not None and written != int(length):
        raise ConnectionError(f"the answer ended after {written} of {length} bytes")
    return digest.hexdigest()


def main():
    parser = argparse.ArgumentParser(description="Submit a scan and a pattern, wait, and download what the job made.")
    parser.add_argument("--server", required=True, metavar="URL", help="address of the service")
    parser.add_argument("--token-file", required=True, metavar="FILE", help="file with the token")
    parser.add_argument("--scan", metavar="FILE", required=True)
    parser.add_argument("--pattern", metavar="FILE", help="without one, the job inspects the scan")
    parser.add_argument("--kind", choices=("print", "inspection", "layout"), help="what to make; layout: a pattern of coils for the scan")
    parser.add_argument("--settings", metavar="FILE", help="settings as JSON")
    parser.add_argument("--profile", metavar="NAME", help="settings that the service stores")
    parser.add_argument("--reference", metavar="TEXT", help="Order or case number. Do not type a name.")
    parser.add_argument("--rescan", action="store_const", const="true", help="another scan of the patient who has the reference")
    parser.add_argument("--note", metavar="TEXT", help="a remark. Do not type a name.")
    parser.add_argument("--cafile", metavar="FILE", help="certificates to trust, as PEM")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder for the results")
    options = parser.parse_args()
    last = []

    def show(job):
        line = job["state"] + (f", {job['stage']}, {100 * job['progress']:.0f} %" if job.get("stage") else "")
        if last[-1:] != [line]:
            last.append(line)
            print(line, file=sys.stderr)

    try:
        service = Service(options.server, pathlib.Path(options.token_file).read_text().strip(), cafile=options.cafile)
        settings = json.loads(pathlib.Path(options.settings).read_text()) if options.settings else None
        fields = {"kind": options.kind or ("print" if options.pattern else "inspection")}
        for name in ("profile", "reference", "rescan", "note"):
            if getattr(options, name):
                fields[name] = getattr(options, name)
        job = service.submit(options.scan, options.pattern, settings, **fields)
        job = service.wait(job["id"], show)
        if job["state"] != "succeeded":
            problem = job.get("problem") or {}
            print(f"vacuform.py: the job {job['state']}: {problem.get('detail', '')}".rstrip(": "), file=sys.stderr)
            for proposal in problem.get("proposals") or []:
                print(f"vacuform.py: possible settings: {json.dumps(proposal['set'])} {proposal['text']}".rstrip(), file=sys.stderr)
            return 2
        for path in service.download_all(job["id"], options.out):
            print(path)
        return 0
    except (Problem, OSError, ValueError) as error:
        print(f"vacuform.py: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
