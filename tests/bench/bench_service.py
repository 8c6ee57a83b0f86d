#!/usr/bin/env python3
"""Measures the service over HTTP against its targets on two cores: answers while jobs run, a long queue, a large
upload, the store.

    [VACUFORM_BIN=build/tests/bin] tests/bench/bench_service.py [--queued 10000] [--upload-mib 500]

Uses wrk (Debian: wrk) and bench_store. Everything runs on this machine, so clients and workers compete with the server.

 - status requests per second while two jobs run;
 - jobs submitted, listed and drained over HTTP with 10,000 in the queue: each submission sends the same scan and
   pattern. Each of 8 simulated workers takes a lease, sends a heartbeat and two small artifacts and completes the job,
   one connection per request;
 - memory of the server while it receives a scan, first in one form, then in pieces, the first of which is interrupted;
 - cycles of submission, lease and end per second through the store alone.
"""
import argparse
import http.client
import json
import multiprocessing
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "integration"))
os.environ["VACUFORM_BIN"] = str(pathlib.Path(os.environ.get("VACUFORM_BIN", "build/tests/bin")).resolve())
import hostile  # noqa: E402
from chaos_load import BOUNDARY, form  # noqa: E402
from harness import BIN, Server  # noqa: E402

HANDS = 8  # clients, then workers
OWNERS = 10  # each may have a tenth of the queue
MULTIPART, JSON, BYTES = f"multipart/form-data; boundary={BOUNDARY}", "application/json", "application/octet-stream"


def show(what, figure, wanted=""):
    print(f"{what:66}{figure:>26}{wanted:>18}", flush=True)


def ask(port, token, method, path, body=None, kind=JSON, headers=()):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    head = {"Authorization": "Bearer " + token, **dict(headers), **({"Content-Type": kind} if body is not None else {})}
    connection.request(method, path, body, head)
    answer = connection.getresponse()
    text = answer.read()
    connection.close()
    assert answer.status < 300, (method, path, answer.status, text[:300])
    return json.loads(text) if text and answer.status != 204 else None


def job(settings):
    return form(hostile.stl(hostile.dome_triangles()), hostile.GOOD_SVG, {"settings": json.dumps(settings)})


def admin_of(server):
    return server.token_file.read_text().strip()


def together(work, shares):
    """The results of `work` for each share; each share runs in its own process."""
    with multiprocessing.Pool(len(shares)) as hands:
        return hands.starmap(work, shares, 1)


# Answers while two jobs run

def wrk(server, path, connections):
    told = subprocess.run(["wrk", "-t2", f"-c{connections}", "-d8s", "--latency", "-H", "Authorization: Bearer " + admin_of(server),
                           server.url + path], capture_output=True, text=True, check=True).stdout
    return float(re.search(r"Requests/sec:\s+([\d.]+)", told)[1]), re.search(r"99%\s+(\S+)", told)[1], "Non-2xx" in told


def keep_two_running(server, over):
    token, busy = admin_of(server), job({"sheet": {"resolution_mm": 1}, "print": {"dpi": 600}})
    while not over.is_set():
        states = [j["state"] for j in ask(server.port, token, "GET", "/api/v1/jobs?limit=20")["jobs"]]
        for _ in range(3 - sum(s in ("queued", "running") for s in states)):
            ask(server.port, token, "POST", "/api/v1/jobs", busy, MULTIPART)
        over.wait(0.5)


def answers_while_jobs_run(folder):
    with Server(folder, 2) as server:
        over = threading.Event()
        keeper = threading.Thread(target=keep_two_running, args=[server, over])
        keeper.start()
        time.sleep(3)
        latest = server.jobs()[-1]["id"]
        for path in (f"/api/v1/jobs/{latest}", "/api/v1/jobs?limit=20", "/healthz"):
            for connections in (8, 32):
                rate, late, failed = wrk(server, path, connections)
                show(f"GET {path.replace(latest, '{id}')}, {connections} connections, two jobs run",
                     f"{rate:.0f}/s, p99 {late}" + (", some failed" if failed else ""), "1000/s" if latest in path else "")
        over.set()
        keeper.join()


# A long queue

def submit(port, token, count):
    body = job({})
    for _ in range(count):
        ask(port, token, "POST", "/api/v1/jobs", body, MULTIPART)


def milliseconds_of_page(server, cursor=""):
    times = []
    for _ in range(30):
        started = time.monotonic()
        page = ask(server.port, admin_of(server), "GET", "/api/v1/jobs?limit=10" + cursor)
        times.append(1000 * (time.monotonic() - started))
        assert len(page["jobs"]) == 10
    return statistics.median(times)


def page_through(server):
    cursor, ids, started = "", [], time.monotonic()
    while True:
        page = ask(server.port, admin_of(server), "GET", "/api/v1/jobs?limit=100" + cursor)
        ids += [j["id"] for j in page["jobs"]]
        if not page["next"]:
            return ids, time.monotonic() - started
        cursor = "&cursor=" + page["next"]


def work(port, token, _):
    """Takes jobs until the queue is empty; returns the time when each was done."""
    done = []
    while True:
        lease = ask(port, token, "POST", "/api/v1/leases", b'{"worker":"bench","protocol":2}')
        if not lease:
            return done
        root, mine = f"/api/v1/leases/{lease['job']}", {"Vacuform-Lease": lease["lease"]}
        ask(port, token, "POST", root + "/heartbeat", b'{"stage":"forming","progress":0.5}', headers=mine)
        ask(port, token, "PUT", root + "/artifacts/report.json", json.dumps({"of": lease["job"]}).encode(), BYTES, mine)
        ask(port, token, "PUT", root + "/artifacts/print.svg", b"<svg/>", BYTES, mine)
        ask(port, token, "POST", root + "/complete", b"{}", headers=mine)
        done.append(time.time())


def long_queue(folder, count):
    with Server(folder, 0) as server:
        token = admin_of(server)
        owners = [ask(server.port, token, "POST", "/api/v1/tokens", json.dumps({"owner": f"o-{i}", "scopes": ["submit", "read"]}).encode())
                  ["token"] for i in range(OWNERS)]
        together(submit, [(server.port, owner, 1) for owner in owners])
        short = milliseconds_of_page(server)
        rest = count // OWNERS - 1
        started = time.monotonic()
        together(submit, [(server.port, owner, rest) for owner in owners])
        show(f"{rest * OWNERS} jobs submitted, {OWNERS} clients", f"{rest * OWNERS / (time.monotonic() - started):.0f}/s")
        ids, seconds = page_through(server)
        assert len(set(ids)) == len(ids) == (rest + 1) * OWNERS
        show(f"{len(ids)} jobs listed in pages of 100", f"{1000 * seconds / (len(ids) / 100):.1f} ms a page")
        long, last = milliseconds_of_page(server), milliseconds_of_page(server, "&cursor=" + ids[-11])
        show("A page of 10 jobs with 10 queued, first and last with all queued", f"{short:.2f}, {long:.2f}, {last:.2f} ms",
             f"ratio {max(long, last) / short:.2f}")
        worker = (server.data / "worker-token").read_text().strip()
        done = sorted(sum(together(work, [(server.port, worker, i) for i in range(HANDS)]), []))
        assert len(done) == len(ids)
        part = min(1000, len(done) // 2)
        first, last = (part - 1) / (done[part - 1] - done[0]), (part - 1) / (done[-1] - done[-part])
        show(f"Drained by {HANDS} workers: first {part}, last {part}, all", f"{first:.0f}, {last:.0f}, "
             f"{(len(done) - 1) / (done[-1] - done[0]):.0f}/s", f"ratio {last / first:.2f}")


# A large upload

def large_upload(folder, mib):
    os.environ["VACUFORM_UPLOAD_MIB"] = str(mib)
    from test_uploads import LargeScan, Uploads, peak_memory  # which reads it at import
    scan = LargeScan()
    with Server(folder, 0) as server:
        token, before = admin_of(server), peak_memory(server.program.pid)
        head = f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="scan"; filename="a.stl"\r\n\r\n'.encode()
        tail = f"\r\n--{BOUNDARY}--\r\n".encode()

        def body():
            yield head
            yield from scan.bytes(0, scan.size)
            yield tail
        started = time.monotonic()
        ask(server.port, token, "POST", "/api/v1/scans", body(), MULTIPART, {"Content-Length": str(len(head) + scan.size + len(tail))})
        seconds, peak = time.monotonic() - started, peak_memory(server.program.pid)
        show(f"A scan of {mib} MiB in one form ({mib / seconds:.0f} MiB/s): memory before, peak", f"{before >> 20}, {peak >> 20} MiB", "64 MiB")

        tus = {"Tus-Resumable": "1.0.0", "Upload-Length": str(scan.size)}
        place = "/api/v1/uploads/" + ask(server.port, token, "POST", "/api/v1/uploads", b"", headers=tus)["id"]
        pieces = Uploads()
        pieces.send(server, place, 0, scan.size // 2, scan)  # then closes the connection early
        assert pieces.send(server, place, pieces.offset(server, place), scan.size, scan) == 204
        show("The same in pieces, broken off half way and resumed: peak", f"{peak_memory(server.program.pid) >> 20} MiB", "64 MiB")


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--queued", type=int, default=10000)
    options.add_argument("--upload-mib", type=int, default=500)
    given = options.parse_args()
    show("", "", "wanted")
    with tempfile.TemporaryDirectory(prefix="vacuform-bench-") as folder:
        parts = [(answers_while_jobs_run,), (long_queue, given.queued), (large_upload, given.upload_mib)]
        for part, *words in parts:
            here = pathlib.Path(folder, part.__name__)
            here.mkdir()
            part(here, *words)
    if (BIN / "bench_store").exists():
        print("\nThe store alone (2000 cycles/s are wanted)", flush=True)
        subprocess.run([BIN / "bench_store"], check=True)


if __name__ == "__main__":
    main()
