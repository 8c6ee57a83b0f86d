"""Prints how round, large, far apart and coupled coils come out of the real programs, a row a scan and a pattern.

    python3 tests/bench/coil_table.py BIN SHARED-DATA [--cache DIR] [--only WORD] [--set group.key=value ...]

Runs `vacuform run` and measures formed.ply and print.svg by the independent checker (`measure_coils`). A row counts the
coils, and the pairs of coils, that lie wholly on the head; `gain %` is by how much the squares of all distances' errors
fall at most when one centre is moved by half a millimetre, where they are above 2 mm rms: the surface forbids less. `--cache`
spares forming a head again; `--only` takes the rows with that word in their name. `--set coils.decouple=true` for decoupled
arrays.
"""
import argparse
import json
import math
import pathlib
import subprocess
import tempfile
import time

SCANS = {"neonate-40w.stl": [], "adult-scalp-ascii.ply": [], "adult-fsaverage-metres.obj": [],
         "bust-demosthenes.obj": ["scan.size_mm=450"]}
PATTERNS = ["rings-7x40mm.svg", "rings-19x40mm.svg", "rings-19x60mm.svg"]
COLUMNS = [("on head", 7), ("circ mean %", 11), ("worst %", 7), ("area mean %", 11), ("worst %", 7), ("rms mm", 6),
           ("gain %", 6), ("worst k", 7), ("size %", 6), ("run s", 5), ("check s", 7)]


def timed(words):
    begin = time.monotonic()
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{words[0]}: {done.stderr}")
    return done.stdout, time.monotonic() - begin


def row(arguments, scan, pattern, folder):
    given = [word for s in [*SCANS[scan], "print.dpi=72", *arguments.set] for word in ("--set", s)]
    kept = ["--cache", arguments.cache] if arguments.cache else []
    pattern = pathlib.Path(__file__).resolve().parents[1] / "data" / "patterns" / pattern
    _, run_s = timed([arguments.bin / "vacuform", "run", "--scan", arguments.data / "scans" / scan, "--pattern", pattern,
                      "--out", folder, *given, *kept])
    report = json.loads((folder / "report.json").read_text())
    on_head = {c["id"]: c for c in report["coils"] if c["with"] and c["with"]["on_head"]}
    check = [arguments.bin / "measure_coils", folder / "formed.ply", folder / "print.svg", pattern]
    checked, check_s = timed(check)
    checked = json.loads(checked)
    gain = "-"
    if checked["spacing_rms_mm"] > 2:
        gain = f"{100 * json.loads(timed([*check, '--spacing'])[0])['spacing_gain']:.2f}"
    coils = [c for c in checked["coils"] if c["id"] in on_head]
    pairs = [p for p in checked["pairs"] if all(name in on_head for name in p["coils"])]
    if not coils:
        return [0] + ["-"] * 8 + [f"{run_s:.1f}", f"{check_s:.1f}"]
    circularity = [100 * c["circularity"] for c in coils]
    # The checker compares with the drawing, decoupling with the size that it gave the coil.
    area = [100 * abs((1 + c["area_error"]) / on_head[c["id"]]["size"] ** 2 - 1) for c in coils]
    size = max(100 * abs(on_head[c["id"]]["size"] - 1) for c in coils)
    squares = [(p["distance_mm"] - p["drawn_distance_mm"]) ** 2 for p in pairs]
    k = max((abs(p["k"]) for p in pairs), default=0)
    mean = lambda values: sum(values) / max(1, len(values))
    return [len(coils), f"{mean(circularity):.2f}", f"{max(circularity):.2f}", f"{mean(area):.2f}", f"{max(area):.2f}",
            f"{math.sqrt(mean(squares)):.2f}", gain, f"{k:.4f}", f"{size:.1f}", f"{run_s:.1f}", f"{check_s:.1f}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("--cache")
    parser.add_argument("--only", default="")
    parser.add_argument("--set", action="append", default=[])
    arguments = parser.parse_args()
    print(f"{'':38}", *(f"{name:>{width}}" for name, width in COLUMNS))
    for scan in SCANS:
        for pattern in PATTERNS:
            name = f"{pathlib.Path(scan).stem}, {pathlib.Path(pattern).stem}"
            if arguments.only not in name:
                continue
            with tempfile.TemporaryDirectory() as folder:
                values = row(arguments, scan, pattern, pathlib.Path(folder))
            print(f"{name:38}", *(f"{v:>{width}}" for v, (_, width) in zip(values, COLUMNS)), flush=True)


if __name__ == "__main__":
    main()
