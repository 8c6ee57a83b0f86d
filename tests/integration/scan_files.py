"""Writers of scan files: a mesh of (vertices, triangles) as the bytes of STL, OBJ, PLY, OFF or GLB."""
import json
import struct

import meshes


def stl(mesh):
    vertices, triangles = mesh
    return meshes.stl([tuple(vertices[v] for v in t) for t in triangles])


def stl_text(mesh):
    vertices, triangles = mesh
    lines = ["solid scan"]
    for t in triangles:
        lines += ["facet normal 0 0 0", "outer loop", *("vertex %.9g %.9g %.9g" % vertices[v] for v in t), "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid scan", ""]).encode()


def obj(mesh):
    vertices, triangles = mesh
    lines = ["v %.9g %.9g %.9g" % p for p in vertices]
    lines += ["f %d %d %d" % tuple(v + 1 for v in t) for t in triangles]
    return "\n".join([*lines, ""]).encode()


def off(mesh):
    vertices, triangles = mesh
    lines = ["OFF", f"{len(vertices)} {len(triangles)} 0", *("%.9g %.9g %.9g" % p for p in vertices)]
    lines += ["3 %d %d %d" % t for t in triangles]
    return "\n".join([*lines, ""]).encode()


def ply_text(mesh):
    vertices, triangles = mesh
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}", *(f"property float {c}" for c in "xyz"),
             f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
    lines += ["%.9g %.9g %.9g" % p for p in vertices]
    lines += ["3 %d %d %d" % t for t in triangles]
    return "\n".join([*lines, ""]).encode()


def ply(mesh, order="<"):
    vertices, triangles = mesh
    name = "little" if order == "<" else "big"
    head = (f"ply\nformat binary_{name}_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\n"
            f"property float z\nelement face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    return (head.encode() + b"".join(struct.pack(order + "3f", *p) for p in vertices)
            + b"".join(struct.pack(order + "B3i", 3, *t) for t in triangles))


def ply_big_endian(mesh):
    return ply(mesh, ">")


def strips(triangles):
    """Triangle strips, in which every other triangle is flipped, joined by -1."""
    left = {}
    for number, t in enumerate(triangles):
        for k in range(3):
            left.setdefault((t[k], t[(k + 1) % 3]), []).append(number)
    used, out = [False] * len(triangles), []
    for number, t in enumerate(triangles):
        if used[number]:
            continue
        used[number] = True
        strip = list(t)
        while True:
            a, b = strip[-2:]
            edge = (a, b) if len(strip) % 2 == 0 else (b, a)
            following = next((n for n in left.get(edge, ()) if not used[n]), None)
            if following is None:
                break
            used[following] = True
            strip.append(next(v for v in triangles[following] if v not in edge))
        out += strip + [-1]
    return out[:-1]


def ply_strips(mesh):
    vertices, triangles = mesh
    numbers = strips(triangles)
    head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\n"
            "property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n")
    return (head.encode() + b"".join(struct.pack("<3f", *p) for p in vertices)
            + struct.pack(f"<i{len(numbers)}i", len(numbers), *numbers))


def glb(mesh):
    vertices, triangles = mesh
    points = b"".join(struct.pack("<3f", *p) for p in vertices)
    corners = b"".join(struct.pack("<3I", *t) for t in triangles)
    low, high = ([bound(p[k] for p in vertices) for k in range(3)] for bound in (min, max))
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3", "min": low,
                               "max": high},
                              {"bufferView": 1, "componentType": 5125, "count": 3 * len(triangles), "type": "SCALAR"}],
                "bufferViews": [{"buffer": 0, "byteLength": len(points)},
                                {"buffer": 0, "byteOffset": len(points), "byteLength": len(corners)}],
                "buffers": [{"byteLength": len(points) + len(corners)}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data = points + corners
    return (struct.pack("<4s2I", b"glTF", 2, 28 + len(text) + len(data)) + struct.pack("<I4s", len(text), b"JSON") + text
            + struct.pack("<I4s", len(data), b"BIN\0") + data)


# The extension and the writer, by the name of the format.
FORMATS = {"stl": ("stl", stl), "stl text": ("stl", stl_text), "obj": ("obj", obj), "off": ("off", off),
           "ply": ("ply", ply), "ply text": ("ply", ply_text), "ply big-endian": ("ply", ply_big_endian),
           "ply strips": ("ply", ply_strips), "glb": ("glb", glb)}
