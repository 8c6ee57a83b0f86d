"""Hostile and broken files, assembled byte by byte. Each is a function, so that large ones are only built when they are
used."""
import json
import math
import struct
import zlib


def dome(radius=45.0, n=24, rows=8):
    """A closed hemisphere on its flat side, like a good scan. Points and triangles, facing outwards."""
    points = []
    for i in range(rows):
        a = math.pi / 2 * i / rows
        points += [(radius * math.cos(a) * math.cos(2 * math.pi * j / n), radius * math.cos(a) * math.sin(2 * math.pi * j / n),
                    radius * math.sin(a)) for j in range(n)]
    top, bottom = len(points), len(points) + 1
    points += [(0, 0, radius), (0, 0, 0)]
    faces = []
    for j in range(n):
        k = (j + 1) % n
        for i in range(rows - 1):
            a, b, c, d = i * n + j, i * n + k, (i + 1) * n + k, (i + 1) * n + j
            faces += [(a, b, c), (a, c, d)]
        faces += [((rows - 1) * n + j, (rows - 1) * n + k, top), (k, j, bottom)]
    return points, faces


def stl(triangles, header=b"", count=None):
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *(x for p in t for x in p), 0) for t in triangles)
    return header.ljust(80, b" ") + struct.pack("<I", len(triangles) if count is None else count) + body


def dome_triangles(scale=1.0, **shape):
    points, faces = dome(**shape)
    return [tuple(tuple(scale * x for x in points[i]) for i in f) for f in faces]


def ascii_stl(triangles, name="head"):
    lines = [f"solid {name}"]
    for t in triangles:
        lines += ["facet normal 0 0 0", "outer loop", *("vertex " + " ".join(map(str, p)) for p in t), "endloop", "endfacet"]
    return "\n".join([*lines, f"endsolid {name}"]).encode()


def obj(faces=None, points=None, end="\n"):
    p, f = dome()
    lines = ["v %r %r %r" % q for q in (points or p)]
    lines += ["f " + " ".join(str(i) for i in g) for g in (faces or [[i + 1 for i in t] for t in f])]
    return ("\n".join(lines) + end).encode()


def ply(order="<", vertices=None, faces=None, list_length=None, kind="float"):
    points, triangles = dome()
    name = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    head = (f"ply\nformat {name} 1.0\nelement vertex {vertices or len(points)}\nproperty {kind} x\nproperty float y\n"
            f"property float z\nelement face {faces or len(triangles)}\nproperty list int int vertex_indices\nend_header\n")
    return (head.encode() + b"".join(struct.pack(order + "3f", *p) for p in points) +
            b"".join(struct.pack(order + "4i", list_length or 3, *t) for t in triangles))


def glb(document, binary=b""):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    if binary:
        chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def meshopt():
    return glb({"asset": {"version": "2.0"}, "extensionsRequired": ["EXT_meshopt_compression"],
                "extensionsUsed": ["EXT_meshopt_compression"], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
                "accessors": [{"componentType": 5126, "type": "VEC3", "count": 3}]})


def icc(space=b"RGB ", gamma=2.2, red=(0.6097, 0.3111, 0.0195), green=(0.2053, 0.6257, 0.0609), blue=(0.1492, 0.0632, 0.7446)):
    """An ICC profile of version 2 with a matrix and one gamma; by default that of Adobe RGB (1998)."""
    def xyz(values):
        return b"XYZ " + bytes(4) + struct.pack(">3i", *(round(v * 65536) for v in values))
    curve = b"curv" + bytes(4) + struct.pack(">IH", 1, round(gamma * 256)) + bytes(2)
    tags = {b"wtpt": xyz((0.9642, 1, 0.8249)), b"rXYZ": xyz(red), b"gXYZ": xyz(green), b"bXYZ": xyz(blue),
            b"rTRC": curve, b"gTRC": curve, b"bTRC": curve}
    table, data, at = struct.pack(">I", len(tags)), b"", 128 + 4 + 12 * len(tags)
    for name, content in tags.items():
        table += struct.pack(">4sII", name, at + len(data), len(content))
        data += content
    head = struct.pack(">I4sI4s4s4s12s4s", at + len(data), bytes(4), 0x02400000, b"mntr", space, b"XYZ ", bytes(12), b"acsp")
    head += bytes(28) + struct.pack(">3i", 63190, 65536, 54061)  # of D50
    return head.ljust(128, bytes(1)) + table + data


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width, height, rows=None, extra=b""):
    data = zlib.compress(rows if rows is not None else b"\0" * (height * (1 + (width + 7) // 8)), 9)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)) +
            chunk(b"pHYs", struct.pack(">IIB", 11811, 11811, 1)) + extra + chunk(b"IDAT", data) + chunk(b"IEND", b""))


def svg(inner, root='width="100mm" height="100mm" viewBox="0 0 100 100"', prolog=""):
    return f'{prolog}<svg xmlns="http://www.w3.org/2000/svg" {root}>{inner}</svg>'.encode()


GOOD_SVG = svg('<circle cx="50" cy="50" r="20" fill="none" stroke="black" stroke-width="2"/>')
NAN, INF = float("nan"), float("inf")


def moved(triangles, place):
    """The triangles, with their first corner moved to the given point."""
    return [(place, *triangles[0][1:]), *triangles[1:]]


# name: (type of the problem or None without a problem, part of its text, extension, bytes)
SCANS = {
    "binary STL whose count wraps in 32 bits": ("corrupt-file", "85899346 triangles, which take 4294967384 bytes, but it has 88", "stl", lambda: stl([dome_triangles()[0]], count=85899346)[:88]),
    "binary STL that is cut short": ("corrupt-file", "384 triangles, which take 19284 bytes, but it has 19224", "stl", lambda: stl(dome_triangles())[:-60]),
    "binary STL that promises more": ("corrupt-file", "1000000 triangles", "stl", lambda: stl(dome_triangles(), count=10**6)),
    "STL without a triangle": ("unusable-scan", "no triangles", "stl", lambda: stl([])),
    "STL of one triangle": ("ambiguous-units", "cm (116 mm), in (296 mm)", "stl", lambda: stl(dome_triangles()[:1])),
    "STL with a coordinate that is no number": ("corrupt-file", "not a finite number", "stl", lambda: stl(moved(dome_triangles(), (NAN, 0, 0)))),
    "STL with an infinite coordinate": ("corrupt-file", "not a finite number", "stl", lambda: stl(moved(dome_triangles(), (0, INF, 0)))),
    "STL with a coordinate of 1e30": ("corrupt-file", "beyond 10,000,000", "stl", lambda: stl(moved(dome_triangles(), (0, 0, 1e30)))),
    "STL of denormals": ("ambiguous-units", "0.0 mm", "stl", lambda: stl(dome_triangles(scale=1e-42))),
    "STL all in one point": ("unusable-scan", "without area", "stl", lambda: stl([((1, 2, 3),) * 3] * 1000)),
    "STL that is flat": ("unusable-scan", "would remain as a mold", "stl", lambda: stl([((i, 0, 0), (i + 1, 0, 0), (i, 100, 0)) for i in range(100)])),
    "ASCII STL with a word for a number": ("corrupt-file", "three numbers", "stl", lambda: ascii_stl(dome_triangles()).replace(b"vertex 45.0", b"vertex head", 1)),
    "ASCII STL that is cut short": ("corrupt-file", "ends within a facet", "stl", lambda: ascii_stl(dome_triangles())[:-100]),
    "OBJ with an index past the end": ("corrupt-file", "names vertex 999999, but the file has 194", "obj", lambda: obj(faces=[[1, 2, 999999]])),
    "OBJ with a negative index past the start": ("corrupt-file", "names vertex -999999", "obj", lambda: obj(faces=[[-1, -2, -999999]])),
    "OBJ with index zero": ("corrupt-file", "not a corner of a face", "obj", lambda: obj(faces=[[0, 1, 2]])),
    "OBJ with a huge index": ("corrupt-file", "not a corner of a face", "obj", lambda: obj(faces=[[1, 2, 10**30]])),
    "OBJ without a face": ("unusable-scan", "point cloud", "obj", lambda: b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"),
    "PLY that promises 10^18 vertices": ("corrupt-file", "1000000000000000000", "ply", lambda: ply(vertices=10**18)),
    "PLY that promises 2^63 faces": ("corrupt-file", "how many", "ply", lambda: ply(faces=2**63)),
    "PLY with a list of 2^31-1 corners": ("corrupt-file", "longer than the file", "ply", lambda: ply(list_length=2**31 - 1)),
    "PLY with a list of -1 corners": ("corrupt-file", "a list of the PLY file", "ply", lambda: ply(list_length=-1)),
    "PLY with a type of its own": ("corrupt-file", "unknown PLY property type", "ply", lambda: ply(kind="quad")),
    "PLY that is cut short": ("corrupt-file", "ends within its data", "ply", lambda: ply()[:-7]),
    "PLY without an end of its header": ("corrupt-file", "no end_header", "ply", lambda: b"ply\nformat ascii 1.0\nelement vertex 3\n" + b"comment x\n" * 10**5),
    "OFF that promises more": ("corrupt-file", "4000000000 vertices", "off", lambda: b"OFF\n4000000000 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
    "GLB compressed by meshopt": ("unsupported-format", "EXT_meshopt_compression", "glb", meshopt),
    "GLB that is cut short": ("corrupt-file", "says it has 280 bytes, but it has 260", "glb", lambda: meshopt()[:-20]),
    "GLB whose chunk is longer than the file": ("corrupt-file", "GLB", "glb", lambda: b"glTF" + struct.pack("<II", 2, 20) + struct.pack("<I4s", 2**32 - 1, b"JSON")),
    "GLB with an accessor past its buffer": ("corrupt-file", "2147483648 elements", "glb", lambda: glb({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "buffers": [{"byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 2**31}]}, b"\0" * 36)),
    "GLB whose nodes are their own children": ("corrupt-file", "do not form a tree", "glb", lambda: glb({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"children": [0]}]})),
    "binary STL that begins with solid": (None, "", "stl", lambda: stl(dome_triangles(), header=b"solid head")),
    "PLY in big-endian order": (None, "", "ply", lambda: ply(order=">")),
    "OBJ with negative indices and no final newline": (None, "", "obj", lambda: obj(
        faces=[[i - len(dome()[0]) for i in f] for f in dome()[1]], end="")),
    "OBJ with a face of thousands of corners": (None, "", "obj", lambda: obj(
        points=[*dome(n=1500, rows=3)[0]], faces=[[i + 1 for i in f] for f in dome(n=1500, rows=3)[1] if 4501 not in f] + [
            [1500 - j for j in range(1500)]])),
    "ASCII STL with a name of a megabyte": (None, "", "stl", lambda: ascii_stl(dome_triangles(), name="x" * 10**6)),
    "STL inside out": (None, "", "stl", lambda: stl([t[::-1] for t in dome_triangles()])),
    "STL of ten thousand crumbs and a head": (None, "", "stl", lambda: stl(dome_triangles() + [
        tuple((30 + 0.1 * k, i * 0.001, 5 + 0.2 * (k == 1)) for k in range(3)) for i in range(10000)])),
    "text": ("corrupt-file", "but it has 3100 bytes", "stl", lambda: b"This is a letter, and no scan.\n" * 100),
    "picture for a scan": ("unsupported-format", "a picture", "stl", lambda: png(100, 100)),
    "zip for a scan": ("unsupported-format", "ZIP", "obj", lambda: b"PK\x03\x04" + b"\0" * 1000),
}

PATTERNS = {
    "PNG of 2^31-1 squared pixels": ("too-large", "2147483647 x 2147483647 pixels", "png", lambda: png(2**31 - 1, 2**31 - 1, rows=b"\0" * 1000)),
    "PNG that is cut short": ("corrupt-file", "PNG is damaged", "png", lambda: png(2000, 2000)[:60]),
    "PNG with a wrong checksum": ("corrupt-file", "CRC", "png", lambda: png(100, 100).replace(b"IDAT", b"IDAU")),
    "PNG of 30000 squared pixels in few bytes": ("too-large", "30000 x 30000 pixels", "png", lambda: png(30000, 30000)),
    "PNG with a text that inflates to 100 MB": (None, "", "png", lambda: png(
        100, 100, extra=chunk(b"zTXt", b"bomb\0\0" + zlib.compress(b"\0" * 10**8, 9)))),
    "PNG with a profile that inflates to 100 MB": (None, "", "png", lambda: png(
        100, 100, extra=chunk(b"iCCP", b"bomb\0\0" + zlib.compress(b"\0" * 10**8, 9)))),
    "PNG of nothing but white": ("unusable-pattern", "empty", "png", lambda: png(100, 100, rows=b"\0" + b"".join(b"\xff" * 13 + b"\0" for _ in range(100))[:-1])),
    "JPEG that is cut short": ("corrupt-file", "JPEG is damaged", "jpg", lambda: b"\xff\xd8\xff\xe0\0\x10JFIF\0\1\1\1\1\x2c\1\x2c\0\0" + b"\xff\xdb\0\x43"),
    "SVG that is not XML": ("corrupt-file", "SVG cannot be read", "svg", lambda: b"<svg xmlns='http://www.w3.org/2000/svg'><g></svg>"),
    "SVG with nothing in it": ("unusable-pattern", "empty", "svg", lambda: svg("")),
    "SVG whose entities multiply": ("unsupported-format", "declares parts of the drawing", "svg", lambda: svg(
        "<text>&j;</text>", prolog='<!DOCTYPE svg [<!ENTITY a "aaaaaaaaaa">' + "".join(
            f'<!ENTITY {b} "{("&" + a + ";") * 10}">' for a, b in zip("abcdefghi", "bcdefghij")) + "]>")),
    "SVG that reads a file of the machine": ("unsupported-format", "declares parts of the drawing", "svg", lambda: svg(
        "<text>&x;</text>", prolog='<!DOCTYPE svg [<!ENTITY x SYSTEM "file:///etc/passwd">]>')),
    "SVG of a million metres": ("unusable-pattern", "1000000000 x 1000000000 mm", "svg", lambda: svg("<rect width='1' height='1'/>", root='width="1e9mm" height="1e9mm"')),
    "scan for a pattern": ("unsupported-format", "neither PNG, JPEG, SVG nor DXF", "svg", lambda: stl(dome_triangles())),
    "text for a pattern": ("unsupported-format", "neither PNG, JPEG, SVG nor DXF", "png", lambda: b"a letter\n" * 100),
}
