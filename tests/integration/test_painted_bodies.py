"""A sphere and an ellipsoid that wear a net of lines over smooth colours: where the lines and colours come to lie on the formed
part, measured from print.png and formed.ply alone at the default grid and 300 dpi; and the same print from every format."""
import math
import struct
import unittest
import zlib

import hostile
from harness import Case, vacuform
from png_rows import rgb_rows
from test_colours import archive_of
from test_painted_models import formed_sheet

WIDTH, HEIGHT = 4320, 2160  # of the texture: u is the longitude, v the angle from the top to the equator
NET = 10  # degrees between lines
HALF_LINE = 6  # texels of longitude, or twelve of latitude: half a degree
INK, PAPER = 25, 185  # blue of the lines, and of everything else
BLUE_BETWEEN = 0.25  # linear light between the two
TOUCHES_MM = 0.1
DPI = 300


def linear(value):
    x = value / 255
    return x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4


LINEAR = [linear(value) for value in range(256)]


def red_at(u):
    return 140 + 90 * math.sin(2 * math.pi * 3 * u)


def green_at(v):
    return 140 + 90 * math.cos(2 * math.pi * 2 * v)


def painted():
    """The texture as a PNG."""
    columns = [(x + 0.5 + HALF_LINE) % (WIDTH * NET // 360) < 2 * HALF_LINE for x in range(WIDTH)]
    red = bytes(INK if line else round(red_at((x + 0.5) / WIDTH)) for x, line in enumerate(columns))
    is_line = bytes(columns)
    rows = []
    for y in range(HEIGHT):
        if (y + 0.5 + 2 * HALF_LINE) % (HEIGHT * NET // 90) < 4 * HALF_LINE:
            rows.append(b"\0" + bytes([INK]) * (3 * WIDTH))
            continue
        row = bytearray(3 * WIDTH)
        row[0::3] = red
        row[1::3] = is_line.translate(bytes([round(green_at((y + 0.5) / HEIGHT)), INK]) + bytes(254))
        row[2::3] = is_line.translate(bytes([PAPER, INK]) + bytes(254))
        rows.append(b"\0" + bytes(row))
    return (b"\x89PNG\r\n\x1a\n" + hostile.chunk(b"IHDR", struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 2, 0, 0, 0)) +
            hostile.chunk(b"IDAT", zlib.compress(b"".join(rows), 6)) + hostile.chunk(b"IEND", b""))


class Body:
    """The upper half of an ellipsoid with these half axes, mm: a vertex every degree of longitude and of latitude."""
    def __init__(self, *axes):
        self.axes = axes
        self.points, self.uv, self.faces = [], [], []
        for row in range(91):
            for column in range(361):
                u, v = column / 360, row / 90
                self.points.append(struct.unpack("<3f", struct.pack("<3f", *self.place(u, v))))
                self.uv.append((u, v))
        for row in range(90):
            for column in range(360):
                a, b = 361 * row + column, 361 * (row + 1) + column
                self.faces += ([(a, b, a + 1)] if row > 0 else []) + [(a + 1, b, b + 1)]

    def place(self, u, v):
        along, down = 2 * math.pi * (u % 1), math.pi / 2 * v
        return tuple(a * x for a, x in zip(self.axes, (math.sin(down) * math.cos(along), math.sin(down) * math.sin(along), math.cos(down))))

    def on_body(self, place):
        """(u, v) of a place near the body, and its distance to first order."""
        x, y, z = (p / a for p, a in zip(place, self.axes))
        size = math.sqrt(x * x + y * y + z * z)
        slope = math.sqrt(sum((p / a) ** 2 for p, a in zip((x, y, z), self.axes))) / size
        return math.atan2(y, x) / (2 * math.pi) % 1, math.acos(z / size) / (math.pi / 2), (size - 1) / slope

    def from_line(self, u, v):
        """Distances on the body, mm, from the nearest line of latitude and of longitude."""
        column, row = round(u * 360 / NET) * NET / 360, round(v * 90 / NET) * NET / 90
        here = self.place(u, v)
        return math.dist(here, self.place(u, row)), math.dist(here, self.place(column, v))

    def side(self, of_longitude, u, v, place):
        """The side of the line nearest to (u, v) on which a place lies."""
        theirs = self.on_body(place)
        if of_longitude:
            return (theirs[0] - round(u * 360 / NET) * NET / 360 + 0.5) % 1 > 0.5
        return theirs[1] > round(v * 90 / NET) * NET / 90

    def glb(self, picture):
        vertices = b"".join(struct.pack("<5f", -x, z, y, u, v) for (x, y, z), (u, v) in zip(self.points, self.uv))
        parts = (vertices, {"byteStride": 20}), (b"".join(struct.pack("<3I", *f) for f in self.faces), {}), (picture, {})
        views, at = [], 0
        for part, more in parts:
            views.append({"buffer": 0, "byteOffset": at, "byteLength": len(part), **more})
            at += len(part) + -len(part) % 4
        return hostile.glb({
            "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}], "textures": [{"source": 0}],
            "images": [{"bufferView": 2, "mimeType": "image/png"}], "buffers": [{"byteLength": at}], "bufferViews": views,
            "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(self.points)},
                          {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "type": "VEC2", "count": len(self.points)},
                          {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 3 * len(self.faces)}]},
            b"".join(part + bytes(-len(part) % 4) for part, _ in parts))

    def obj_zip(self, picture):
        text = ["mtllib a.mtl\n"] + ["v %.9g %.9g %.9g\n" % p for p in self.points]
        text += ["vt %.9g %.9g\n" % (u, 1 - v) for u, v in self.uv] + ["usemtl a\n"]
        text += ["f %d/%d %d/%d %d/%d\n" % tuple(i + 1 for i in f for _ in range(2)) for f in self.faces]
        return archive_of({"a.obj": "".join(text), "a.mtl": "newmtl a\nmap_Kd a.png\n", "a.png": picture})

    def ply_zip(self, picture):
        head = ("ply\nformat binary_little_endian 1.0\ncomment TextureFile a.png\n"
                f"element vertex {len(self.points)}\n" + "".join(f"property float {name}\n" for name in "xyzst") +
                f"element face {len(self.faces)}\nproperty list uchar int vertex_indices\nend_header\n")
        body = [struct.pack("<5f", *p, u, 1 - v) for p, (u, v) in zip(self.points, self.uv)]
        body += [struct.pack("<B3i", 3, *f) for f in self.faces]
        return archive_of({"a.ply": head.encode() + b"".join(body), "a.png": picture})


class Picture:
    """print.png in rows of bytes, sampled in mm from the middle of the sheet, to the right and up."""
    def __init__(self, path):
        self.rows = rgb_rows(path.read_bytes())
        self.width, self.height = len(self.rows[0]) // 3, len(self.rows)

    def pixel(self, column, row):
        return self.rows[row][3 * column:3 * column + 3]

    def column_row(self, s, t):
        return s * DPI / 25.4 + self.width / 2 - 0.5, self.height / 2 - t * DPI / 25.4 - 0.5

    def blue(self, s, t):
        """Linear light between pixels."""
        x, y = self.column_row(s, t)
        i, j = math.floor(x), math.floor(y)
        def at(column, row):
            return LINEAR[self.rows[row][3 * column + 2]]
        upper = at(i, j) + (x - i) * (at(i + 1, j) - at(i, j))
        lower = at(i, j + 1) + (x - i) * (at(i + 1, j + 1) - at(i, j + 1))
        return upper + (y - j) * (lower - upper)


class Sheet:
    """formed.ply: where a point of the flat sheet comes to lie."""
    CELL_MM = 2

    def __init__(self, path):
        self.vertices, self.triangles = formed_sheet(path)
        self.cells = {}
        for number, triangle in enumerate(self.triangles):
            s, t = ([self.vertices[v][k] for v in triangle] for k in (3, 4))
            for i in range(math.floor(min(s) / self.CELL_MM), math.floor(max(s) / self.CELL_MM) + 1):
                for j in range(math.floor(min(t) / self.CELL_MM), math.floor(max(t) / self.CELL_MM) + 1):
                    self.cells.setdefault((i, j), []).append(number)

    def formed(self, s, t):
        for number in self.cells.get((math.floor(s / self.CELL_MM), math.floor(t / self.CELL_MM)), ()):
            a, b, c = (self.vertices[v] for v in self.triangles[number])
            area = (b[3] - a[3]) * (c[4] - a[4]) - (c[3] - a[3]) * (b[4] - a[4])
            p = ((s - a[3]) * (c[4] - a[4]) - (c[3] - a[3]) * (t - a[4])) / area
            q = ((b[3] - a[3]) * (t - a[4]) - (s - a[3]) * (b[4] - a[4])) / area
            if p >= -1e-9 and q >= -1e-9 and p + q <= 1 + 1e-9:
                return [a[k] + p * (b[k] - a[k]) + q * (c[k] - a[k]) for k in range(3)]
        return None


def lab(rgb):
    """CIE L*a*b* under D65 of sRGB levels."""
    r, g, b = (LINEAR[round(value)] for value in rgb)
    xyz = ((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047, 0.2126729 * r + 0.7151522 * g + 0.0721750 * b,
           (0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883)
    x, y, z = (v ** (1 / 3) if v > 216 / 24389 else (24389 / 27 * v + 16) / 116 for v in xyz)
    return 116 * y - 16, 500 * (x - y), 200 * (y - z)


def ciede2000(one, other):
    """ISO/CIE 11664-6 with all weights 1."""
    (l1, a1, b1), (l2, a2, b2) = one, other
    mean7 = ((math.hypot(a1, b1) + math.hypot(a2, b2)) / 2) ** 7
    g = 1.5 - 0.5 * math.sqrt(mean7 / (mean7 + 25 ** 7))
    c1, c2 = math.hypot(g * a1, b1), math.hypot(g * a2, b2)
    h1, h2 = math.degrees(math.atan2(b1, g * a1)) % 360, math.degrees(math.atan2(b2, g * a2)) % 360
    turn = 0 if c1 * c2 == 0 else (h2 - h1 + 180) % 360 - 180
    hue = h1 + h2 if c1 * c2 == 0 else (h1 + turn / 2) % 360
    l, c = (l1 + l2) / 2, (c1 + c2) / 2
    cos = lambda degrees: math.cos(math.radians(degrees))
    t = 1 - 0.17 * cos(hue - 30) + 0.24 * cos(2 * hue) + 0.32 * cos(3 * hue + 6) - 0.2 * cos(4 * hue - 63)
    dl = (l2 - l1) / (1 + 0.015 * (l - 50) ** 2 / math.sqrt(20 + (l - 50) ** 2))
    dc = (c2 - c1) / (1 + 0.045 * c)
    dh = 2 * math.sqrt(c1 * c2) * math.sin(math.radians(turn / 2)) / (1 + 0.015 * c * t)
    rt = -2 * math.sqrt(c ** 7 / (c ** 7 + 25 ** 7)) * math.sin(math.radians(60 * math.exp(-((hue - 275) / 25) ** 2)))
    return math.sqrt(dl * dl + dc * dc + dh * dh + rt * dc * dh)


class PaintedBodies(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.texture = painted()

    def printed(self, name, scan, *words):
        path, out = self.folder / name, self.folder / f"of-{name}"
        path.write_bytes(scan)
        done = vacuform("run", "--scan", path, "--out", out, "--set", "pattern.source=scan", "--set", "scan.units=mm",
                        "--set", "print.marks=false", "--set", "print.compensate_colours=false", *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        return out

    def lines_met(self, body, sheet, picture, path):
        """Errors of the lines that a path of (s, t) crosses, mm on the body, by lines of latitude and of longitude."""
        errors, entered, last = ([], []), None, None
        for s, t in path:
            blue = picture.blue(s, t)
            if last and (blue < BLUE_BETWEEN) != (last[0] < BLUE_BETWEEN):
                share = (BLUE_BETWEEN - last[0]) / (blue - last[0])
                place = sheet.formed(last[1] + share * (s - last[1]), last[2] + share * (t - last[2]))
                if blue < BLUE_BETWEEN:
                    entered = place
                elif entered and place:
                    u, v, far = body.on_body([(a + b) / 2 for a, b in zip(entered, place)])
                    latitude, longitude = body.from_line(u, v)
                    kind = latitude > longitude
                    sides = [body.side(kind, u, v, end) for end in (entered, place)]
                    # Where lines of both kinds meet, or a path leaves a line on the side where it came from, the middle of
                    # what is dark lies on neither.
                    if abs(far) < TOUCHES_MM and max(latitude, longitude) > 1.5 and sides[0] != sides[1]:
                        errors[kind].append(min(latitude, longitude))
                    entered = None
            last = blue, s, t
        return errors

    def check(self, name, body, lines):
        out = self.printed(name + ".glb", body.glb(self.texture), "--set", f"print.dpi={DPI}")
        sheet, picture = Sheet(out / "formed.ply"), Picture(out / "print.png")
        errors = ([], [])
        def follow(path):
            for kept, found in zip(errors, self.lines_met(body, sheet, picture, path)):
                kept.extend(found)
        for k in range(36):
            cos, sin = (f(math.radians(NET * k + 3.7)) for f in (math.cos, math.sin))
            follow([(0.04 * i * cos, 0.04 * i * sin) for i in range(100, 2000)])
        for r in range(12, 60, 3):
            steps = round(2 * math.pi * r / 0.04)
            follow([(r * math.cos(2 * math.pi * i / steps), r * math.sin(2 * math.pi * i / steps)) for i in range(steps)])
        differences = []
        for row in range(0, picture.height, 12):
            for column in range(0, picture.width, 12):
                place = sheet.formed((column + 0.5 - picture.width / 2) * 25.4 / DPI, (picture.height / 2 - row - 0.5) * 25.4 / DPI)
                if not place or place[2] < 1:
                    continue
                u, v, far = body.on_body(place)
                # Near the top, longitudes change within a pixel.
                if abs(far) < TOUCHES_MM and min(body.from_line(u, v)) > 1 and v > 0.1:
                    expected = red_at(u), green_at(v), PAPER
                    differences.append(ciede2000(lab(picture.pixel(column, row)), lab(expected)))
        for kind, found in zip(("latitude", "longitude"), errors):
            found.sort()
            p99 = found[len(found) * 99 // 100]
            print(f"{name}: {len(found)} places on lines of {kind}, p99 {p99:.3f} mm, largest {found[-1]:.3f} mm")
            self.assertGreater(len(found), lines)
            self.assertLess(p99, 0.2, kind)
        mean = sum(differences) / len(differences)
        print(f"{name}: CIEDE2000 at {len(differences)} places: mean {mean:.3f}, largest {max(differences):.2f}")
        self.assertGreater(len(differences), 2000)
        self.assertLess(mean, 1)

    def test_lines_and_colours_of_a_sphere_come_to_lie_in_their_places(self):
        self.check("sphere", Body(50, 50, 50), 100)

    def test_lines_and_colours_of_an_ellipsoid_come_to_lie_in_their_places(self):
        self.check("ellipsoid", Body(65, 48, 40), 100)

    def test_every_format_gives_the_same_print(self):
        body = Body(50, 50, 50)
        pictures = [Picture(self.printed(name, scan, "--preview", *words) / "print.png") for name, scan, *words in (
            ("a.glb", body.glb(self.texture)), ("obj.zip", body.obj_zip(self.texture), "--set", "scan.up=+z"),
            ("ply.zip", body.ply_zip(self.texture), "--set", "scan.up=+z"))]
        for other in pictures[1:]:
            self.assertEqual((other.width, other.height), (pictures[0].width, pictures[0].height))
            for row, same in zip(other.rows, pictures[0].rows, strict=True):
                self.assertLessEqual(max(map(abs, map(int.__sub__, row, same))), 1)  # of 255

    def test_the_difference_of_colours_is_that_of_the_standard(self):
        # Pairs 1, 7 and 17 of the test data of Sharma, Wu and Dalal 2005.
        self.assertAlmostEqual(ciede2000((50, 2.6772, -79.7751), (50, 0, -82.7485)), 2.0425, 4)
        self.assertAlmostEqual(ciede2000((50, 0, 0), (50, -1, 2)), 2.3669, 4)
        self.assertAlmostEqual(ciede2000((50, 2.5, 0), (73, 25, -18)), 27.1492, 4)


if __name__ == "__main__":
    unittest.main()
