"""Bodies of known shape for made-up scans: heads, busts, figurines, and boxes with fins and spikes.

All are in mm, upright along +z, with the face towards +y and the lowest point at z = 0. A mesh is (vertices,
triangles): points as tuples and triples of indices, closed and facing outwards. Smooth bodies are unions of simple
solids. Each solid is a function that is negative inside; marching tetrahedra mesh it (Doi and Koide 1991).
"""
import math


def ellipsoid(centre, radii):
    """The distance to an ellipsoid to first order: exact in sign, and accurate near the surface."""
    (cx, cy, cz), (rx, ry, rz) = centre, radii
    ax, ay, az = 1 / rx, 1 / ry, 1 / rz

    def distance(x, y, z):
        px, py, pz = (x - cx) * ax, (y - cy) * ay, (z - cz) * az
        k0 = math.sqrt(px * px + py * py + pz * pz)
        px, py, pz = px * ax, py * ay, pz * az
        k1 = math.sqrt(px * px + py * py + pz * pz)
        return k0 * (k0 - 1) / k1 if k1 else -min(radii)
    return distance


def capsule(a, b, radius, radius_b=None):
    """A rod with round ends, tapered if two radii are given."""
    dx, dy, dz = (b[k] - a[k] for k in range(3))
    squared, grow = dx * dx + dy * dy + dz * dz, (radius if radius_b is None else radius_b) - radius

    def distance(x, y, z):
        px, py, pz = x - a[0], y - a[1], z - a[2]
        h = min(1.0, max(0.0, (px * dx + py * dy + pz * dz) / squared))
        px, py, pz = px - h * dx, py - h * dy, pz - h * dz
        return math.sqrt(px * px + py * py + pz * pz) - radius - h * grow
    return distance


def union(parts, blend, floor=0.0):
    """The union with its creases rounded over about `blend` mm; cut flat at z = `floor`."""
    def distance(x, y, z):
        best = math.inf
        for part in parts:
            d = part(x, y, z)
            if best == math.inf:
                best = d
                continue
            h = blend - abs(best - d)
            best = min(best, d) - (h * h / (4 * blend) if h > 0 else 0)
        return max(best, floor - z)
    return distance


def without(body, parts):
    """The body with other bodies taken out of it."""
    def distance(x, y, z):
        return max(body(x, y, z), -min(part(x, y, z) for part in parts))
    return distance


# A cube in six tetrahedra around its diagonal: neighbouring cubes agree on their shared faces.
CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1), (1, 1, 1)]
TETRAHEDRA = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]


class Marching:
    """The zero level of a function on a lattice."""

    def __init__(self, distance, low, cell):
        self.distance, self.low, self.cell = distance, low, cell
        self.values, self.on_edge, self.vertices, self.triangles = {}, {}, [], []

    def place(self, node):
        return tuple(self.low[k] + node[k] * self.cell for k in range(3))

    def value(self, node):
        value = self.values.get(node)
        if value is None:
            value = self.distance(*self.place(node))
            if abs(value) < 0.02 * self.cell:  # no vertices at the same point
                value = math.copysign(0.02 * self.cell, value)
            self.values[node] = value
        return value

    def block(self, at, count):
        """Visits only the cubes near the surface."""
        half = count / 2
        middle = tuple(self.low[k] + (at[k] + half) * self.cell for k in range(3))
        if abs(self.distance(*middle)) > 2.2 * half * self.cell:
            return
        if count == 1:
            self.cube(at)
            return
        step = count // 2
        for dx, dy, dz in CORNERS:
            self.block((at[0] + dx * step, at[1] + dy * step, at[2] + dz * step), step)

    def cube(self, at):
        nodes = [(at[0] + dx, at[1] + dy, at[2] + dz) for dx, dy, dz in CORNERS]
        values = [self.value(n) for n in nodes]
        if min(values) > 0 or max(values) < 0:
            return
        for tetrahedron in TETRAHEDRA:
            inside = [k for k in tetrahedron if values[k] < 0]
            outside = [k for k in tetrahedron if values[k] > 0]
            if not inside or not outside:
                continue

            def cut(i, o):
                return self.crossing(nodes[i], nodes[o], values[i], values[o])
            if len(inside) == 1:
                corners = [cut(inside[0], o) for o in outside]
            elif len(outside) == 1:
                corners = [cut(i, outside[0]) for i in inside]
            else:
                (i, j), (o, p) = inside, outside
                corners = [cut(i, o), cut(i, p), cut(j, p), cut(j, o)]
            self.add(corners, self.place(nodes[inside[0]]))

    def crossing(self, a, b, fa, fb):
        key = (a, b) if a < b else (b, a)
        number = self.on_edge.get(key)
        if number is None:
            t = fa / (fa - fb)
            p, q = self.place(a), self.place(b)
            number = self.on_edge[key] = len(self.vertices)
            self.vertices.append(tuple(p[k] + t * (q[k] - p[k]) for k in range(3)))
        return number

    def add(self, corners, inner):
        """The polygon, facing away from a point inside."""
        a, b, c = (self.vertices[n] for n in corners[:3])
        u, v, w = ([q[k] - a[k] for k in range(3)] for q in (b, c, inner))
        volume = (u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2])
                  + u[2] * (v[0] * w[1] - v[1] * w[0]))
        if volume > 0:
            corners = corners[::-1]
        for k in range(1, len(corners) - 1):
            self.triangles.append((corners[0], corners[k], corners[k + 1]))


def meshed(distance, low, high, cell):
    """The surface of a body between two corners."""
    count = 1
    while count * cell < max(high[k] - low[k] for k in range(3)) + 2 * cell:
        count *= 2
    marching = Marching(distance, tuple(x - 1.37 * cell for x in low), cell)
    marching.block((0, 0, 0), count)
    return marching.vertices, marching.triangles


def scaled(mesh, factor):
    return [tuple(factor * x for x in p) for p in mesh[0]], mesh[1]


def head_parts(chance, lift=0.0):
    """A skull, a face with nose and chin, two ears and a neck, raised by `lift` mm."""
    wide, deep, nose, ear = (chance.uniform(*r) for r in ((68, 80), (84, 100), (5, 16), (3, 14)))
    parts = [ellipsoid((0, -5, 148 + lift), (wide, deep, 80)), ellipsoid((0, 22, 105 + lift), (0.75 * wide, 66, 72)),
             capsule((0, 84, 122 + lift), (0, 86 + nose, 100 + lift), 7, 10), ellipsoid((0, 62, 52 + lift), (26, 24, 18)),
             capsule((0, -14, -30), (0, -8, 110 + lift), 50)]
    for side in -1, 1:
        parts.append(ellipsoid((side * (wide + 0.4 * ear), -2, 118 + lift), (ear, 15, 28)))
    return parts


def head(chance):
    cell = chance.choice([6.0, 7.0, 9.0])
    mesh = meshed(union(head_parts(chance), 12), (-110, -115, 0), (110, 125, 232), cell)
    return scaled(mesh, chance.uniform(0.55, 1.08))


def bust(chance):
    lift = chance.uniform(85, 110)
    parts = head_parts(chance, lift)
    wide = chance.uniform(95, 130)
    parts += [capsule((-wide, -12, 55), (wide, -12, 55), 48), ellipsoid((0, 0, 20), (wide + 20, 75, 90))]
    mesh = meshed(union(parts, 20), (-190, -130, 0), (190, 135, 345), 10.0)
    return scaled(mesh, chance.uniform(0.3, 1.35))


def figurine(chance):
    """A standing figure 150 mm high on a round foot, with thin arms and legs."""
    thin, spread, raise_ = chance.uniform(2.2, 5), chance.uniform(18, 45), chance.uniform(-30, 40)
    parts = [ellipsoid((0, 0, 3), (32, 28, 5)), ellipsoid((0, 0, 85), (17, 12, 30)), ellipsoid((0, 1, 132), (13, 15, 17)),
             capsule((0, 0, 105), (0, 0, 125), 6)]
    for side in -1, 1:
        parts.append(capsule((side * 9, 0, 68), (side * 13, 0, 3), thin + 2, thin + 1))
        parts.append(capsule((side * 13, 0, 105), (side * (13 + spread), 8, 105 + raise_), thin))
    mesh = meshed(union(parts, 5), (-68, -32, -3), (68, 32, 160), 2.8)
    return scaled(mesh, chance.uniform(0.4, 1.5))


def joined(bodies):
    vertices, triangles = [], []
    for points, faces in bodies:
        first = len(vertices)
        vertices += points
        triangles += [tuple(first + v for v in t) for t in faces]
    return vertices, triangles


def block(low, high, cell):
    """A closed box whose faces are grids of about `cell` mm."""
    counts = [max(1, round((high[k] - low[k]) / cell)) for k in range(3)]
    numbers, vertices, triangles = {}, [], []

    def vertex(node):
        if node not in numbers:
            numbers[node] = len(vertices)
            vertices.append(tuple(low[k] + (high[k] - low[k]) * node[k] / counts[k] for k in range(3)))
        return numbers[node]
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for level in 0, counts[axis]:
            for i in range(counts[u]):
                for j in range(counts[v]):
                    corners = []
                    for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        node = [0, 0, 0]
                        node[axis], node[u], node[v] = level, i + di, j + dj
                        corners.append(vertex(tuple(node)))
                    a, b, c, d = corners if level else corners[::-1]
                    triangles += [(a, b, c), (a, c, d)]
    return vertices, triangles


def spike(x, y, z, radius, height, sectors=16):
    """A closed cone that starts 2 mm below the height z."""
    around = [(x + radius * math.cos(2 * math.pi * k / sectors), y + radius * math.sin(2 * math.pi * k / sectors), z - 2)
              for k in range(sectors)]
    triangles = []
    for k in range(sectors):
        after = (k + 1) % sectors
        triangles += [(k, after, sectors), (after, k, sectors + 1)]
    return around + [(x, y, z + height), (x, y, z - 2)], triangles


def box(chance):
    """A block, in some cases higher than wide, with fins and spikes on its top, each a separate closed body."""
    w, d, h = chance.uniform(60, 150), chance.uniform(50, 120), chance.uniform(20, 90)
    bodies = [block((-w / 2, -d / 2, 0), (w / 2, d / 2, h), 7)]
    for _ in range(chance.randint(0, 3)):
        thick, long, tall = chance.uniform(0.8, 5), chance.uniform(0.3, 0.9) * d, chance.uniform(4, 25)
        x, y = chance.uniform(-0.4, 0.4) * w, chance.uniform(-0.05, 0.05) * d
        bodies.append(block((x - thick / 2, y - long / 2, h - 2), (x + thick / 2, y + long / 2, h + tall), 7))
    for _ in range(chance.randint(0, 3)):
        bodies.append(spike(chance.uniform(-0.4, 0.4) * w, chance.uniform(-0.4, 0.4) * d, h, chance.uniform(1.5, 6),
                            chance.uniform(5, 30)))
    return joined(bodies)


KINDS = {"head": head, "bust": bust, "figurine": figurine, "box": box}
