"""Arrays as circuits: a reader of its own takes the polygons of every layer from print-*.svg and joins what touches. Sixteen and
thirty-one loops on two heads are as many nets as loops, without a short or an open, and keep their clearance on the part."""
import collections
import csv
import itertools
import json
import math
import re
import subprocess
import unittest
import xml.etree.ElementTree as ElementTree

import ezdxf
import numpy
from shapely import affinity
from shapely.geometry import LinearRing, LineString, Point, Polygon, box
from shapely.ops import nearest_points, unary_union

import made_scans
import meshes
from harness import Case, vacuform
from test_random_drawings import SVG, FormedSheet, points_of

FAST = ["--set", "sheet.resolution_mm=4", "--set", "print.dpi=72", "--set", "coils.decouple=true"]
CLEARANCE = 0.5


def areas(path, chords=32):
    """The painted polygons of a layer, by the id of their element, in sheet coordinates before any mirroring."""
    out = collections.defaultdict(list)
    if not path.exists():
        return out
    pattern = next(g for g in ElementTree.parse(path).getroot().iter(SVG + "g") if g.get("id") == "pattern")
    for group in pattern.iter(SVG + "g"):
        for shape in group.findall(SVG + "path"):
            if shape.get("class") != "centreline":
                rings = [points_of("M" + part, chords) for part in shape.get("d").split("M")[1:]]
                outer = unary_union([Polygon(ring).buffer(0) for ring in rings])
                if len(rings) > 1:  # holes, by even and odd
                    outer = Polygon()
                    for ring in rings:
                        outer = outer.symmetric_difference(Polygon(ring).buffer(0))
                out[group.get("id")].append(outer)
    return out


class Nets:
    """What of a folder conducts together."""

    def __init__(self, folder):
        self.parts = []  # (element, face, layer, polygon)
        self.joined = []
        self.conductors = {}
        for face in "", "-reverse":
            conductors = areas(folder / f"print{face}.svg")
            dielectric = unary_union(list(itertools.chain(*areas(folder / f"print{face}-dielectric.svg").values())))
            bridges = areas(folder / f"print{face}-bridges.svg")
            self.conductors[face] = {id: unary_union(some) for id, some in conductors.items()}
            ink = [(id, part) for id, whole in self.conductors[face].items() for part in getattr(whole, "geoms", [whole])]
            first = len(self.parts)
            self.parts += [(id, part) for id, part in ink]
            for i, k in itertools.combinations(range(first, len(self.parts)), 2):
                if self.parts[i][1].intersects(self.parts[k][1]):
                    self.joined.append((i, k))
            for id, some in bridges.items():
                for bridge in some:
                    self.parts.append((id, bridge))
                    for k in range(first, first + len(ink)):
                        if bridge.intersection(self.parts[k][1]).difference(dielectric).area > 0.05:
                            self.joined.append((k, len(self.parts) - 1))
                    for k in range(first + len(ink), len(self.parts) - 1):
                        if self.parts[k][1].intersects(bridge):
                            self.joined.append((k, len(self.parts) - 1))
        self.parent = list(range(len(self.parts)))
        for i, k in self.joined:
            self.parent[self.root(i)] = self.root(k)

    def root(self, i):
        while self.parent[i] != i:
            i = self.parent[i]
        return i

    def nets(self):
        """The ids of the elements of every net."""
        found = collections.defaultdict(set)
        for i, (id, _) in enumerate(self.parts):
            found[self.root(i)].add(id)
        return list(found.values())

    def least_clearance(self, sheet):
        """Between the conductors of two loops on one face, on the formed part, mm."""
        least = math.inf
        for loops in self.conductors.values():
            for (_, a), (_, b) in itertools.combinations(loops.items(), 2):
                if a.distance(b) < 2:
                    p, q = nearest_points(a, b)
                    least = min(least, math.dist(sheet.place(p.x, -p.y), sheet.place(q.x, -q.y)))
        return least


class Tails:
    """The tails of a folder, read from the centre lines of their leads."""

    def __init__(self, folder, report):
        ply = meshes.Ply((folder / "formed.ply").read_bytes())
        self.sheets = {"outer": FormedSheet(ply), "inner": FormedSheet(ply)}
        self.sheets["inner"].solid = ply.points
        self.tails = {coil["id"]: (coil["face"], coil["tail"]) for coil in report["circuits"]["coils"] if coil["tail"]}
        self.files = {"outer": "print", "inner": "print-reverse"}
        self.lines = collections.defaultdict(list)
        for face, file in self.files.items():
            if not (folder / f"{file}.svg").exists():
                continue
            pattern = next(g for g in ElementTree.parse(folder / f"{file}.svg").getroot().iter(SVG + "g") if g.get("id") == "pattern")
            for group in pattern.iter(SVG + "g"):
                for path in group.findall(SVG + "path"):
                    # The loops of these arrays have other widths.
                    if path.get("class") == "centreline" and float(path.get("data-width-mm")) == 1.5:
                        self.lines[face, group.get("id")].append(points_of(path.get("d"), 64))

    def place(self, face, p):
        return numpy.array(self.sheets[face].place(p[0], -p[1]))

    def pads(self, id):
        """The ends of its leads that lie at its pads, sheet coordinates."""
        face, tail = self.tails[id]
        return [line[-1] for line in self.lines[face, id] if math.dist(self.place(face, line[-1]), tail["pads_mm"]) < 3]

    def widths(self, id, ink):
        """Across the leads, on the part: from the middle of each to the edges of the ink."""
        face, _ = self.tails[id]
        for line in self.lines[face, id]:
            at = numpy.array([p for i, p in enumerate(line) if i == 0 or math.dist(p, line[i - 1]) > 1e-6])
            along = numpy.concatenate([[0], numpy.cumsum(numpy.linalg.norm(numpy.diff(at, axis=0), axis=1))])
            for mm in numpy.arange(7, along[-1] - 9, 8):
                p, a, b = (numpy.array([numpy.interp(x, along, at[:, k]) for k in (0, 1)]) for x in (mm, mm - 0.8, mm + 0.8))
                ahead = self.place(face, b) - self.place(face, a)
                turn = (b - a) / math.dist(a, b)
                # The way across on the part: the one at a right angle there.
                gradient = [(self.place(face, p + 0.4 * e) - self.place(face, p - 0.4 * e)) @ ahead for e in numpy.eye(2)]
                across = numpy.array([-gradient[1], gradient[0]]) / math.hypot(*gradient)
                across = across if across[0] * -turn[1] + across[1] * turn[0] > 0 else -across
                width = 0
                for side in (1, -1):
                    ray = LineString([p, p + side * 1.4 * across]).intersection(ink)
                    ray = next((g for g in getattr(ray, "geoms", [ray]) if g.distance(Point(p)) < 1e-6), None)
                    steps = [self.place(face, p + side * across * x) for x in numpy.linspace(0, ray.length if ray else 0, 8)]
                    width += sum(math.dist(s, t) for s, t in zip(steps, steps[1:]))
                yield width


class Circuits(Case):
    def run_array(self, head, count, *settings):
        name = f"{head.stem}-{count}"
        layout = self.folder / f"layout-{name}"
        if not layout.exists():
            done = vacuform("layout", "--scan", head, "--set", "sheet.resolution_mm=4", "--count", str(count), "--out", layout)
            self.assertEqual(done.returncode, 0, done.stderr)
        out = self.folder / "-".join([name, *(s.split("=")[1] for s in settings)])
        done = vacuform("run", "--scan", head, "--pattern", layout / "pattern.svg", *FAST, "--cache", self.folder / "cache", "--out", out,
                        *itertools.chain(*(("--set", s) for s in settings)))
        self.assertEqual(done.returncode, 0, done.stderr)
        return out, json.loads((out / "report.json").read_text())

    def check(self, head, count, build, gaps):
        out, report = self.run_array(head, count, f"coils.build={build}", f"coils.gaps={gaps}")
        circuits = report["circuits"]
        self.assertEqual((circuits["loops"], circuits["nets"], circuits["shorts"], circuits["opens"]), (count, count, [], []), out)
        codes = {w["code"] for w in report["warnings"]}
        self.assertFalse(codes & {"coils-short", "coils-open", "coils-close", "bridges-crowded", "gaps-left-out"}, codes)
        self.assertEqual({len(c["gaps"]) for c in circuits["coils"]}, {gaps})
        # Each gap parts a loop until its capacitor is there.
        read = Nets(out)
        nets = read.nets()
        self.assertTrue(all(len(net) == 1 for net in nets), [net for net in nets if len(net) > 1])
        by_loop = collections.Counter(next(iter(net)) for net in nets)
        self.assertEqual(set(by_loop.values()), {max(1, gaps)}, by_loop)
        self.assertEqual(len(by_loop), count)
        sheet = FormedSheet(meshes.Ply((out / "formed.ply").read_bytes()))
        self.assertGreater(read.least_clearance(sheet), CLEARANCE - 0.03)
        return report

    def test_arrays_with_bridges(self):
        for head, count, gaps in ((made_scans.adult(), 16, 4), (made_scans.adult(), 31, 0), (made_scans.newborn(), 16, 0)):
            with self.subTest(head=head.stem, count=count):
                report = self.check(head, count, "bridges", gaps)
                self.assertEqual({c["face"] for c in report["circuits"]["coils"]}, {"outer"})

    def test_arrays_on_two_faces(self):
        for head, count, gaps in ((made_scans.adult(), 16, 4), (made_scans.adult(), 31, 2), (made_scans.newborn(), 31, 0)):
            with self.subTest(head=head.stem, count=count):
                report = self.check(head, count, "two_faces", gaps)
                self.assertEqual({c["face"] for c in report["circuits"]["coils"]}, {"outer", "inner"})
                couplings = report["figures"]["with"]["coils"]
                self.assertLess(abs(couplings["strongest_neighbours"]["k"]), 0.01)

    def check_tails(self, head, count, build, most_left_out=0):
        """As check(), and each loop's two leads lead from the two sides of its port to two pads beside the head."""
        out, report = self.run_array(head, count, f"coils.build={build}", "coils.gaps=4", "coils.tails=nearest")
        circuits = report["circuits"]
        self.assertEqual((circuits["loops"], circuits["nets"], circuits["shorts"], circuits["opens"], circuits["close"]), (count, count, [], [], []), out)
        read = Nets(out)
        nets = read.nets()
        self.assertTrue(all(len(net) == 1 for net in nets), [net for net in nets if len(net) > 1])
        by_loop = collections.Counter(next(iter(net)) for net in nets)
        self.assertEqual(set(by_loop.values()), {4}, by_loop)
        tails = Tails(out, report)
        self.assertGreaterEqual(len(tails.tails), count - most_left_out)
        left_out = [w for w in report["warnings"] if w["code"] == "tails-left-out"]
        self.assertEqual(sum(w["figure"]["value"] for w in left_out), count - len(tails.tails))
        self.assertGreater(read.least_clearance(tails.sheets["outer"]), CLEARANCE - 0.03)
        widths = []
        for id, (face, tail) in tails.tails.items():
            ends = tails.pads(id)
            self.assertEqual(len(ends), 2, id)
            # Straight in space: along the sheet, which has folds at the foot of the mold, it is a little more.
            self.assertAlmostEqual(math.dist(*(tails.place(face, p) for p in ends)), 2.45, delta=0.2)
            held = [next(read.root(i) for i, (of, part) in enumerate(read.parts) if of == id and part.distance(Point(p)) < 0.1) for p in ends]
            self.assertNotEqual(*held, "the leads end on the two sides of the port")
            # Beside the port, which is between them: one of the loop's gaps, the only one without two pieces of one lead.
            port = next(gap["place_mm"] for coil in circuits["coils"] if coil["id"] == id for gap in coil["gaps"] if gap["port"])
            for net in held:
                near = min(math.dist(tails.place(face, p), port) for i, (of, part) in enumerate(read.parts) if read.root(i) == net
                           for p in part.exterior.coords)
                self.assertLess(near, 1.5, id)
            ink = unary_union(areas(out / f"{tails.files[face]}.svg", 64)[id])
            widths += list(tails.widths(id, ink))
            self.assertLess(abs(tail["ohm"] / (2 * 0.025 * tail["length_mm"] / 1.5) - 1), 1.2, id)
        errors = numpy.array(widths) - 1.5
        self.assertGreater(len(errors), 60)
        self.assertLess(abs(errors.mean()), 0.02)
        self.assertLess(numpy.percentile(abs(errors), 95), 0.08, sorted(errors))
        rows = [row for row in csv.DictReader((out / "coils.csv").read_text().splitlines()) if row["tail_mm"]]
        self.assertEqual([float(row["tail_mm"]) for row in rows], [tail["length_mm"] for _, tail in tails.tails.values()])
        self.assertEqual({row["kind"] for row in rows}, {"port"})
        return out, report, errors

    def test_tails_of_arrays_with_bridges(self):
        self.check_tails(made_scans.adult(), 16, "bridges")

    def test_tails_of_arrays_on_two_faces(self):
        for head in (made_scans.adult(), made_scans.newborn()):
            with self.subTest(head=head.stem):
                out, report, _ = self.check_tails(head, 16, "two_faces")
                self.assertTrue(all(coil["tail"] for coil in report["circuits"]["coils"]))
                numbers = [str(coil["tail"]["number"]) for coil in report["circuits"]["coils"]]
                printed = collections.Counter(
                    text.text for file in out.glob("print*.svg") for marks in ElementTree.parse(file).getroot().iter(SVG + "g")
                    if marks.get("id") == "mark-gap-numbers" for text in marks.iter(SVG + "text"))
                self.assertEqual([printed[number] for number in numbers], [2] * 16, "beside the port, and beside its pads")

    def test_printed_capacitors_have_what_is_said(self):
        """From the polygons of both faces and the formed sheet: permittivity times area over thickness, which forming divides by the
        ratio of areas. The two of each plate are in series."""
        out, report = self.run_array(made_scans.adult(), 8, "coils.build=two_faces", "coils.gaps=3", "coils.capacitor=printed",
                                     "sheet.thickness_mm=0.3", "circuit.frequency_mhz=298.04", "coils.plate_width_mm=6")
        circuits = report["circuits"]
        self.assertEqual((circuits["loops"], circuits["nets"], circuits["shorts"], circuits["opens"]), (8, 8, [], []))
        sheet = FormedSheet(meshes.Ply((out / "formed.ply").read_bytes()))
        layers = {face: {id: unary_union(some) for id, some in areas(out / f"{name}.svg").items()}
                  for face, name in (("outer", "print"), ("inner", "print-reverse"))}

        def picofarads(overlap):
            step, total = 0.5, 0
            x0, y0, x1, y1 = overlap.bounds
            for x, y in itertools.product(numpy.arange(x0, x1, step), numpy.arange(y0, y1, step)):
                part = overlap.intersection(box(x, y, x + step, y + step)).area
                if part > 0:
                    a, b, c = (numpy.array(sheet.place(*p)) for p in ((x, -y), (x + step, -y), (x, -y - step)))
                    ratio = numpy.linalg.norm(numpy.cross(b - a, c - a)) / step ** 2
                    total += 8.8541878e-3 * 3.0 * ratio ** 2 * part / 0.3
            return total

        faces = {coil["id"]: coil["face"] for coil in circuits["coils"]}
        checked = 0
        for loop in circuits["electrical"]["loops"]:
            own = faces[loop["id"]]
            plates = layers["inner" if own == "outer" else "outer"].get(loop["id"], Polygon())
            read = []
            for plate in getattr(plates, "geoms", [plates]):
                halves = [] if plate.is_empty else getattr(plate.intersection(layers[own][loop["id"]]), "geoms", [])
                values = [picofarads(half) for half in halves if half.area > 1]
                if len(values) == 2:
                    read.append(values[0] * values[1] / sum(values))
            said = [gap["plate"]["between_pf"] for gap in loop["gaps"] if gap["plate"] and gap["plate"]["between_pf"] > 0.5]
            for a in said:
                self.assertLess(min(abs(a / b - 1) for b in read), 0.04, (loop["id"], said, read))
                checked += 1
            for gap in loop["gaps"]:
                self.assertEqual(gap["plate"] is None, gap["port"])
        self.assertGreater(checked, 8)
        small = [w for w in report["warnings"] if w["code"] == "plates-small"]
        short = [gap for loop in circuits["electrical"]["loops"] for gap in loop["gaps"]
                 if gap["plate"] and gap["plate"]["pf"] < 0.97 * gap["wanted_pf"]]
        self.assertEqual(bool(small), bool(short))

    def test_the_files_for_the_bench_and_for_other_programs(self):
        out, report = self.run_array(made_scans.adult(), 16, "coils.build=two_faces", "coils.gaps=4")
        array = json.loads((out / "array.json").read_text())
        frequency = array["frequency_mhz"]
        omega = 2e6 * math.pi * frequency
        rows = list(csv.DictReader((out / "coils.csv").read_text().splitlines()))
        self.assertEqual(len(rows), 64)
        self.assertEqual([r["kind"] for r in rows[:4]], ["port"] + 3 * ["capacitor"])
        henry = numpy.array([loop["inductance_nh"] for loop in array["loops"]]) * 1e-9
        ohm = numpy.array([loop["coil_ohm"] + loop["body_ohm"] for loop in array["loops"]])
        for loop in array["loops"]:
            of_loop = [r for r in rows if r["loop"] == loop["id"]]
            # The capacitors in series, and what they leave of the reactance, match the loop to the port.
            series = 1 / sum(1e12 / float(r["wanted_pF"]) for r in of_loop if r["kind"] == "capacitor")
            z = loop["coil_ohm"] + loop["body_ohm"] + 1j * (omega * loop["inductance_nh"] * 1e-9 - 1 / (omega * series))
            seen = 1 / (1 / z + 1j * omega * float(of_loop[0]["wanted_pF"]) * 1e-12)
            self.assertLess(abs(seen - 50), 1, loop["id"])
            for r in of_loop:
                self.assertLess(abs(float(r["value_pF"]) / float(r["wanted_pF"]) - 1), 0.06, r)
            for r, place in zip(of_loop, (gap["place_mm"] for gap in loop["gaps"])):
                self.assertEqual([float(r[axis + "_mm"]) for axis in "xyz"], place)
        # What a current drives in another loop, and what preamplifiers leave of it.
        k = numpy.array(array["k"])
        alone = omega * abs(k) * numpy.sqrt(numpy.outer(henry, henry)) / ohm[None, :]
        numpy.fill_diagonal(alone, 1)
        left = numpy.where(numpy.eye(16) > 0, 1, alone / 10)
        self.assertLess(abs(numpy.array(array["currents"]) - left).max(), 0.002)
        self.assertAlmostEqual(array["strongest_current"]["share"], (alone - numpy.eye(16)).max(), delta=0.02)
        # The sphere that the head is taken for, and the two bounds of what it costs.
        self.assertTrue(60 < array["body"]["radius_mm"] < 110, array["body"])
        self.assertTrue(all(0 < loop["body_ohm"] < loop["most_body_ohm"] for loop in array["loops"]))

        # A reader of Touchstone 2.0: the matrix is that of the loops, reciprocal and passive.
        words = (out / "array.ts").read_text().split("[Network Data]")
        self.assertIn("# MHz S RI R 50", words[0])
        self.assertIn("[Number of Ports] 16", words[0])
        numbers = [float(word) for word in words[1].replace("[End]", "").split()]
        self.assertEqual(len(numbers), 51 * (1 + 2 * 256))
        middle = numbers[25 * 513:26 * 513]
        self.assertAlmostEqual(middle[0], frequency, places=5)
        s = (numpy.array(middle[1::2]) + 1j * numpy.array(middle[2::2])).reshape(16, 16)
        self.assertLess(abs(s - s.T).max(), 1e-6)
        self.assertLess(numpy.linalg.svd(s)[1].max(), 1)
        self.assertLess(abs(s.diagonal()).max(), 0.6)

        # NEC-2 reads the wires as they are. It knows the field of the charges, too, and agrees about the loop's own figures.
        done = subprocess.run(["nec2c", "-i", out / "array.nec", "-o", out / "array.out"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        line = (out / "array.out").read_text().split("ANTENNA INPUT PARAMETERS")[1].splitlines()[3].split()
        k = numpy.array(array["k"])
        series = numpy.array([loop["series_pf"] for loop in array["loops"]]) * 1e-12
        z = 1j * omega * k * numpy.sqrt(numpy.outer(henry, henry)) + numpy.diag(ohm + 1 / (1j * omega * series))
        port = 1 / numpy.linalg.inv(z)[0, 0]
        self.assertLess(abs(complex(float(line[6]), float(line[7])) - port), 0.1 * omega * henry[0], port)

    def test_wires_for_marie(self):
        """As its reader takes them: the n-th point element is the place of the n-th element of the circuit, and the number of its
        node is that of a piece of wire that begins there."""
        out, _ = self.run_array(made_scans.adult(), 16, "coils.build=two_faces", "coils.gaps=4")
        lines = (out / "array-marie.msh").read_text().splitlines()
        self.assertEqual(lines[:3], ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"])
        begin = lines.index("$Nodes") + 2
        nodes = {int(n): [float(v) for v in place] for n, *place in (line.split() for line in lines[begin:lines.index("$EndNodes")])}
        self.assertEqual(list(nodes), list(range(1, int(lines[begin - 1]) + 1)))
        begin = lines.index("$Elements") + 2
        elements = [[int(word) for word in line.split()] for line in lines[begin:lines.index("$EndElements")]]
        self.assertEqual(len(elements), int(lines[begin - 1]))
        ports = [e[-1] for e in elements if e[1] == 15]
        wires = [e[-2:] for e in elements if e[1] == 1]
        self.assertEqual([a for a, _ in wires], list(nodes))
        self.assertEqual(sum(b < a for a, b in wires), 16, "each loop closes once")
        circuit = json.loads((out / "array-marie.json").read_text())["coil_configuration"]["elements"]
        rows = list(csv.DictReader((out / "coils.csv").read_text().splitlines()))
        self.assertEqual([len(ports), len(circuit)], [64, 64])
        for node, element, row in zip(ports, circuit, rows):
            place = [1000 * v for v in nodes[node]]
            self.assertLess(math.dist(place, [float(row[axis + "_mm"]) for axis in "xyz"]), 1.2, row)
            self.assertEqual(element["type"], "port" if row["kind"] == "port" else "element")
            self.assertAlmostEqual(1e12 * element["value"], float(row["wanted_pF"]), places=1)
            self.assertLess(element["optim"]["minim"], element["value"])
        self.assertEqual(sorted({element["excitation"]["entity"] for element in circuit}), list(range(1, 17)))

    def test_conductors_are_closed_solids(self):
        out, report = self.run_array(made_scans.adult(), 16, "coils.build=two_faces", "coils.gaps=4")
        solids, facets = {}, None
        for line in (out / "array.stl").read_text().splitlines():
            words = line.split()
            if words[0] == "solid":
                facets = solids.setdefault(words[1], [])
            elif words[0] == "vertex":
                facets.append(tuple(map(float, words[1:])))
        self.assertEqual(len([name for name in solids if not name.endswith("-bridges")]), 16)
        self.assertEqual(len([name for name in solids if name.endswith("-bridges")]) > 0, bool(report["circuits"]["bridges"]))
        for name, points in solids.items():
            corners = [tuple(points[i:i + 3]) for i in range(0, len(points), 3)]
            edges = collections.Counter((t[k], t[(k + 1) % 3]) for t in corners for k in range(3))
            self.assertTrue(all(edges[b, a] == count for (a, b), count in edges.items()), name)
            volume = sum(numpy.dot(a, numpy.cross(b, c)) for a, b, c in corners) / 6
            # The thickness that is left, as its own area says: 10 um, less where the sheet is stretched.
            area = sum(numpy.linalg.norm(numpy.cross(numpy.subtract(b, a), numpy.subtract(c, a))) for a, b, c in corners) / 2
            self.assertTrue(0.003 < 2 * volume / area < 0.0105, (name, volume, area))

    def test_a_cad_program_reads_the_layers(self):
        """As ezdxf reads them: on layers of the names of the files, what these paint, of both faces seen from one side."""
        out, report = self.run_array(made_scans.adult(), 16, "coils.build=two_faces", "coils.gaps=4")
        drawing = ezdxf.readfile(out / "layers.dxf")
        self.assertEqual(drawing.header["$INSUNITS"], 4)
        rings = collections.defaultdict(list)
        for polyline in drawing.modelspace():
            self.assertEqual((polyline.dxftype(), polyline.is_closed), ("POLYLINE", True))
            rings[polyline.dxf.layer].append(LinearRing([tuple(vertex.dxf.location)[:2] for vertex in polyline.vertices]))
        names = {path.stem for path in out.glob("print*.svg")}
        self.assertEqual(set(rings), names)
        self.assertLess({"print", "print-reverse"}, names)
        for name, read in rings.items():
            painted = unary_union(list(itertools.chain(*areas(out / f"{name}.svg").values())))
            outer, holes = (unary_union([Polygon(ring) for ring in read if ring.is_ccw == way]) for way in (True, False))
            with_y_up = affinity.scale(painted, 1, -1, origin=(0, 0))
            read_area = outer.difference(holes)
            # Both readers take chords for curves.
            for one, other in ((read_area, with_y_up), (with_y_up, read_area)):
                self.assertLess(one.difference(other.buffer(0.02)).area, 1e-3, name)

    def test_sheets_tell_their_step_and_number_their_gaps(self):
        out, _ = self.run_array(made_scans.adult(), 16, "coils.build=two_faces", "coils.gaps=4")
        sheet = FormedSheet(meshes.Ply((out / "formed.ply").read_bytes()))
        places = {row["number"]: [float(row[axis + "_mm"]) for axis in "xyz"] for row in csv.DictReader((out / "coils.csv").read_text().splitlines())}
        seen = []
        for face, mirrored in (("", False), ("-reverse", True)):
            ink = unary_union(list(itertools.chain(*(itertools.chain(*areas(out / f"print{face}{step}.svg").values())
                                                     for step in ("", "-dielectric", "-bridges")))))
            marks = next(g for g in ElementTree.parse(out / f"print{face}.svg").getroot().iter(SVG + "g") if g.get("id") == "mark-gap-numbers")
            for text in marks.iter(SVG + "text"):
                seen.append(text.text)
                x, y = map(float, re.match(r"translate\(([-\d.]+),([-\d.]+)\)", text.get("transform")).groups())
                x = -x if mirrored else x
                wide, high = 0.64 * 1.8 * len(text.text) / 2, 0.73 * 1.8
                self.assertGreater(box(x - wide, y - high, x + wide, y).distance(ink), 0.1, text.text)
                self.assertLess(math.dist(sheet.place(x, -y), places[text.text]), 14, text.text)
        self.assertEqual(sorted(seen, key=int), [str(n + 1) for n in range(64)])

        layers = [face + step for face in ("print", "print-reverse") for step in ("", "-dielectric", "-bridges") if (out / f"{face}{step}.svg").exists()]
        self.assertGreater(len(layers), 3)
        for number, layer in enumerate(layers, 1):
            words = "dielectric ink" if layer.endswith("dielectric") else "conductive ink, bridges" if layer.endswith("bridges") else "conductive ink"
            self.assertIn(f"step {number} of {len(layers)}: {words}   ", (out / f"{layer}.svg").read_text())
        pdf = (out / "print.pdf").read_bytes()
        self.assertIn(b"/Type /Pages /Count %d " % len(layers), pdf)
        self.assertEqual([m.decode() for m in re.findall(rb"/P \(([^)]*)\)", pdf)], layers)
        self.assertIn(b"/Type /Pages /Count 1 ", (out / "print-reverse.pdf").read_bytes())

    def test_one_layer_is_a_short_circuit_and_says_so(self):
        out, report = self.run_array(made_scans.adult(), 16)
        self.assertEqual(report["circuits"]["nets"], 1)
        short = next(w for w in report["warnings"] if w["code"] == "coils-short")
        self.assertEqual(short["severity"], "serious")
        nets = Nets(out).nets()
        self.assertEqual([len(net) for net in nets], [16])
        # Every pair that the reader finds in one piece is named.
        loops = Nets(out).conductors[""]
        touching = {frozenset(pair) for pair in itertools.combinations(loops, 2) if loops[pair[0]].intersects(loops[pair[1]])}
        self.assertEqual({frozenset(s["coils"]) for s in report["circuits"]["shorts"]}, touching)


if __name__ == "__main__":
    unittest.main()
