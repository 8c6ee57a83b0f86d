"""A person's own layers: each is printed as the step that it is named after, and nothing else of the print changes."""
import json
import math
import re
import unittest
import xml.etree.ElementTree as ElementTree
import zipfile

import ezdxf
from shapely.geometry import LinearRing, LineString, Polygon
from shapely.ops import unary_union

import made_scans
from harness import Case, Server, curl, vacuform
from test_circuits import Nets
from test_random_drawings import SVG, points_of

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


def ring(centre, width, colour="#000"):
    return path(arc(centre, 0, 2 * math.pi)[:-1], width, True, colour)


def square(x, y, half, colour="#000"):
    return f'<rect x="{x - half}" y="{y - half}" width="{2 * half}" height="{2 * half}" fill="{colour}"/>'


def painted(file):
    """What is inked of a layer, with what white takes away from what is below it, and the colours of its inks."""
    ink, colours = Polygon(), set()
    pattern = next(g for g in ElementTree.parse(file).getroot().iter(SVG + "g") if g.get("id") == "pattern")
    for shape in pattern.iter(SVG + "path"):
        if shape.get("class") == "centreline":
            continue
        area = Polygon()
        for part in shape.get("d").split("M")[1:]:  # holes, by even and odd
            area = area.symmetric_difference(Polygon(points_of("M" + part)).buffer(0))
        if shape.get("fill") == "#ffffff":
            ink = ink.difference(area)
        else:
            ink = unary_union([ink, area])
            colours.add(shape.get("fill"))
    return ink, colours


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
        (self.folder / name).write_text(text)
        return self.run_pattern(self.folder / name, *settings, refused=refused)

    def run_pattern(self, pattern, *settings, refused=False):
        out = self.folder / f"out-{pattern.name}"
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

    def zipped(self, name, files):
        path = self.folder / name
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for file, text in files.items():
                archive.writestr(file, text)
        return path

    def test_files_of_a_zip_are_steps(self):
        one = self.run_drawing("one-file.svg", with_bridges())[0]
        files = {"Smith-Bridges.svg": svg(lines(BRIDGES, "#c00")), "Smith-dielectric.svg": svg(lines(PATCHES)),
                 "Smith-conductor.svg": svg(lines(CONDUCTOR) + path(RING[:-1], WIDTH, True)), "notes.txt": "Smith"}
        several, report = self.run_pattern(self.zipped("layers.zip", files))
        self.check_two_loops(several, report)
        for name in "print.svg", "print-dielectric.svg", "print-bridges.svg":
            self.assertEqual(painted(one / name)[0].symmetric_difference(painted(several / name)[0]).area, 0, name)
        self.assertIn("head-coils.svg", self.run_pattern(self.zipped("unnamed.zip", {**files, "head-coils.svg": svg()}), refused=True))

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

    def legends(self, out):
        found = {}
        for file in out.glob("print*.svg"):
            said = re.search(r"step (\d) of (\d): ([^<]*?)   ", file.read_text())
            found[int(said[1])] = (file.stem, said[3])
            self.assertEqual(int(said[2]), len(list(out.glob("print*.svg"))))
        return [found[number] for number in sorted(found)]

    def test_resist_and_a_picture_are_printed_last_and_change_no_circuit(self):
        cover = ring(A, WIDTH + 2, "#2a5") + ring(B, WIDTH + 2, "#2a5")
        picture = '<circle cx="72" cy="61" r="9" fill="none" stroke="#e07020" stroke-width="2"/>' + square(138, 30, 8, "#3366cc") + square(138, 30, 3, "#fff")
        text = with_bridges(more=group("5 picture", picture) + group("4 solder mask", cover))
        out, report = self.run_drawing("cover.svg", text)
        self.check_two_loops(out, report)
        self.assertFalse(self.codes(report) & {"layer-unnamed", "layers-as-one", "layer-empty", "pads-covered", "pattern-dark"})
        self.assertEqual(self.legends(out), [
            ("print", "conductive ink"), ("print-dielectric", "dielectric ink"), ("print-bridges", "conductive ink, bridges"),
            ("print-resist", "resist"), ("print-picture", "picture, in its own colours")])
        self.assertIn(b"/Type /Pages /Count 5 ", (out / "print.pdf").read_bytes())
        self.assertEqual([m.decode() for m in re.findall(rb"/P \(([^)]*)\)", (out / "print.pdf").read_bytes())],
                         ["print", "print-dielectric", "print-bridges", "print-resist", "print-picture"])
        # The resist lies where the conductors lie, since it moves with their coils.
        resist, of_resist = painted(out / "print-resist.svg")
        conductors, _ = painted(out / "print.svg")
        self.assertEqual(of_resist, {"#000000"})
        self.assertLess(conductors.difference(resist).area, 0.01)
        ink, colours = painted(out / "print-picture.svg")
        self.assertEqual(colours, {"#e07020", "#3366cc"})
        self.assertAlmostEqual(min(part.area for part in ink.geoms), 2 * math.pi * 9 * 2, delta=20)
        self.assertEqual(sorted(len(part.interiors) for part in ink.geoms), [1, 1], "white is bare sheet")
        layers = {p.dxf.layer for p in ezdxf.readfile(out / "layers.dxf").modelspace()}
        self.assertEqual(layers, {"print", "print-dielectric", "print-bridges", "print-resist", "print-picture"})

    def test_roles_on_the_other_face_are_mirrored_and_named(self):
        text = svg(group("conductor", ring(A, WIDTH)), group("conductor inner", ring(B, WIDTH)), group("resist inner", ring(B, WIDTH + 2)),
                   group("picture outer", square(30, 90, 6, "#d22")))
        out, report = self.run_drawing("sides.svg", text)
        self.check_two_loops(out, report)
        self.assertEqual([name for name, _ in self.legends(out)], ["print", "print-picture", "print-reverse", "print-reverse-resist"])
        for name, mirrored in (("print", False), ("print-picture", False), ("print-reverse", True), ("print-reverse-resist", True)):
            text = (out / f"{name}.svg").read_text()
            self.assertEqual('id="pattern" transform="scale(-1 1)"' in text, mirrored, name)
            self.assertIn("inner face" if mirrored else "outer face", text)
        self.assertLess(painted(out / "print-reverse.svg")[0].difference(painted(out / "print-reverse-resist.svg")[0]).area, 0.01)

    def gapped(self, cover):
        """A loop with a gap at its right, and another below, both 2 mm long."""
        gap = 1 / RADIUS
        loop = path(arc(A, gap, math.pi / 2 - gap), WIDTH) + path(arc(A, math.pi / 2 + gap, 2 * math.pi - gap), WIDTH)
        return svg(group("conductor", loop), cover)

    def test_covered_pads_are_said(self):
        right, below = on(A, 0), on(A, math.pi / 2)
        for name, cover, count in (
                ("all", group("resist", ring(A, WIDTH + 2)), 2),
                ("a hole by white, and a picture", group("resist", ring(A, WIDTH + 2) + square(*right, 6, "#fff") + square(*below, 6, "#fff")) +
                    group("picture", square(*right, 5, "#c00")), 1),
                ("openings", group("resist openings", square(*right, 6) + square(*below, 6)), 0),
                ("of the other face", group("resist reverse", ring(A, WIDTH + 2)) + group("F.Mask", square(*below, 6)), 1)):
            with self.subTest(name=name):
                out, report = self.run_drawing(f"pads-{name}.svg", self.gapped(cover))
                self.assertEqual((report["circuits"]["loops"], report["circuits"]["opens"]), (1, []))
                said = [w for w in report["warnings"] if w["code"] == "pads-covered"]
                self.assertEqual([w["figure"]["value"] for w in said], [count] if count else [])
                if name == "openings":
                    # The rest of the page, and the openings where the gaps are.
                    resist, _ = painted(out / "print-resist.svg")
                    self.assertGreater(resist.area, 0.8 * 170 * 120)
                    self.assertEqual(sum(len(part.interiors) for part in getattr(resist, "geoms", [resist])), 2)
                    self.assertFalse(self.codes(report) & {"ink-off-chart", "pattern-dark"})

    def test_made_gaps_under_resist_are_said(self):
        _, report = self.run_drawing("made.svg", svg(group("conductor", ring(A, WIDTH)), group("cover", ring(A, WIDTH + 2))), "coils.gaps=4")
        self.assertEqual(next(w["figure"]["value"] for w in report["warnings"] if w["code"] == "pads-covered"), 4)

    def test_layers_over_circuits_leave_the_loops_to_the_setting(self):
        text = svg(ring(A, WIDTH) + ring(B, WIDTH), group("resist", ring(A, WIDTH + 2)), group("artwork", square(30, 30, 5, "#0a0")))
        out, report = self.run_drawing("built.svg", text, "coils.build=bridges", "coils.gaps=2")
        self.check_two_loops(out, report, 2)
        self.assertEqual([name for name, _ in self.legends(out)], ["print", "print-dielectric", "print-bridges", "print-resist", "print-picture"])

    def test_a_picture_is_no_coil_and_joins_nothing(self):
        text = svg(group("conductor", ring((40, 60), WIDTH) + ring((100, 60), WIDTH)), group("legend", ring((120, 60), 2, "#a0a") +
                   path([(40, 60 - RADIUS), (100, 60 - RADIUS)], 2, colour="#a0a")))
        out, report = self.run_drawing("art.svg", text)
        self.check_two_loops(out, report)

    def test_a_line_between_coils_stays_under_its_resist(self):
        """It moves from the chart with the coils at its ends. So does what is drawn along it on a layer without these coils."""
        ends = [(A[0] + RADIUS, A[1]), (150, 100)]
        other = '<circle cx="150" cy="85" r="15" fill="none" stroke="#000" stroke-width="3"/>'
        out, _ = self.run_drawing("line.svg", svg(group("conductor", ring(A, WIDTH) + other + path(ends, 1)), group("resist", path(ends, 2)),
                                                  group("dielectric inner", path(ends, 2))))
        lines = {name: [LineString(points_of(line.get("d"))) for line in ElementTree.parse(out / f"{name}.svg").iter(SVG + "path")
                        if line.get("class") == "centreline" and line.get("data-width-mm") in "12"]
                 for name in ("print", "print-resist", "print-reverse-dielectric")}
        self.assertEqual([len(some) for some in lines.values()], [1, 1, 1])
        middle = lines["print"][0]
        self.assertGreater(middle.length, 50)
        for name, (along,) in lines.items():
            # Where the tie to a coil ends depends a little on the width of the line.
            self.assertLess(middle.hausdorff_distance(along), 0.05, name)

    def test_names_of_a_board(self):
        text = svg(group("F.Cu", ring(A, WIDTH)), group("B.Cu", ring(B, WIDTH)), group("F.SilkS", square(30, 30, 4, "#222")),
                   group("F.Mask", square(*on(A, 2), 3)), group("B.Mask-invert", ring(B, WIDTH + 1)))
        out, report = self.run_drawing("board.svg", text)
        self.check_two_loops(out, report)
        self.assertNotIn("layer-unnamed", self.codes(report))
        self.assertEqual([name for name, _ in self.legends(out)],
                         ["print", "print-resist", "print-picture", "print-reverse", "print-reverse-resist"])

    def test_a_picture_alone_is_a_drawing_like_any_other(self):
        out, report = self.run_drawing("alone.svg", svg(group("image", ring(A, WIDTH, "#c33"), "id")))
        self.assertEqual(report["circuits"]["loops"], 1)
        self.assertFalse((out / "print-picture.svg").exists())
        self.assertEqual(painted(out / "print.svg")[1], {"#cc3333"})

    def test_a_layer_of_white_is_left_out_and_said(self):
        out, report = self.run_drawing("white-ink.svg", svg(group("conductor", ring(A, WIDTH)), group("picture", square(30, 30, 6, "#fff"))))
        self.assertIn("layer-empty", self.codes(report))
        self.assertFalse((out / "print-picture.svg").exists())

    def test_the_service_keeps_the_names_of_layers_and_no_other(self):
        server = self.enterContext(Server(self.folder, workers=1))
        text = with_bridges(("Conductor", "dielectric", "Bridges"),
                            more=group("Array for Mary Smith", "") + group("Solder mask", ring(B, WIDTH + 2)) + group("Artwork", square(30, 30, 4, "#c00")))
        for name, drawing in (("service.svg", text), ("service.dxf", dxf([("BRIDGES", BRIDGES), ("DIELECTRIC", PATCHES),
                                                                          ("CONDUCTOR", CONDUCTOR + [(RING, WIDTH)])])),
                              ("service.zip", self.zipped("layers.zip", {
                                  "Smith-F_Cu.svg": svg(lines(CONDUCTOR) + path(RING[:-1], WIDTH, True)), "by Smith.txt": "Smith",
                                  "Smith-dielectric.svg": svg(lines(PATCHES)), "Smith bridges.svg": svg(lines(BRIDGES))}).read_bytes())):
            with self.subTest(name=name):
                pattern = self.folder / name
                pattern.write_bytes(drawing if isinstance(drawing, bytes) else drawing.encode())
                job = server.submit(made_scans.adult(), pattern, {"sheet": {"resolution_mm": 4}, "print": {"dpi": 72}})
                self.assertEqual(server.wait(job)["state"], "succeeded")
                report = curl(f"{server.api}/jobs/{job}/artifacts/report.json").json
                self.assertEqual((report["circuits"]["loops"], report["circuits"]["nets"]), (2, 2))
                self.assertEqual({"print-resist.svg", "print-picture.pdf"} <= {a["name"] for a in report["artifacts"]}, name == "service.svg")
                kept = [file.read_bytes() for file in server.data.rglob("*") if file.is_file()]
                self.assertFalse(any(b"Smith" in content for content in kept))


if __name__ == "__main__":
    unittest.main()
