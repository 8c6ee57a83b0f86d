#!/usr/bin/env python3
"""Runs `vacuform run` on made-up scans and holds every result against the truth and against a second program.

    VACUFORM_BIN=build/tests/bin tests/integration/generated_scans.py --count 200 [--seed S] [--first N] [--grid MM]
        [--odd-units] [--inspect]

`--odd-units` writes the files in rare units; `--inspect` stops at the mold, without forming. The first proposal of each
refusal is followed, and answers the question for the unit as a person does who knows the head: with the proposal of the
right unit, otherwise with the measured longest side.

A scan fails when the program crashes or takes too long, when a refusal's proposals do not lead to a mold within three
steps, when check_sheet finds the sheet torn, folded, penetrated or off the mold at a place that no warning marks, or when
the unit, the up axis, crumbs, outliers or a mirror image were silently taken wrong. Prints a row a scan and a total.

With --poses, heads of known pose are inspected: without a crown, with floating parts, pits or noise, upside down, tilted.
"""
import argparse
import collections
import concurrent.futures
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import meshes
import scan_files
import scan_generator

PATTERN = """<svg xmlns="http://www.w3.org/2000/svg" width="30mm" height="30mm" viewBox="0 0 30 30">
<g id="a"><circle cx="9" cy="15" r="6" fill="none" stroke="#000" stroke-width="0.6"/></g>
<g id="b"><circle cx="21" cy="15" r="6" fill="none" stroke="#000" stroke-width="0.6"/></g></svg>"""
MOST_STEPS = 3  # refusals in a row, each with a further proposal


def assignments(proposal):
    """The settings of a proposal, for --set."""
    return [f"{group}.{key}={value}" for group, values in proposal["set"].items() for key, value in values.items()]


def answer(scan, problem):
    """What is done about a refusal: a list of settings, or nothing."""
    offered = [assignments(proposal) for proposal in problem["proposals"]]
    if problem["code"] == "ambiguous-units":
        return [f"scan.units={scan.unit}"] if [f"scan.units={scan.unit}"] in offered else [f"scan.size_mm={scan.longest_side():.2f}"]
    return offered[0] if offered else []


class Result:
    """What became of one scan. `failures` is empty where everything is right."""

    def __init__(self, scan):
        self.scan, self.settings, self.refusals, self.exit_codes = scan, [], [], []
        self.failures, self.codes, self.marked = [], [], []
        self.problem = None  # of the last refusal

    @property
    def ended(self):
        return "succeeded" if self.exit_codes[-1:] == [0] else "refused" if self.exit_codes[-1:] == [2] else "broken"

    def row(self):
        s = self.scan
        return (f"{s.name}  {s.kind:8} {s.unit:4} {s.up}  {s.format:14} exit {','.join(map(str, self.exit_codes)):5} "
                f"{'RIGHT' if not self.failures else 'WRONG'}  [{s.damage()}] {' '.join(self.settings)}"
                f" warnings: {' '.join(self.codes) or '-'}" + (f" marked: {' '.join(self.marked)}" if self.marked else "")
                + "".join("\n    " + f for f in self.failures) + "".join("\n    refusal: " + r for r in self.refusals))


class Runner:
    def __init__(self, binaries, folder, grid, patience, units=tuple(scan_generator.UNITS), forms=True):
        self.binaries, self.folder, self.grid, self.patience = pathlib.Path(binaries), pathlib.Path(folder), grid, patience
        self.units, self.forms = units, forms
        self.pattern = self.folder / "pattern.svg"
        self.pattern.write_text(PATTERN)

    def total(self, results):
        return total(results)

    def run(self, seed, number):
        scan = scan_generator.Scan(seed, number, self.units)
        result = Result(scan)
        file, out = self.folder / f"{scan.name}.{scan.extension}", self.folder / scan.name
        file.write_bytes(scan.data)
        try:
            if self.lead_to_success(result, file, out):
                self.judge(result, out)
        except subprocess.TimeoutExpired as late:
            result.exit_codes.append(-1)
            result.failures.append(f"not done after {late.timeout} s")
        return result

    def lead_to_success(self, result, file, out):
        """Answers each refusal by one of its proposals; whether that ends in success."""
        while True:
            words = [w for setting in result.settings for w in ("--set", setting)]
            command = ["run", "--pattern", self.pattern, "--set", f"sheet.resolution_mm={self.grid}", "--set", "print.dpi=72"] \
                if self.forms else ["inspect"]
            done = subprocess.run([self.binaries / "vacuform", *command, "--scan", file, "--out", out, "--progress", "json", *words],
                                  capture_output=True, text=True, timeout=self.patience)
            result.exit_codes.append(done.returncode)
            if done.returncode == 0:
                return True
            message = done.stderr.strip()
            result.refusals.append(message.replace(str(self.folder) + "/", ""))
            if done.returncode != 2:
                result.failures.append(f"exit {done.returncode}: {message[-500:]}")
                return False
            problem = json.loads(done.stdout.splitlines()[-1])["problem"]
            chosen = answer(result.scan, problem)
            if any(" ".join("--set " + setting for setting in assignments(p)) not in problem["fix"] for p in problem["proposals"]):
                result.failures.append("the fix does not name each proposal")
            if not chosen:
                result.failures.append("a refusal without a proposal")
                return False
            if set(chosen) <= set(result.settings):
                result.failures.append("a refusal proposes what was done already")
                return False
            if len(result.refusals) > MOST_STEPS:
                result.failures.append("the proposals do not lead to a mold")
                return False
            names = {setting.split("=")[0] for setting in chosen}
            result.settings = [s for s in result.settings if s.split("=")[0] not in names] + chosen

    def judge(self, result, out):
        report = json.loads((out / ("report.json" if self.forms else "findings.json")).read_text())
        result.codes = [w["code"] for w in report["warnings"]]
        mold = meshes.read_stl((out / "mold.stl").read_bytes())
        result.failures += wrong_about(result.scan, report, mold, result.settings)
        if not self.forms:
            return
        done = subprocess.run([self.binaries / "check_sheet", out], capture_output=True, text=True, timeout=self.patience)
        if done.returncode not in (0, 1):
            result.failures.append(f"check_sheet: {done.stderr.strip() or done.returncode}")
            return
        for place in json.loads(done.stdout)["places"]:
            if place["marked_by"]:
                result.marked.append(place["kind"].replace(" ", "-"))
                continue
            at = ", ".join(f"{x:.1f}" for x in place["place_mm"])
            result.failures.append(f"{place['kind']}: {place['what']}, {place['size']:.2f} at ({at}), {place['samples']} samples")


def wrong_about(scan, report, mold, settings):
    """What the report does not know of the scan, and does not warn of."""
    found, codes = report["scan"], {w["code"] for w in report["warnings"]}
    given = dict(setting.split("=") for setting in settings)
    wrong = []
    if found["unit_guessed"] and found["unit"] != scan.unit and "units-guessed" not in codes:
        wrong.append(f"the unit is {scan.unit}, taken silently to be {found['unit']}")
    if found["up"] != scan.up and "scan.up" not in given and "up-guessed" not in codes:
        wrong.append(f"up is {scan.up}, taken silently to be {found['up']}")
    if found["outliers_dropped"] != scan.outliers or ("outliers" in codes) != (scan.outliers > 0):
        wrong.append(f"{scan.outliers} outliers, {found['outliers_dropped']} dropped")
    if (scan.reversed or scan.mirrored) and "inside-out" not in codes:
        wrong.append("the triangles face inwards, and no warning says so")
    if not scan.missing and found["components_dropped"] < scan.crumbs:
        wrong.append(f"{scan.crumbs} crumbs, {found['components_dropped']} pieces dropped")
    if found["up"] == scan.up:
        scale = scan_generator.ALL_UNITS[found["unit"]] / scan_generator.ALL_UNITS[scan.unit] if found["unit"] else \
            float(given["scan.size_mm"]) / scan.longest_side()
        wrong += wrong_shape(scan, found, mold, scale)
    return wrong


def wrong_shape(scan, found, mold, scale):
    """Compares the mold with the part of the undamaged body above the cut."""
    low, high = scan.box()
    slack = (0.02 + (0.03 if scan.holes or scan.missing else 0)) * scan.size + 5 * scan.noise + 0.5 / scale
    trim = found["trim_mm"] / scale
    rows = []
    for name, sign in ("most", 1), ("least", -1):
        sides = [-math.inf, -math.inf]
        if trim - sign * slack < high[2]:
            below, above = scan.box(above=trim - sign * slack)
            sides = sorted(above[k] - below[k] for k in (0, 1))
        rows.append([scale * (s + sign * slack) for s in (*sides, high[2] - low[2] - trim)])
    points = [p for t in mold for p in t]
    size = [max(p[k] for p in points) - min(p[k] for p in points) for k in range(3)]
    size = [*sorted(size[:2]), size[2]]
    if found["crumbs_dropped"]:  # the cut left parts standing beside the mold
        rows[1] = [-math.inf, -math.inf, rows[1][2]]
    if all(least <= s <= most for most, least, s in zip(*rows, size)):
        return []
    text = " x ".join(f"{least:.0f}..{most:.0f}" for most, least in zip(*rows))
    return [f"the mold is {' x '.join(f'{s:.0f}' for s in size)} mm, not {text}"]


class PoseRunner(Runner):
    """Inspects heads whose pose is hard to tell. A pose is right, or the scan stage asks: a warning or a refusal, and one
    of its proposals leads to the right pose in one step."""

    MOST_TILT = 20  # degrees, beyond which a tilt must be told

    def total(self, results):
        counts = collections.Counter((r.ended, r.off_deg <= self.MOST_TILT) for r in results)
        return (f"{len(results)} heads: " + ", ".join(f"{n} {ended}, {'upright' if right else 'not upright'}"
                                                      for (ended, right), n in sorted(counts.items()))
                + f"; {sum(bool(r.settings) for r in results)} led by a proposal; {sum(bool(r.failures) for r in results)} wrong")

    def run(self, seed, number):
        scan = scan_generator.PosedScan(seed, number)
        result = PoseResult(scan)
        file = self.folder / f"{scan.name}.{scan.extension}"
        file.write_bytes(scan.data)
        findings = self.inspect(result, file, scan.name, [])
        while findings is None and not result.failures and len(result.refusals) <= MOST_STEPS:
            offered = [assignments(proposal) for proposal in result.problem["proposals"]]
            if not offered:
                result.failures.append("a refusal without a proposal")
                return result
            result.settings += offered[0]
            findings = self.inspect(result, file, scan.name, result.settings)
        if findings is None:
            result.failures.append("the proposals do not lead to a mold")
            return result
        result.codes = [w["code"] for w in findings["warnings"]]
        asking = [w for w in findings["warnings"] if w["code"] in ("up-guessed", "tilted")]
        result.asked = bool(asking)
        self.judge_trim(result, findings, scan)
        result.off_deg = off_upright(scan, {"scan.up": findings["scan"]["up"]})
        fixes = [assignments(proposal) for w in asking for proposal in w["proposals"]]
        right = [words for words in fixes if off_upright(scan, dict(word.split("=") for word in words)) < 12]
        if result.off_deg > self.MOST_TILT:
            if not result.asked:
                result.failures.append(f"up is {scan.up}, {result.off_deg:.0f} degrees off in silence")
            elif not right and scan.neck != "round":  # without a foot, nothing says how far a head nods
                result.failures.append(f"no proposal leads to the right pose: {fixes}")
        for words in right[:1]:
            result.settings = words
            if self.inspect(result, file, scan.name + "-led", words) is None:
                result.failures.append("what a warning proposes is refused")
        return result

    def inspect(self, result, file, name, settings):
        """The findings, or nothing if the scan is refused."""
        words = [w for setting in ["scan.units=mm", *settings] for w in ("--set", setting)]
        done = subprocess.run([self.binaries / "vacuform", "inspect", file, "--out", self.folder / name, "--progress", "json", *words],
                              capture_output=True, text=True, timeout=self.patience)
        result.exit_codes.append(done.returncode)
        if done.returncode == 2:
            result.refusals.append(done.stderr.strip().replace(str(self.folder) + "/", ""))
            result.problem = json.loads(done.stdout.splitlines()[-1])["problem"]
            return None
        if done.returncode != 0:
            result.failures.append(f"exit {done.returncode}: {done.stderr[-300:]}")
            return None
        return json.loads((self.folder / name / "findings.json").read_text())

    def judge_trim(self, result, findings, scan):
        """The automatic trim of a noisy scan is that of the clean body, within 3 mm."""
        if not scan.noise or findings["scan"]["up"] != scan.up:
            return
        clean = self.folder / f"{scan.name}-clean.stl"
        clean.write_bytes(scan_files.stl(scan.clean))
        there = self.inspect(PoseResult(scan), clean, scan.name + "-clean", ["scan.up=+z"])
        if there is None:
            return
        result.trims = findings["scan"]["trim_mm"] + scan.lowest, there["scan"]["trim_mm"]
        if abs(result.trims[0] - result.trims[1]) > 3:
            result.failures.append(f"the trim is {result.trims[0]:.1f} mm, without noise {result.trims[1]:.1f} mm")


class PoseResult(Result):
    def __init__(self, scan):
        super().__init__(scan)
        self.asked, self.off_deg, self.trims = False, 0.0, None

    @property
    def ended(self):
        return "asked" if self.asked else "taken"

    def row(self):
        s = self.scan
        return (f"{s.name}  {s.pose:14} {s.neck:5} up {s.up} + {s.turn_deg:2.0f}  off {self.off_deg:3.0f}  {self.ended:6}"
                f"{'RIGHT' if not self.failures else 'WRONG'}  {' '.join(self.settings)} warnings: {' '.join(self.codes) or '-'}"
                + (f" trim {self.trims[0]:.1f} of {self.trims[1]:.1f}" if self.trims else "")
                + "".join("\n    " + f for f in self.failures) + "".join("\n    refusal: " + r for r in self.refusals))


def off_upright(scan, given):
    """Degrees between the ceiling and the crown, under the given settings."""
    up = given.get("scan.up", scan.up)
    v = [sum(scan.up_vector[k] * scan_generator.AXES[up][j][k] for k in range(3)) for j in range(3)]
    v, = scan_generator.turned([v], (1, 0, 0), float(given.get("scan.roll_deg", 0)))
    v, = scan_generator.turned([v], (0, 1, 0), float(given.get("scan.pitch_deg", 0)))
    return math.degrees(math.acos(max(-1.0, min(1.0, v[2]))))


def run_all(runner, seed, numbers, workers=2, report=print):
    """The results of all scans, in order; `report` is given each row."""
    results = []
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        for result in pool.map(lambda number: runner.run(seed, number), numbers):
            report(result.row())
            results.append(result)
    report(runner.total(results))
    return results


def total(results):
    ended = collections.Counter(r.ended for r in results)
    led = [r for r in results if r.refusals]
    return (f"{len(results)} scans: " + ", ".join(f"{n} {name}" for name, n in sorted(ended.items()))
            + f"; {len(led)} refused at first, proposals worked for {sum(r.ended == 'succeeded' for r in led)}"
            + f"; {sum(bool(r.marked) for r in results)} with places that a warning marks"
            + f"; {sum(not r.failures for r in results)} right, {sum(bool(r.failures) for r in results)} wrong")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", default="scans")
    parser.add_argument("--grid", type=float, default=3.0, help="sheet.resolution_mm")
    parser.add_argument("--workers", type=int, choices=(1, 2), default=1)
    parser.add_argument("--patience", type=float, default=300, help="seconds for each run")
    parser.add_argument("--poses", action="store_true", help="heads whose pose is hard to tell, inspected alone")
    parser.add_argument("--odd-units", action="store_true", help="files in micrometres, feet and other rare units")
    parser.add_argument("--inspect", action="store_true", help="stop at the mold")
    parser.add_argument("--keep", help="a folder for scans and results")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(options.keep or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        units = tuple(scan_generator.ODD_UNITS if options.odd_units else scan_generator.UNITS)
        kind = PoseRunner if options.poses else Runner
        runner = kind(os.environ["VACUFORM_BIN"], folder, options.grid, options.patience, units, not options.inspect)
        results = run_all(runner, options.seed, range(options.first, options.first + options.count), options.workers,
                          lambda text: print(text, flush=True))
    return 1 if any(r.failures for r in results) else 0


if __name__ == "__main__":
    sys.exit(main())
