"""Made-up scans with known truth: each number of a seed is one body with the damage that real scans have, in a file."""
import math
import random

import scan_files
import scan_shapes

UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
# Those that few files are in. "x0.3" is a copy at three tenths of the size of the head, in mm.
ODD_UNITS = {"um": 0.001, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8, "x0.3": 1 / 0.3}
ALL_UNITS = UNITS | ODD_UNITS
# For each up axis of the file, where the upright body's x, y and z go. Proper turns: left stays left.
AXES = {"+z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)), "-z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
        "+y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)), "-y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
        "+x": ((0, 0, -1), (0, 1, 0), (1, 0, 0)), "-x": ((0, 0, 1), (0, 1, 0), (-1, 0, 0))}


def longer_side_from_above(points):
    """Of the rectangle of least area around the points, over turns by half a degree."""
    corners = set()
    for k in range(72):  # only points that are farthest in some direction matter
        c, s = math.cos(math.pi * k / 36), math.sin(math.pi * k / 36)
        corners.add(max(range(len(points)), key=lambda i: c * points[i][0] + s * points[i][1]))
    least, longer = math.inf, 0.0
    for k in range(180):
        c, s = math.cos(math.pi * k / 360), math.sin(math.pi * k / 360)
        along = [c * points[i][0] + s * points[i][1] for i in corners]
        aside = [c * points[i][1] - s * points[i][0] for i in corners]
        a, b = max(along) - min(along), max(aside) - min(aside)
        if a * b < least:
            least, longer = a * b, max(a, b)
    return longer


class Scan:
    """`data` in a file of the given `extension`, and the truth: `clean` is the undamaged body, upright and in mm."""

    def __init__(self, seed, number, units=tuple(UNITS)):
        chance = random.Random(f"{seed}/{number}")
        self.name = f"{seed}-{number:03d}"
        self.kind = list(scan_shapes.KINDS)[number % len(scan_shapes.KINDS)]
        self.unit = chance.choice(units)
        self.up = chance.choice(list(AXES))
        self.format = chance.choice(list(scan_files.FORMATS))
        if self.format == "glb":
            self.up = "+y"  # the format says so
        mesh = scan_shapes.KINDS[self.kind](chance)
        yaw = chance.uniform(-math.pi, math.pi)
        c, s = math.cos(yaw), math.sin(yaw)
        self.clean = [(c * x - s * y, s * x + c * y, z) for x, y, z in mesh[0]], mesh[1]
        self.size = math.dist(*self.box())
        self.noise = self.crumbs = self.outliers = self.holes = self.missing = 0
        self.reversed = self.mirrored = self.open_below = False
        self.extension, write = scan_files.FORMATS[self.format]
        self.data = write(self.in_file(self.damaged(chance), chance))

    def box(self, above=-math.inf):
        """The corners of the box around what lies above a height."""
        points = [p for p in self.clean[0] if p[2] >= above]
        return [tuple(bound(p[k] for p in points) for k in range(3)) for bound in (min, max)]

    def longest_side(self):
        """In mm, of the undamaged body, however it is turned about the vertical axis."""
        low, high = self.box()
        return max(high[2] - low[2], longer_side_from_above(self.clean[0]))

    def damage(self):
        """What is wrong with the file, for people."""
        parts = [f"{name} {value:.2g}" if isinstance(value, float) else f"{name} {value}" for name, value in (
            ("noise", self.noise), ("crumbs", self.crumbs), ("outliers", self.outliers), ("holes", self.holes),
            ("missing", self.missing)) if value]
        return ", ".join(parts + [name for name in ("open_below", "reversed", "mirrored") if getattr(self, name)])

    def damaged(self, chance):
        vertices, triangles = list(self.clean[0]), list(self.clean[1])
        if chance.random() < 0.4 and self.kind != "box":
            self.noise = chance.uniform(0.0002, 0.0015) * self.size
            vertices = [tuple(x + chance.gauss(0, self.noise) for x in p) for p in vertices]
        if self.kind in ("head", "bust") and chance.random() < 0.4:
            self.open_below = True
            level = 4 * self.noise + 1e-3
            triangles = [t for t in triangles if max(vertices[v][2] for v in t) > level]
        if chance.random() < 0.3:
            self.holes = chance.randint(1, 3)
            for _ in range(self.holes):
                middle = chance.choice(vertices)
                reach = chance.uniform(0.015, 0.07) * self.size
                triangles = [t for t in triangles if any(math.dist(vertices[v], middle) > reach for v in t)]
        if chance.random() < 0.12:
            self.missing = chance.uniform(0.03, 0.3)
            triangles = [t for t in triangles if chance.random() >= self.missing]
        if chance.random() < 0.3:
            self.add_crumbs(vertices, triangles, chance)
        if chance.random() < 0.2:
            self.outliers = chance.randint(1, 4)
            used = sorted({v for t in triangles for v in t})
            for v in chance.sample(used, self.outliers):
                away = [chance.gauss(0, 1) for _ in range(3)]
                far = chance.uniform(3, 20) * self.size / math.hypot(*away)
                vertices[v] = tuple(x + far * a for x, a in zip(vertices[v], away))
        turn = chance.random()
        if turn < 0.08:
            self.reversed = True
            triangles = [t[::-1] for t in triangles]
        elif turn < 0.16:  # a mirror image whose triangles keep their order faces inwards
            self.mirrored = True
            vertices = [(-x, y, z) for x, y, z in vertices]
            self.clean = [(-x, y, z) for x, y, z in self.clean[0]], self.clean[1]
        return vertices, triangles

    def add_crumbs(self, vertices, triangles, chance):
        """Small closed bodies beside and above the scan."""
        self.crumbs = chance.randint(1, 6)
        low, high = self.box()
        for _ in range(self.crumbs):
            reach = chance.uniform(0.003, 0.012) * self.size
            place = [chance.uniform(low[k] - 0.1 * self.size, high[k] + 0.1 * self.size) for k in range(3)]
            place[chance.randrange(2)] = chance.choice([low[0] - 0.15 * self.size, high[0] + 0.15 * self.size])
            first = len(vertices)
            vertices += [tuple(place[k] + sign * reach * (k == axis) for k in range(3)) for axis in range(3)
                         for sign in (-1, 1)]
            for corner in range(8):
                t = tuple(first + 2 * axis + (corner >> axis & 1) for axis in range(3))
                triangles.append(t if corner.bit_count() % 2 else t[::-1])

    def in_file(self, mesh, chance):
        """In the file's axes and unit, away from its origin, each vertex that is not used left out."""
        vertices, triangles = mesh
        to = AXES[self.up]
        shift = [chance.uniform(-1, 1) * self.size for _ in range(3)]
        per_mm = 1 / ALL_UNITS[self.unit]
        used = sorted({v for t in triangles for v in t})
        number = {v: n for n, v in enumerate(used)}
        points = [tuple(per_mm * (sum(vertices[v][j] * to[j][k] for j in range(3)) + shift[k]) for k in range(3))
                  for v in used]
        return points, [tuple(number[v] for v in t) for t in triangles]


def turned(points, axis, degrees):
    """About a unit vector through the origin: Rodrigues' formula."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    a, b, d = axis
    rows = ((c + a * a * (1 - c), a * b * (1 - c) - d * s, a * d * (1 - c) + b * s),
            (a * b * (1 - c) + d * s, c + b * b * (1 - c), b * d * (1 - c) - a * s),
            (a * d * (1 - c) - b * s, b * d * (1 - c) + a * s, c + d * d * (1 - c)))
    return [tuple(sum(row[k] * p[k] for k in range(3)) for row in rows) for p in points]


POSES = ("plain", "crown missing", "floating parts", "pits", "upside down", "tilt 30", "tilt 60", "noise 0.5", "noise 2")


class PosedScan:
    """A head whose pose is hard to tell, as an STL in mm. `up_vector` points to its crown in the axes of the file, `up` is
    the axis of the file nearest to it, and `turn_deg` the angle between the two. `clean` is the body before its damage."""

    def __init__(self, seed, number):
        chance = random.Random(f"{seed}/pose/{number}")
        self.pose = POSES[number % len(POSES)]
        self.name = f"{seed}-pose-{number:03d}"
        size = chance.uniform(0.55, 1.08)
        self.neck = chance.choice(("flat", "round", "open"))
        if self.pose == "crown missing" and self.neck == "open":
            self.neck = "flat"
        cell = chance.choice((5.0, 6.0, 7.0)) if self.pose != "noise 2" else 5.0
        # A round neck ends in a half ball.
        parts, floor = scan_shapes.head_parts(chance), 0.0
        if self.neck == "round":
            floor = -90.0
        body = scan_shapes.union(parts, 12, floor)
        if self.pose == "pits":
            body = scan_shapes.without(body, [self.pit(chance) for _ in range(chance.randint(4, 9))])
        mesh = scan_shapes.scaled(scan_shapes.meshed(body, (-115, -120, floor), (115, 130, 232), cell), size)
        lowest = min(p[2] for p in mesh[0])
        vertices, triangles = [(x, y, z - lowest) for x, y, z in mesh[0]], list(mesh[1])
        self.clean = vertices, triangles
        self.height = max(p[2] for p in vertices)
        if self.neck == "open":
            triangles = [t for t in triangles if max(vertices[v][2] for v in t) > 1e-3]
        if self.pose == "crown missing":
            level = self.height - chance.choice((35, 70)) * size
            triangles = [t for t in triangles if min(vertices[v][2] for v in t) < level]
        if self.pose == "floating parts":
            vertices, triangles = self.with_floating_parts(vertices, triangles, size, chance)
        self.noise = float(self.pose.split()[1]) if self.pose.startswith("noise") else 0.0
        if self.noise:
            vertices = [tuple(x + chance.gauss(0, self.noise) for x in p) for p in vertices]
        self.lowest = min(vertices[v][2] for t in triangles for v in t)  # noise goes below 0
        vertices = turned(vertices, (0, 0, 1), chance.uniform(-180, 180))
        up = (0.0, 0.0, 1.0)
        if self.pose.startswith("tilt"):
            about = math.radians(chance.uniform(0, 360))
            tilt = (math.cos(about), math.sin(about), 0), float(self.pose.split()[1])
            vertices, (up,) = turned(vertices, *tilt), turned([up], *tilt)
        to = chance.choice(("-z", "-y")) if self.pose == "upside down" else chance.choice(("+z", "+z", "+y", "+x", "-x"))
        self.up_vector = self.to_file(up, to)
        k = max(range(3), key=lambda k: abs(self.up_vector[k]))
        self.up = ("+" if self.up_vector[k] > 0 else "-") + "xyz"[k]
        self.turn_deg = math.degrees(math.acos(min(1.0, abs(self.up_vector[k]))))
        shift = [chance.uniform(-100, 100) for _ in range(3)]
        points = [tuple(x + d for x, d in zip(self.to_file(p, to), shift)) for p in vertices]
        used = sorted({v for t in triangles for v in t})
        order = {v: n for n, v in enumerate(used)}
        self.extension = "stl"
        self.data = scan_files.stl(([points[v] for v in used], [tuple(order[v] for v in t) for t in triangles]))

    @staticmethod
    def to_file(p, up):
        return tuple(sum(p[j] * AXES[up][j][k] for j in range(3)) for k in range(3))

    @staticmethod
    def pit(chance):
        """A ball on the side of the head."""
        around, z, r = chance.uniform(0, 2 * math.pi), chance.uniform(60, 170), chance.uniform(7, 14)
        return scan_shapes.ellipsoid((75 * math.cos(around), 90 * math.sin(around), z), (r, r, r))

    def with_floating_parts(self, vertices, triangles, size, chance):
        vertices, triangles = list(vertices), list(triangles)
        for _ in range(chance.randint(2, 4)):
            r = [size * chance.uniform(12, 30) for _ in range(3)]
            around, far = chance.uniform(0, 2 * math.pi), size * chance.uniform(135, 150)
            middle = far * math.cos(around), far * math.sin(around), chance.uniform(0.2, 1.1) * self.height
            part = scan_shapes.meshed(scan_shapes.ellipsoid(middle, r), [m - q for m, q in zip(middle, r)],
                                      [m + q for m, q in zip(middle, r)], 7.0 * size)
            first = len(vertices)
            vertices += part[0]
            triangles += [tuple(first + v for v in t) for t in part[1]]
        return vertices, triangles
