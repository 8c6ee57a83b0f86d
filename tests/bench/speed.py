"""Prints how long forming, a whole print, a changed pattern, an array and a layout take, beside CGAL's ARAP, CGAL's exact geodesics and
Blender's cloth (where Blender is installed) in the same run, as Markdown tables: docs/develop/speed.md holds them.

    python3 tests/bench/speed.py BIN SHARED-DATA [--runs N] [--only WORD]

Each figure is the median of N runs (5 by default) of the real programs on an otherwise idle machine. `of ARAP` is the wall
time over the processor time of CGAL's ARAP parameterization of a dome of 80,000 triangles (bench_flattening), which is the
same on every machine. Peak memory is that of the process.
"""
import argparse
import json
import pathlib
import resource
import shutil
import statistics
import subprocess
import tempfile
import time

HEADS = {"newborn": "neonate-40w.stl", "adult": "adult-scalp-ascii.ply"}
PATTERN = pathlib.Path(__file__).resolve().parents[1] / "data" / "patterns" / "rings-19x40mm.svg"


def run(words):
    """Wall and processor seconds of a program."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    wall, after = time.monotonic() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        raise SystemExit(f"{words[0]}: {done.stderr or done.stdout}")
    return {"wall": wall, "cpu": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, "out": done.stdout}


def peak_mib(words):
    """Peak memory of a program, by GNU time's way: the largest child of a process that has only one."""
    code = "import resource, subprocess, sys; subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, check=True); " \
           "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss // 1024)"
    return int(run(["python3", "-c", code, *words])["out"])


def medians(runs, make):
    rows = [run(make(k)) for k in range(runs)]
    return statistics.median(row["wall"] for row in rows), statistics.median(row["cpu"] for row in rows)


def measures(arguments, folder):
    """Yields name, wall s, CPU s, peak MiB."""
    vacuform = arguments.bin / "vacuform"

    def forming(*options):
        return json.loads(run([arguments.bin / "bench_forming", "--json", *options, 200])["out"])

    for name, options in {"forming": [], "fast forming": ["--fast"]}.items() if arguments.only in "forming" else []:
        rows = [forming(*options) for _ in range(arguments.runs)]
        for at, head in enumerate(HEADS):
            yield f"{name}, {head}", statistics.median(row[at]["seconds"] for row in rows), None, round(rows[0][at]["peak_mib"])
    for head, scan in HEADS.items():
        out = folder / "out"
        base = [vacuform, "run", "--quiet", "--scan", arguments.data / "scans" / scan, "--pattern", PATTERN, "--out", out]
        if arguments.only in "print":
            yield f"print, {head}", *medians(arguments.runs, lambda _: base), peak_mib(base)
        if arguments.only in "kept head":
            kept = [*base, "--cache", folder / head]
            run(kept)
            turned = lambda k: [*kept, "--set", f"pattern.rotate_deg={5 * k + 5}"]
            yield f"another pattern on a kept head, {head}", *medians(arguments.runs, turned), peak_mib(turned(20))
    if arguments.only in "array":
        laid = [vacuform, "layout", "--scan", arguments.data / "scans" / HEADS["adult"], "--count", 16, "--out", folder / "sixteen"]
        run(laid)
        for build in "single", "two_faces", "bridges":
            words = [vacuform, "run", "--quiet", "--scan", arguments.data / "scans" / HEADS["adult"], "--pattern", folder / "sixteen" / "pattern.svg",
                     "--out", folder / "array", "--set", f"coils.build={build}", "--set", "coils.gaps=4"]
            yield f"print of sixteen loops, {build}", *medians(arguments.runs, lambda _: words), peak_mib(words)
    if arguments.only in "layout":
        laid = [vacuform, "layout", "--scan", arguments.data / "scans" / HEADS["newborn"], "--count", 32, "--diameter_mm",
                "fitted", "--out", folder / "layout", "--cache", folder / "newborn"]
        run(laid)
        yield "layout of 32 fitted loops on a kept head", *medians(arguments.runs, lambda _: laid), peak_mib(laid)


def peers(arguments, folder):
    """Yields name, our seconds, the peer's, both of one core or both of the wall."""
    for row in json.loads(run([arguments.bin / "bench_geodesics", "--json"])["out"]):
        yield f"{row['distances']} exact distances on {row['scan']}, CGAL's geodesics", row["seconds"], row["cgal_seconds"]
    if not shutil.which("blender"):
        return
    cells = 101
    ours = json.loads(run([arguments.bin / "bench_forming", "--json", cells - 1])["out"])
    run([arguments.bin / "vacuform", "inspect", "--scan", arguments.data / "scans" / HEADS["newborn"], "--out", folder / "mold"])
    cloth = run(["blender", "--background", "--factory-startup", "--python", pathlib.Path(__file__).with_name("blender_cloth.py"),
                 "--", folder / "mold" / "mold.stl", cells])["out"]
    theirs = json.loads(next(line for line in cloth.splitlines() if line.startswith("{")))
    yield f"the newborn under a sheet of {cells} x {cells}, Blender's cloth", ours[0]["seconds"], theirs["wall"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--only", default="", help="forming, print, kept head, array, layout or peers")
    arguments = parser.parse_args()
    flattening = json.loads(run([arguments.bin / "bench_flattening", "--json", "201"])["out"])
    arap = next(row["cpu_seconds"] for row in flattening if row["method"] == "cgal_arap" and row["surface"].startswith("dome"))
    print("| What | s | CPU s | MiB | of ARAP |\n|---|---|---|---|---|")
    print(f"| CGAL's ARAP, dome of 80,000 triangles | | {arap:.1f} | | 1 |", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, wall, cpu, mib in measures(arguments, pathlib.Path(folder)):
            print(f"| {name} | {wall:.2f} | {'' if cpu is None else f'{cpu:.2f}'} | {mib} | {wall / arap:.2f} |", flush=True)
        if arguments.only in "peers":
            print("\n| What, beside which peer | s | peer, s | peer over ours |\n|---|---|---|---|")
            for name, ours, theirs in peers(arguments, pathlib.Path(folder)):
                print(f"| {name} | {ours:.2f} | {theirs:.2f} | {theirs / ours:.1f} |", flush=True)


main()
