"""Coils on a newborn's head: the bounds of the product, by a checker that reads only what a lab gets."""
import json
import math
import re
import subprocess
import unittest
from html.parser import HTMLParser

import made_scans
from harness import BIN, PATTERNS, Case, vacuform

PATTERN = PATTERNS / "rings-7x40mm.svg"


class Page(HTMLParser):
    """What a self-contained page must and must not have."""

    def __init__(self, text):
        super().__init__()
        self.headings, self.links, self.tables, self.captions, self.images, self.open = [], [], 0, 0, [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        of = dict(attributes)
        if tag not in ("meta", "img", "br", "rect", "line", "path"):
            self.open.append(tag)
        if re.fullmatch("h[1-6]", tag):
            self.headings.append(int(tag[1]))
        self.tables += tag == "table"
        self.captions += tag == "caption"
        if tag == "img":
            self.images.append(of)
        self.links += [of[name] for name in ("href", "src", "action", "data") if name in of]
        assert tag not in ("script", "link", "iframe", "object"), tag
        assert not any(name.startswith("on") for name in of), attributes

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if self.open and self.open[-1] == tag:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag


def checked(folder, pattern):
    """The figures of the independent checker."""
    done = subprocess.run([BIN / "measure_coils", folder / "formed.ply", folder / "print.svg", pattern, "--couplings"],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


class CoilCase(Case):
    scan = staticmethod(made_scans.newborn)

    def check_couplings(self, report, measured):
        """The matrix of every two coils is that of the checker, and the strongest pairs are named."""
        ids, k = report["couplings"]["coils"], report["couplings"]["k"]
        self.assertEqual(len(measured["couplings"]), len(ids) * (len(ids) - 1) // 2)
        found = {}
        for pair in measured["couplings"]:
            a, b = (ids.index(name) for name in pair["coils"])
            self.assertAlmostEqual(k[a][b], pair["k"], delta=0.003)
            self.assertEqual(k[a][b], k[b][a])
            found[frozenset(pair["coils"])] = k[a][b]
        summary = report["figures"]["with"]["coils"]
        strongest, neighbours = summary["strongest_pair"], summary["strongest_neighbours"]
        self.assertEqual(abs(strongest["k"]), max(abs(value) for value in found.values()))
        self.assertEqual(found[frozenset(strongest["coils"])], strongest["k"])
        self.assertEqual(abs(neighbours["k"]), summary["worst_k"])
        self.assertEqual(abs(neighbours["k"]), max(abs(p["with"]["k"]) for p in report["pairs"]))


class Coils(CoilCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.out = cls.folder / "out"
        done = vacuform("run", "--scan", cls.scan(), "--pattern", PATTERN, "--out", cls.out,
                        "--set", "sheet.resolution_mm=3", "--set", "print.dpi=150")
        assert done.returncode == 0, done.stderr
        cls.report = json.loads((cls.out / "report.json").read_text())
        cls.measured = checked(cls.out, PATTERN)

    def test_coils_come_out_as_drawn(self):
        m = self.measured
        self.assertEqual(m["missing"], [])
        self.assertEqual(len(m["coils"]), 7)
        self.assertEqual(len(m["pairs"]), 12)
        self.assertLess(m["mean_circularity"], 0.008)
        self.assertLess(m["worst_circularity"], 0.016)
        self.assertLess(m["mean_area_error"], 0.005)
        self.assertLess(m["worst_area_error"], 0.04)
        self.assertLess(m["spacing_rms_mm"], 2)
        for coil in m["coils"]:
            self.assertAlmostEqual(coil["drawn_diameter_mm"], 40, delta=0.001)

    def test_the_report_says_the_same(self):
        coils = {c["id"]: c for c in self.report["coils"]}
        self.assertEqual([c["id"] for c in self.measured["coils"]], list(coils))
        for measured in self.measured["coils"]:
            said = coils[measured["id"]]["with"]
            for key in ("diameter_mm", "area_mm2"):
                self.assertAlmostEqual(said[key] / measured[key], 1, delta=0.001, msg=key)
            # Of the worst millimetre: it begins elsewhere, and neighbouring triangles of a bent sheet differ by a hundredth.
            self.assertAlmostEqual(said["worst_stretch"] / measured["worst_stretch"], 1, delta=0.01)
            for key in ("circularity", "area_error"):
                self.assertAlmostEqual(said[key], measured[key], delta=0.001, msg=key)
            self.assertAlmostEqual(said["inductance_nh"] / measured["inductance_nh"], 1, delta=0.01)
        pairs = {frozenset(p["coils"]): p for p in self.report["pairs"]}
        for measured in self.measured["pairs"]:
            said = pairs[frozenset(measured["coils"])]
            self.assertAlmostEqual(said["drawn_distance_mm"], measured["drawn_distance_mm"], delta=0.001)
            self.assertAlmostEqual(said["with"]["distance_mm"] / measured["distance_mm"], 1, delta=0.001)
            self.assertAlmostEqual(said["with"]["k"], measured["k"], delta=0.003)
        self.check_couplings(self.report, self.measured)
        summary = self.report["figures"]["with"]["coils"]
        for key in ("mean_circularity", "worst_circularity", "mean_area_error", "worst_area_error"):
            self.assertAlmostEqual(summary[key], self.measured[key], delta=0.001, msg=key)

    def test_printed_as_drawn_they_come_out_far_worse(self):
        with_, without = (self.report["figures"][way]["coils"] for way in ("with", "without"))
        self.assertGreater(without["mean_circularity"], 5 * with_["mean_circularity"])
        self.assertGreater(without["mean_area_error"], 10 * with_["mean_area_error"])
        # Around the coils nothing is as distorted as on the chart, where lines outside of coils would lie.
        figures = self.report["figures"]
        for figure in ("shape", "area"):
            around, chart = figures["with"]["elements"][figure], figures["with"][figure]
            self.assertLess(around["mean"] - 1, 0.7 * (chart["mean"] - 1), figure)
            self.assertLess(around["mean"] - 1, 0.7 * (figures["without"]["elements"][figure]["mean"] - 1), figure)

    def test_stretched_traces_are_marked(self):
        ink = self.report["ink"]
        self.assertEqual(ink["traces"], 7)
        self.assertGreaterEqual(len(ink["stretched"]), 1)
        for trace in ink["stretched"]:
            self.assertGreater(trace["worst_stretch"], 1 + ink["stretch_limit"])
            self.assertLessEqual(trace["stretched_mm"], trace["length_mm"])
            # Around 20 mm of a dome: shorter than in the plane.
            self.assertLess(trace["length_mm"], 40 * math.pi)
            self.assertGreater(trace["length_mm"], 0.95 * 40 * math.pi)
        warnings = [w for w in self.report["warnings"] if w["code"] == "trace-stretched"]
        self.assertEqual(len(warnings), 1)

    def test_the_page_needs_nothing_else_and_says_the_same(self):
        text = (self.out / "report.html").read_text()
        self.assertLess(len(text), 3_000_000)
        page = Page(text)
        self.assertEqual(page.open, [])
        self.assertEqual(page.headings[0], 1)
        self.assertEqual(page.headings.count(1), 1)
        self.assertTrue(all(b - a <= 1 for a, b in zip(page.headings, page.headings[1:])))
        self.assertEqual(page.tables, page.captions)
        for link in page.links:
            self.assertTrue(link.startswith("data:image/png;base64,"), link[:80])
        self.assertNotIn("url(", text)
        self.assertGreaterEqual(len(page.images), 7)
        for image in page.images:
            self.assertTrue(image["alt"])
        for coil in self.report["coils"]:
            self.assertIn(f'<th scope="row">{coil["id"]}</th>', text)
            self.assertIn(f'{coil["with"]["diameter_mm"]:.2f}', text)
        self.assertIn(self.report["label"], text)
        self.assertIn(self.report["sha256"]["scan"], text)


class Decoupled(CoilCase):
    strongest = r"-0\.0[1-6]\d+"  # coupling of any two coils of an array that is laid out for the scan

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.given = ("--scan", cls.scan(), "--set", "sheet.resolution_mm=4", "--set", "print.dpi=72")

    def run_decoupled(self, pattern, *words):
        out = self.folder / "out"
        self.done = done = vacuform("run", *self.given, "--pattern", pattern, "--out", out, "--set", "coils.decouple=true", *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads((out / "report.json").read_text()), checked(out, pattern)

    def test_a_drawn_array(self):
        report, measured = self.run_decoupled(PATTERN)
        self.assertGreater(max(abs(p["k_before_decoupling"]) for p in report["pairs"]), 0.01)
        self.assertLess(max(abs(p["k"]) for p in measured["pairs"]), 0.005)
        for coil in report["coils"]:
            self.assertLessEqual(abs(coil["size"] - 1), 0.05 + 1e-9)
            self.assertTrue(coil["with"]["on_head"])
        # Neighbours are decoupled. Circles of the rim with one between them are not: they do not overlap.
        self.check_couplings(report, measured)
        summary = report["figures"]["with"]["coils"]
        self.assertLess(abs(summary["strongest_neighbours"]["k"]), 0.005)
        self.assertLess(summary["strongest_pair"]["k"], -0.01)
        self.assertGreater(summary["strongest_pair"]["k"], -0.03)
        self.assertNotIn(frozenset(summary["strongest_pair"]["coils"]), [frozenset(p["coils"]) for p in report["pairs"]])
        self.assertNotIn("coils-coupled", [w["code"] for w in report["warnings"]])
        text = " and ".join(summary["strongest_pair"]["coils"])
        self.assertIn(f"Strongest of any two coils: {text}, k = {summary['strongest_pair']['k']:.4f}", self.done.stdout)
        self.assertIn("they cannot be cancelled at the same time", self.done.stdout)

    def test_neighbours_that_were_not_decoupled_are_a_warning(self):
        out = self.folder / "coupled"
        done = vacuform("run", *self.given, "--pattern", PATTERN, "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        report = json.loads((out / "report.json").read_text())
        strong = [p for p in report["pairs"] if abs(p["with"]["k"]) >= 0.01]
        self.assertTrue(strong)
        warning, = [w for w in report["warnings"] if w["code"] == "coils-coupled"]
        self.assertTrue(warning["what"].startswith(f"{len(strong)} of {len(report['pairs'])} pairs of neighbours"), warning["what"])
        self.assertEqual(len(warning["marks"]), len(strong))
        self.assertIn("coils.decouple=true", warning["fix"])

    def test_coils_that_keep_their_diameter(self):
        out = self.folder / "diameter"
        done = vacuform("run", *self.given, "--pattern", PATTERN, "--out", out, "--set", "coils.keep=diameter")
        self.assertEqual(done.returncode, 0, done.stderr)
        report, measured = json.loads((out / "report.json").read_text()), checked(out, PATTERN)
        self.assertEqual(report["figures"]["with"]["coils"]["keep"], "diameter")
        self.assertIn("coils.keep=diameter", (out / "report.html").read_text())
        for coil in measured["coils"]:
            self.assertAlmostEqual(coil["diameter_mm"], 40, delta=0.1)
            self.assertLess(coil["area_error"], 0.005)
        self.assertLess(sum(c["area_error"] for c in measured["coils"]) / 7, -0.002)

    def test_an_array_laid_out_from_the_scan_alone(self):
        out = self.folder / "array"
        done = vacuform("layout", *self.given, "--count", "9", "--diameter_mm", "40", "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("9 coils, 40.0 mm", done.stdout)
        self.assertRegex(done.stdout, r"\nstrongest coupling of neighbours: coil-\d and coil-\d, k = -?0\.00\d+\n"
                                      rf"strongest coupling of any two coils: coil-\d and coil-\d, k = {self.strongest}\n\Z")
        layout = json.loads((out / "layout.json").read_text())
        self.assertEqual((layout["count"], layout["diameter_mm"], layout["off_head"]), (9, 40, 0))
        self.assertEqual(layout["settings"]["layout"], {"count": 9, "diameter_mm": 40, "region": "dome", "overlap": 0})
        told = re.findall(r"(coil-\d) and (coil-\d), k = (.+)", done.stdout)
        self.assertEqual(told, [(p["a"], p["b"], f"{p['k']:.4f}") for p in (layout["strongest_neighbours"], layout["strongest"])])
        report, measured = self.run_decoupled(out / "pattern.svg")
        self.assertEqual([c["id"] for c in report["coils"]], [f"coil-{i}" for i in range(1, 10)])
        self.assertTrue(all(c["with"]["on_head"] for c in report["coils"]))
        self.assertGreaterEqual(len(measured["pairs"]), 12)
        self.assertLess(max(abs(p["k"]) for p in measured["pairs"]), 0.005)
        self.assertNotIn("coils-moved", [w["code"] for w in report["warnings"]])

    def test_a_fitted_array_lies_on_the_head_and_no_loops_overlap_too_far(self):
        for count in "7", "12":
            done = vacuform("layout", *self.given, "--count", count, "--diameter_mm", "fitted", "--out", self.folder / "fitted")
            self.assertEqual(done.returncode, 0, done.stderr)
            layout = json.loads((self.folder / "fitted" / "layout.json").read_text())
            self.assertEqual(layout["off_head"], 0, count)
            self.assertLess(abs(layout["strongest_neighbours"]["k"]), 0.01, count)
            self.assertLess(layout["strongest"]["k"], 0.01, count)  # what overlaps too far couples by a positive k

    def test_a_layout_of_too_few_or_too_many_is_refused(self):
        for count in "3", "65":
            done = vacuform("layout", *self.given, "--count", count, "--out", self.folder / "none")
            self.assertEqual(done.returncode, 2)
            self.assertIn("--count", done.stderr)
        self.assertFalse((self.folder / "none").exists())

    def test_a_print_refuses_the_settings_of_a_layout(self):
        done = vacuform("run", *self.given, "--pattern", PATTERN, "--set", "layout.count=9", "--out", self.folder / "none")
        self.assertEqual(done.returncode, 2)
        self.assertIn("layout.count", done.stderr)
        self.assertFalse((self.folder / "none").exists())


if __name__ == "__main__":
    unittest.main()
