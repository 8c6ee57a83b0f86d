"""A head that shows which way it faces: a red nose at +y, a green ear at the patient's left (-x) and none at the right, and a
blue F on the crown (+z), read from above with the face at the top. It stands on z = 0 without undercuts, off centre."""
import functools
import itertools
import struct

import scan_shapes

RED, GREEN, BLUE, SKIN = (200, 20, 20), (20, 170, 30), (20, 40, 200), (205, 200, 190)


def colour(p):
    x, y, z = p
    if y > 84 and abs(x) < 20:
        return RED
    if x < -68 and -25 < y < 30:
        return GREEN
    stroke = -14 <= x <= -6 and -20 <= y <= 20
    arms = -14 <= x <= 16 and (12 <= y <= 20 or -3 <= y <= 4)
    return BLUE if z > 50 and (stroke or arms) else SKIN


@functools.cache
def head():
    """Vertices in mm and triangles. Front +y, left -x, crown +z."""
    parts = [scan_shapes.ellipsoid((0, 0, 0), (68, 86, 88)), scan_shapes.capsule((0, 84, -20), (0, 84, 26), 14, 11),
             scan_shapes.capsule((-66, 4, -20), (-66, 4, 24), 13, 11)]
    vertices, triangles = scan_shapes.meshed(scan_shapes.union(parts, 8), (-90, -100, -40), (90, 110, 100), 4.5)
    return [(x, y, z) for x, y, z in vertices], triangles


def poses():
    """The 24 turns of a file, as rows of a matrix."""
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((1, -1), repeat=3):
            rows = [[signs[i] if j == order[i] else 0 for j in range(3)] for i in range(3)]
            if determinant(rows) == 1:
                yield rows


def determinant(m):
    return sum(m[0][i] * (m[1][(i + 1) % 3] * m[2][(i + 2) % 3] - m[1][(i + 2) % 3] * m[2][(i + 1) % 3]) for i in range(3))


def times(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


UPRIGHT = {"+z": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "-z": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
           "+y": [[1, 0, 0], [0, 0, -1], [0, 1, 0]], "-y": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
           "+x": [[0, 0, -1], [0, 1, 0], [1, 0, 0]], "-x": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]}
FRONT = {"+y": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "+x": [[0, -1, 0], [1, 0, 0], [0, 0, 1]],
         "-y": [[-1, 0, 0], [0, -1, 0], [0, 0, 1]], "-x": [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]}
MIRROR = [[-1, 0, 0], [0, 1, 0], [0, 0, 1]]


def settings_for(pose, mirrored):
    """What docs/how-to/scan.md asks for, so that the head of a turned file stands upright, faces +y and has its left at -x."""
    whole = times(pose, MIRROR) if mirrored else pose
    for up, front in itertools.product(UPRIGHT, FRONT):
        placed = times(UPRIGHT[up], whole)
        if mirrored:
            placed = times(MIRROR, placed)
        if times(FRONT[front], placed) == FRONT["+y"]:
            return {"up": up, "front": front, "mirror": "yes" if mirrored else "no", "units": "mm"}
    raise AssertionError(pose)


def turned(pose, mirrored=False, shift=(37.0, -112.0, 55.0)):
    vertices, triangles = head()
    whole = times(pose, MIRROR) if mirrored else pose
    out = [tuple(sum(whole[i][j] * p[j] for j in range(3)) + shift[i] for i in range(3)) for p in vertices]
    return out, [t[::-1] for t in triangles] if mirrored else triangles


def painted_ply(pose, mirrored=False):
    vertices, triangles = turned(pose, mirrored)
    colours = [colour(p) for p in head()[0]]
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}",
             *(f"property float {axis}" for axis in "xyz"), *(f"property uchar {c}" for c in ("red", "green", "blue")),
             f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header", ""]
    return ("\n".join(lines).encode() + b"".join(struct.pack("<3f3B", *p, *c) for p, c in zip(vertices, colours)) +
            b"".join(struct.pack("<B3i", 3, *t) for t in triangles))
