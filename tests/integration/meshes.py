"""An independent reading of the artifacts, by DESIGN's definitions and without a line of Vacuform's own code."""
import math
import struct


class Ply:
    """formed.ply: `vertices` as dicts of lists by property, `faces` as triples."""

    def __init__(self, data):
        head, _, body = data.partition(b"end_header\n")
        lines = head.decode("ascii").splitlines()
        assert lines[:2] == ["ply", "format binary_little_endian 1.0"], lines[:2]
        names, types, counts, element = [], "", {}, None
        for line in lines[2:]:
            words = line.split()
            if words[0] == "element":
                element = words[1]
                counts[element] = int(words[2])
            elif words[0] == "property" and element == "vertex":
                names.append(words[2])
                types += {"float": "f", "uchar": "B"}[words[1]]
            elif words[0] == "property":
                assert words[1:] == ["list", "uchar", "int", "vertex_indices"], line
        vertex = struct.Struct("<" + types)
        rows = [vertex.unpack_from(body, i * vertex.size) for i in range(counts["vertex"])]
        self.vertices = dict(zip(names, zip(*rows)))
        self.types = dict(zip(names, types))
        at = counts["vertex"] * vertex.size
        face = struct.Struct("<B3i")
        faces = [face.unpack_from(body, at + i * face.size) for i in range(counts["face"])]
        assert all(f[0] == 3 for f in faces)
        assert at + counts["face"] * face.size == len(body), "bytes are left over"
        self.faces = [f[1:] for f in faces]
        self.points = list(zip(self.vertices["x"], self.vertices["y"], self.vertices["z"]))


def read_stl(data):
    """Binary STL as triangles of points."""
    (count,) = struct.unpack_from("<I", data, 80)
    assert len(data) == 84 + 50 * count
    triangles = []
    for i in range(count):
        n = struct.unpack_from("<12f", data, 84 + 50 * i)
        triangles.append((n[3:6], n[6:9], n[9:12]))
    return triangles


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def area(a, b, c):
    n = cross(sub(b, a), sub(c, a))
    return math.sqrt(dot(n, n)) / 2


def flat_area(a, b, c):
    """Signed."""
    return ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2


def singular_values(flat, solid):
    """Of the linear map that takes the flat triangle to the one in space."""
    (ax, ay), (bx, by) = [(p[0] - flat[0][0], p[1] - flat[0][1]) for p in flat[1:]]
    d = ax * by - ay * bx
    e, f = sub(solid[1], solid[0]), sub(solid[2], solid[0])
    u = tuple((by * e[k] - ay * f[k]) / d for k in range(3))  # the image of (1, 0)
    v = tuple((ax * f[k] - bx * e[k]) / d for k in range(3))  # the image of (0, 1)
    trace, det = dot(u, u) + dot(v, v), dot(u, u) * dot(v, v) - dot(u, v) ** 2
    root = math.sqrt(max(trace * trace / 4 - det, 0))
    return math.sqrt(trace / 2 + root), math.sqrt(max(trace / 2 - root, 0))


def distortion(flat, solid, faces):
    """Area-weighted means and 95th percentiles of shape and area distortion over the faces."""
    rows = []
    for face in faces:
        corners = [solid[i] for i in face]
        s1, s2 = singular_values([flat[i] for i in face], corners)
        rows.append((area(*corners), s1 / s2, max(s1 * s2, 1 / (s1 * s2))))
    whole = sum(r[0] for r in rows)

    def statistics(k):
        mean = sum(r[0] * r[k] for r in rows) / whole
        below = 0
        for r in sorted(rows, key=lambda r: r[k]):
            below += r[0]
            if below >= 0.95 * whole:
                return {"mean": mean, "p95": r[k]}
    return {"shape": statistics(1), "area": statistics(2)}


def vertex_normals(points, faces):
    """Unit normals, weighted by area."""
    sums = [[0.0, 0.0, 0.0] for _ in points]
    for a, b, c in faces:
        n = cross(sub(points[b], points[a]), sub(points[c], points[a]))
        for i in (a, b, c):
            for k in range(3):
                sums[i][k] += n[k]
    return [tuple(x / (math.sqrt(dot(s, s)) or 1) for x in s) for s in sums]


def distance(p, triangle):
    """From a point to a triangle (Ericson, Real-Time Collision Detection, 5.1.5)."""
    a, b, c = triangle
    ab, ac, ap = sub(b, a), sub(c, a), sub(p, a)
    d1, d2 = dot(ab, ap), dot(ac, ap)
    bp = sub(p, b)
    d3, d4 = dot(ab, bp), dot(ac, bp)
    cp = sub(p, c)
    d5, d6 = dot(ab, cp), dot(ac, cp)
    vc, vb, va = d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4
    if d1 <= 0 and d2 <= 0:
        q = a
    elif d3 >= 0 and d4 <= d3:
        q = b
    elif d6 >= 0 and d5 <= d6:
        q = c
    elif vc <= 0 <= d1 and d3 <= 0:
        q = tuple(a[k] + ab[k] * d1 / (d1 - d3) for k in range(3))
    elif vb <= 0 <= d2 and d6 <= 0:
        q = tuple(a[k] + ac[k] * d2 / (d2 - d6) for k in range(3))
    elif va <= 0 and d4 >= d3 and d5 >= d6:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        q = tuple(b[k] + (c[k] - b[k]) * w for k in range(3))
    else:
        w = va + vb + vc
        q = tuple(a[k] + ab[k] * vb / w + ac[k] * vc / w for k in range(3)) if w else a
    return math.dist(p, q)


class Near:
    """Finds the distance to a surface where it is at most `reach`; infinity beyond."""

    def __init__(self, triangles, reach):
        self.triangles, self.reach, self.size = triangles, reach, 4.0
        self.cells = {}
        for t in triangles:
            low = [math.floor((min(p[k] for p in t) - reach) / self.size) for k in range(3)]
            high = [math.floor((max(p[k] for p in t) + reach) / self.size) for k in range(3)]
            for i in range(low[0], high[0] + 1):
                for j in range(low[1], high[1] + 1):
                    for k in range(low[2], high[2] + 1):
                        self.cells.setdefault((i, j, k), []).append(t)

    def __call__(self, p):
        cell = tuple(math.floor(x / self.size) for x in p)
        best = math.inf
        for t in self.cells.get(cell, ()):
            best = min(best, distance(p, t))
        return best if best <= self.reach else math.inf


def edges_closed(triangles):
    """Whether every edge of the soup has its counterpart, once each way (points compared exactly)."""
    seen = {}
    for t in triangles:
        for i in range(3):
            edge = (t[i], t[(i + 1) % 3])
            seen[edge] = seen.get(edge, 0) + 1
    return all(n == seen.get((b, a), 0) for (a, b), n in seen.items())


# Molds of known shape, watertight, in mm, with the platform under z = 0: triangles of points, outwards.


def stl(triangles):
    """Binary STL."""
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *(x for p in t for x in p), 0) for t in triangles)
    return b"".ljust(80) + struct.pack("<I", len(triangles)) + body


def revolved(profile, sectors=360):
    """The solid that the profile, (radius, z) from its bottom on the axis to its top on the axis, sweeps around the axis."""
    around = [(math.cos(2 * math.pi * k / sectors), math.sin(2 * math.pi * k / sectors)) for k in range(sectors)]
    triangles = []
    for (r0, z0), (r1, z1) in zip(profile, profile[1:]):
        for (c, s), (d, e) in zip(around, around[1:] + around[:1]):
            a, b, p, q = (r0 * c, r0 * s, z0), (r0 * d, r0 * e, z0), (r1 * c, r1 * s, z1), (r1 * d, r1 * e, z1)
            if r0 > 0:
                triangles.append((a, b, q if r1 > 0 else p))
            if r1 > 0:
                triangles.append((a, q, p))
    return triangles


def hemisphere(radius, rings=180, sectors=360):
    """A male half ball."""
    arc = [(radius * math.sin(a), radius * math.cos(a))
           for a in (math.pi / 2 * (rings - i) / rings for i in range(rings))]
    return revolved([(0, 0), *arc, (0, radius)], sectors)


def male_cone(radius, angle_deg, sectors=360):
    """A cone whose slope makes the angle with the platform."""
    return revolved([(0, 0), (radius, 0), (0, radius * math.tan(math.radians(angle_deg)))], sectors)


def female_cone(radius, angle_deg, land, floor=5, sectors=360):
    """A round block with a conical pit in its top, whose wall makes the angle with the flat sheet; `land` around it."""
    top = floor + radius * math.tan(math.radians(angle_deg))
    return revolved([(0, 0), (radius + land, 0), (radius + land, top), (radius, top), (0, floor)], sectors)


def groove(half_width, depth, length, land, floor_half_width=0.0, floor=5):
    """A block with a groove along y in its top, closed by upright walls at its ends: a V, or with a flat floor.

    `land` is around it on all sides.
    """
    w, f, l, top = half_width, floor_half_width, length / 2, floor + depth
    triangles = []

    def quad(*p):
        triangles.extend(t for t in ((p[0], p[1], p[2]), (p[0], p[2], p[3])) if len(set(t)) == 3)

    outline = [(x * (w + land), y * (l + land)) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    rim = [(-w, -l), (w, -l), (w, l), (-w, l)]
    bottom = [(-f, -l), (f, -l), (f, l), (-f, l)]
    quad(*[(*c, 0) for c in outline[::-1]])
    quad(*[(*c, floor) for c in bottom])
    for i, j in (0, 1), (1, 2), (2, 3), (3, 0):
        quad((*outline[i], 0), (*outline[j], 0), (*outline[j], top), (*outline[i], top))
        quad((*outline[i], top), (*outline[j], top), (*rim[j], top), (*rim[i], top))
        quad((*rim[i], top), (*rim[j], top), (*bottom[j], floor), (*bottom[i], floor))
    return triangles
