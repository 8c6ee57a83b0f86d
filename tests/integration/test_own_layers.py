"""A person's own layers: each is printed as the step that it is named after, and nothing else of the print changes."""
import json
import math
import unittest

import ezdxf
from shapely.geometry import LinearRing

import made_scans
from harness import Case, Server, curl, vacuform
from test_circuits import Nets

FAST = ["--set", "sheet.resolution_mm=4", "--set", "print.dpi=72"]
WIDTH = 3
A, B, RADIUS = (72, 61), (104, 52), 21  # centres and radius on a page of 170 x 120 mm, y down
CUT, REACH, PATCH = 4.2, 7.2, 3.1       # of A to both sides of a crossing, of its bridge, and of the patch on B, mm


def on(centre, angle):
    return centre[0] + RADIUS * math.cos(angle), centre[1] + RADIUS * math.sin(angle)


def crossings(one, other):
    """The angles at which the circle about `one` meets that about `other`."""
    apart = math.dist(one, other)
    middle, half = math.atan2(other[1] - one[1], other[0] - one[0]), math.acos(apart / 2 / RADIUS)
    return [middle - half, middle + half]


def arc(centre, begin, end):
    return [on(centre, begin + (end - begin) * i / 64) for i in range(65)]


# Open lines (points, width) of every step: A goes over B.
over, under = crossings(A, B), crossings(B, A)
CONDUCTOR = [(arc(A, over[0] + CUT / RADIUS, over[1] - CUT / RADIUS), WIDTH),
             (arc(A, over[1] + CUT / RADIUS, over[0] + 2 * math.pi - CUT / RADIUS), WIDTH)]
RING = arc(B, 0, 2 * math.pi)
PATCHES = [(arc(B, at - PATCH / RADIUS, at + PATCH / RADIUS), WIDTH + 2) for at in under]
BRIDGES = [(arc(A, at - REACH / RADIUS, at + REACH / RADIUS), WIDTH) for at in over]


def path(points, width, closed=False, colour="#000"):
    return (f'<path d="M{"L".join(f"{x:.4f} {y:.4f}" for x, y in points)}{"Z" if closed else ""}" fill="none" '
            f'stroke="{colour}" stroke-width="{width}"/>')


def group(name, body, attribute="inkscape:label"):
    return f'<g inkscape:groupmode="layer" {attribute}="{name}">{body}</g>'


def svg(*groups):
    return ('<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
            'width="170mm" height="120mm" viewBox="0 0 170 120">' + "".join(groups) + "</svg>")


def lines(some, colour="#000"):
    return "".join(path(points, width, colour=colour) for points, width in some)


def with_bridges(names=("conductor", "dielectric", "bridges"), attribute="inkscape:label", more=""):
    return svg(group(names[2], lines(BRIDGES, "#c00"), attribute), group(names[1], lines(PATCHES, "#88bbee"), attribute),
               group(names[0], lines(CONDUCTOR) + path(RING[:-1], WIDTH, True), attribute), more)


def dxf(layers):
    """Polylines with a width, in mm."""
    out = ["0", "SECTION", "2", "HEADER", "9", "$INSUNITS", "70", "4", "0", "ENDSEC", "0", "SECTION", "2", "ENTITIES"]
    for name, some in layers:
        for points, width in some:
            closed = math.dist(points[0], points[-1]) < 1e-6
            kept = points[:-1] if closed else points
            out += ["0", "LWPOLYLINE", "8", name, "90", str(len(kept)), "70", str(int(closed)), "43", str(width)]
            for x, y in kept:
                out += ["10", f"{x:.4f}", "20", f"{-y:.4f}"]
    return "\n".join(out + ["0", "ENDSEC", "0", "EOF", ""])


class OwnLayers(Case):
    def run_drawing(self, name, text, *settings, refused=False):
        pattern, out = self.folder / name, self.folder / f"out-{name}"
        pattern.write_text(text)
        words = [w for s in settings for w in ("--set", s)]
        done = vacuform("run", "--scan", made_scans.adult(), "--pattern", pattern, *FAST, "--cache", self.folder / "cache",
                        "--out", out, *words)
        if refused:
            self.assertNotEqual(done.returncode, 0)
            return done.stderr
        self.assertEqual(done.returncode, 0, done.stderr)
        return out, json.loads((out / "report.json").read_text())

    def check_two_loops(self, out, report, gaps=0):
        circuits = report["circuits"]
        self.assertEqual((circuits["loops"], circuits["nets"], circuits["shorts"], circuits["opens"]), (2, 2, [], []))
        nets = Nets(out).nets()
        self.assertTrue(all(len(net) == 1 for net in nets), nets)
        self.assertEqual(len(nets), 2 * max(1, gaps))
        self.assertEqual({len(coil["gaps"]) for coil in circuits["coils"]}, {gaps})

    def codes(self, report):
        return {w["code"] for w in report["warnings"]}

    def test_one_layer_of_the_same_drawing_is_a_short_circuit(self):
        _, report = self.run_drawing("one.svg", svg(lines(CONDUCTOR + PATCHES + BRIDGES) + path(RING[:-1], WIDTH, True)))
        self.assertEqual(report["circuits"]["nets"], 1)
        self.assertIn("coils-short", self.codes(report))

    def test_layers_by_their_labels_are_steps(self):
        out, report = self.run_drawing("labels.svg", with_bridges())
        self.check_two_loops(out, report)
        self.assertFalse(self.codes(report) & {"coils-short", "coils-open", "layer-unnamed", "layers-as-one"})
        # Whatever their colours: each is one ink.
        for name in "print", "print-dielectric", "print-bridges":
            fills = set(part.split('"')[0] for part in (out / f"{name}.svg").read_text().split('fill="')[1:])
            self.assertFalse(fills & {"#cc0000", "#88bbee", "#c00"}, fills)

    def test_groups_by_their_ids_are_steps(self):
        out, report = self.run_drawing("ids.svg", with_bridges(("print", "print-dielectric", "print-bridges"), "id"))
        self.check_two_loops(out, report)

    def test_gaps_are_made_beside_the_bridges(self):
        out, report = self.run_drawing("gaps.svg", with_bridges(("01 Silver", "02 Insulator", "03 Second silver_2_")), "coils.gaps=3")
        self.check_two_loops(out, report, 3)

    def test_layers_of_a_dxf_are_steps(self):
        out, report = self.run_drawing("layers.dxf", dxf([("BRIDGES", BRIDGES), ("DIELECTRIC", PATCHES),
                                                          ("CONDUCTOR", CONDUCTOR + [(RING, WIDTH)])]))
        self.check_two_loops(out, report)

    def test_two_faces(self):
        ring = lambda centre: path(arc(centre, 0, 2 * math.pi)[:-1], WIDTH, True)
        for name, face, inked in (("reverse", "inner", "outer"), ("inner", "inner", "outer"), ("outer", "outer", "inner")):
            with self.subTest(name=name):
                text = svg(group("conductor", ring(A)), group(f"conductor {name}", ring(B)))
                out, report = self.run_drawing(f"faces-{name}.svg", text, f"pattern.inked_face={inked}")
                self.check_two_loops(out, report)
                self.assertEqual([coil["face"] for coil in report["circuits"]["coils"]], [inked, face])
                self.assertTrue((out / "print-reverse.svg").exists())
                self.assertFalse((out / "print-bridges.svg").exists())

    def test_a_name_of_the_first_face_is_no_layer_of_another(self):
        ring = path(arc(B, 0, 2 * math.pi)[:-1], WIDTH, True)
        _, report = self.run_drawing("inner-on-inner.svg", svg(group("conductor inner", ring)), "pattern.inked_face=inner")
        self.assertEqual(report["circuits"]["coils"][0]["face"], "inner")

    def test_white_over_a_conductor_interrupts_it(self):
        white = "".join(path(arc(A, at - CUT / RADIUS, at + CUT / RADIUS), WIDTH + 1, colour="#fff") for at in over)
        text = svg(group("conductor", path(arc(A, 0, 2 * math.pi)[:-1], WIDTH, True) + white + path(RING[:-1], WIDTH, True)),
                   group("dielectric", lines(PATCHES)), group("bridges", lines(BRIDGES)))
        out, report = self.run_drawing("white.svg", text)
        circuits = report["circuits"]
        self.assertEqual((circuits["loops"], circuits["nets"], circuits["shorts"], circuits["opens"]), (2, 2, [], []))
        # A CAD program sees no white: of the two rings only the whole one has a hole.
        rings = [LinearRing([tuple(v.dxf.location)[:2] for v in p.vertices])
                 for p in ezdxf.readfile(out / "layers.dxf").modelspace() if p.dxf.layer == "print"]
        self.assertEqual(sum(not ring.is_ccw for ring in rings), 1)

    def test_a_pale_layer_is_full_ink(self):
        text = with_bridges().replace('inkscape:label="dielectric"', 'inkscape:label="dielectric" opacity="0.4"')
        out, report = self.run_drawing("pale.svg", text.replace('stroke="#000"', 'stroke="#000" stroke-opacity="0.5"'))
        self.check_two_loops(out, report)
        self.assertFalse(self.codes(report) & {"pattern-as-picture", "layers-as-one"})
        for name in "print", "print-dielectric", "print-bridges":
            self.assertNotIn("opacity", (out / f"{name}.svg").read_text())

    def test_a_copy_lies_on_the_layer_that_draws_it(self):
        ring = path(arc(A, 0, 2 * math.pi)[:-1], WIDTH, True)
        text = svg(f'<g id="outer" inkscape:groupmode="layer" inkscape:label="conductor outer">{ring}</g>',
                   group("conductor inner", f'<use href="#outer" x="{B[0] - A[0]}" y="{B[1] - A[1]}"/>'))
        out, report = self.run_drawing("clone.svg", text)
        self.check_two_loops(out, report)
        self.assertEqual({coil["face"] for coil in report["circuits"]["coils"]}, {"outer", "inner"})

    def test_bridges_without_a_dielectric_are_conductors(self):
        """As of a program for cutting, whose bridges hold what is cut."""
        rings = [path(arc(centre, 0, 2 * math.pi)[:-1], WIDTH, True) for centre in ((60, 60), (110, 58))]
        _, report = self.run_drawing("tabs.svg", svg(group("traces1", rings[0], "id"), group("bridges", rings[1], "id")))
        self.assertEqual((report["circuits"]["loops"], report["circuits"]["nets"]), (2, 2))
        self.assertFalse(self.codes(report) & {"layer-unnamed", "loop-on-bridges"})

    def test_a_loop_on_a_layer_of_bridges_is_said(self):
        ring = path(arc((110, 90), 0, 2 * math.pi)[:-1], 2, True)
        _, report = self.run_drawing("loop.svg", with_bridges(more=group("bridges", ring)))
        self.assertIn("loop-on-bridges", self.codes(report))

    def test_what_is_on_no_layer_is_said(self):
        _, report = self.run_drawing("guides.svg", with_bridges(more=group("Guides", path(arc((130, 95), 0, 6)[:-1], 0.5, True))))
        warning = next(w for w in report["warnings"] if w["code"] == "layer-unnamed")
        self.assertTrue(warning["figure"]["value"] == 1, warning)

    def test_a_picture_cannot_have_layers_and_says_so(self):
        _, report = self.run_drawing("text.svg", with_bridges(more='<text x="20" y="20">coil array 7</text>'))
        self.assertLessEqual({"pattern-as-picture", "layers-as-one"}, self.codes(report))

    def test_only_one_of_drawing_and_setting_parts_loops(self):
        said = self.run_drawing("build.svg", with_bridges(), "coils.build=bridges", refused=True)
        self.assertIn("coils.build", said)

    def test_the_service_keeps_the_names_of_layers_and_no_other(self):
        server = self.enterContext(Server(self.folder, workers=1))
        text = with_bridges(("Conductor", "dielectric", "Bridges"), more=group("Array for Mary Smith", ""))
        for name, drawing in (("service.svg", text), ("service.dxf", dxf([("BRIDGES", BRIDGES), ("DIELECTRIC", PATCHES),
                                                                          ("CONDUCTOR", CONDUCTOR + [(RING, WIDTH)])]))):
            with self.subTest(name=name):
                pattern = self.folder / name
                pattern.write_text(drawing)
                job = server.submit(made_scans.adult(), pattern, {"sheet": {"resolution_mm": 4}, "print": {"dpi": 72}})
                self.assertEqual(server.wait(job)["state"], "succeeded")
                report = curl(f"{server.api}/jobs/{job}/artifacts/report.json").json
                self.assertEqual((report["circuits"]["loops"], report["circuits"]["nets"]), (2, 2))
                kept = [file.read_bytes() for file in server.data.rglob("*") if file.is_file()]
                self.assertFalse(any(b"Smith" in content for content in kept))


if __name__ == "__main__":
    unittest.main()
