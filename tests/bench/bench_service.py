#!/usr/bin/env python3
"""The service over HTTP: status requests a second while two jobs run, and 10,000 queued jobs submitted, listed and paged.

    tests/bench/bench_service.py [--bin build/release/bin] [--queued 10000]

Uses wrk (Debian: wrk) for the requests; everything runs on this machine, client and workers beside the server.
"""
import argparse
import concurrent.futures
import http.client
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "integration"))


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--bin", default="build/release/bin")
    options.add_argument("--queued", type=int, default=10000)
    given = options.parse_args()
    os.environ["VACUFORM_BIN"] = str(pathlib.Path(given.bin).resolve())
    os.environ.setdefault("VACUFORM_SHARED_DATA", ".")
    import hostile
    from harness import Server

    def form(settings):
        parts = [("scan", "a.stl", hostile.stl(hostile.dome_triangles())), ("pattern", "a.svg", hostile.GOOD_SVG),
                 ("settings", "", json.dumps(settings).encode())]
        return b"".join(f'--b\r\nContent-Disposition: form-data; name="{name}"'.encode() +
                        (f'; filename="{file}"'.encode() if file else b"") + b"\r\n\r\n" + data + b"\r\n"
                        for name, file, data in parts) + b"--b--\r\n"

    def ask(server, method, path, body=None, bearer=None, kind="multipart/form-data; boundary=b"):
        connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
        headers = {"Authorization": "Bearer " + (bearer or token)}
        if body:
            headers["Content-Type"] = kind
        connection.request(method, path, body, headers)
        answer = connection.getresponse()
        body = answer.read()
        connection.close()
        assert answer.status < 300, (answer.status, body[:300])
        return json.loads(body)

    def wrk(server, path, connections):
        told = subprocess.run(["wrk", "-t2", f"-c{connections}", "-d8s", "--latency", "-H", "Authorization: Bearer " + token, server.url + path],
                              capture_output=True, text=True, check=True).stdout
        return float(re.search(r"Requests/sec:\s+([\d.]+)", told)[1]), re.search(r"99%\s+(\S+)", told)[1], "Non-2xx" in told

    with tempfile.TemporaryDirectory(prefix="vacuform-bench-") as folder:
        with Server(pathlib.Path(folder), 2) as server:
            token = server.token_file.read_text().strip()
            busy = form({"sheet": {"resolution_mm": 1}, "print": {"dpi": 600}})
            over = threading.Event()

            def keep_two_running():
                while not over.is_set():
                    states = [j["state"] for j in ask(server, "GET", "/api/v1/jobs?limit=20")["jobs"]]
                    if sum(s in ("queued", "running") for s in states) < 3:
                        ask(server, "POST", "/api/v1/jobs", busy)
                    over.wait(0.5)

            job = ask(server, "POST", "/api/v1/jobs", busy)["id"]
            keeper = threading.Thread(target=keep_two_running)
            keeper.start()
            time.sleep(2)
            print(f"{'while two jobs run':34}{'requests/s':>12}{'p99':>12}")
            for path in (f"/api/v1/jobs/{job}", "/api/v1/jobs?limit=20", "/healthz"):
                for connections in (8, 32):
                    rate, late, failed = wrk(server, path, connections)
                    shown = path.replace(job, "{id}")
                    print(f"{shown:28}{connections:>4} c {rate:>11.0f}{late:>12}{'  some failed' if failed else ''}", flush=True)
            over.set()
            keeper.join()
        pathlib.Path(folder, "many").mkdir()
        with Server(pathlib.Path(folder, "many"), 0) as server:
            token = server.token_file.read_text().strip()
            small = form({})
            # One owner may have a tenth of the queue.
            stations = [ask(server, "POST", "/api/v1/tokens", json.dumps({"owner": f"station-{i}", "scopes": ["submit", "read"]}).encode(),
                            kind="application/json")["token"] for i in range(10)]
            begun = time.monotonic()
            with concurrent.futures.ThreadPoolExecutor(8) as clients:
                list(clients.map(lambda i: ask(server, "POST", "/api/v1/jobs", small, stations[i % 10]), range(given.queued)))
            print(f"\n{given.queued} jobs submitted: {given.queued / (time.monotonic() - begun):.0f} a second")
            cursor, times, jobs = "", [], 0
            while True:
                begun = time.monotonic()
                page = ask(server, "GET", "/api/v1/jobs?limit=100" + cursor)
                times.append(time.monotonic() - begun)
                jobs += len(page["jobs"])
                if not page["next"]:
                    break
                cursor = "&cursor=" + page["next"]
            print(f"{jobs} jobs in {len(times)} pages: first {1000 * times[0]:.1f} ms, last {1000 * times[-1]:.1f} ms, slowest "
                  f"{1000 * max(times):.1f} ms")


if __name__ == "__main__":
    main()
