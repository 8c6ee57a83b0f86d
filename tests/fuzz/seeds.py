"""Makes the inputs that fuzzing begins with, one folder a target: small whole files of every kind, and the hostile ones of
the integration tests.

    seeds.py FOLDER
"""
import base64
import io
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import zipfile
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "integration"))
import hostile  # noqa: E402

SMALL = {"n": 8, "rows": 4}


def small_dome():
    return hostile.dome(**SMALL)


def triangles(**shape):
    return hostile.dome_triangles(**(SMALL | shape))


def off(points, faces):
    lines = ["OFF", f"{len(points)} {len(faces)} 0", *(" ".join("%g" % x for x in p) for p in points)]
    return "\n".join([*lines, *("3 %d %d %d" % f for f in faces), ""]).encode()


def ascii_ply(points, faces):
    lines = ["ply", "format ascii 1.0", "comment of our own", f"element vertex {len(points)}", "property float x",
             "property float y", "property float z", f"element face {len(faces)}", "property list uchar int vertex_indices",
             "end_header", *("%g %g %g" % p for p in points), *("3 %d %d %d" % f for f in faces), ""]
    return "\n".join(lines).encode()


def archive(files, method=zipfile.ZIP_DEFLATED):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as packed:
        for name, data in files.items():
            packed.writestr(zipfile.ZipInfo(name), data, method)
    return out.getvalue()


def zips():
    points, faces = small_dome()
    obj = "mtllib a.mtl\n" + "".join("v %g %g %g\n" % p for p in points) + "".join("vt %g %g\n" % p[:2] for p in points)
    obj += "usemtl skin\n" + "".join("f " + " ".join(f"{i + 1}/{i + 1}" for i in f) + "\n" for f in faces)
    mtl = "newmtl skin\nKd 1 0.5 0.2\nmap_Kd -s 2 2 1 -o 0.1 0 -clamp on skin of ours.png\n"
    picture = coloured_png(21, 17, kind=2)
    header, body = ascii_ply(points, faces).decode().replace(
        "comment of our own", "comment TextureFile skin.jpg").replace("vertex_indices", "vertex_indices\nproperty list uchar float texcoord"
    ).split("end_header\n")
    rows = body.split("\n")
    rows[len(points):] = [f"{row} 6 0 0 1 0 1 1" for row in rows[len(points):] if row]
    files = {"a/a.obj": obj, "a/a.mtl": mtl, "a/skin of ours.png": picture}
    return {"obj": archive(files), "stored": archive(files, zipfile.ZIP_STORED), "without image": archive({"a.obj": obj, "a.mtl": mtl}),
            "ply": archive({"a.ply": "\n".join([header + "end_header", *rows, ""]), "skin.jpg": next(iter(JPEGS.values()))}),
            "two": archive({"a.obj": obj, "b.obj": obj}), "bomb": archive({"a.obj": b"\n" * (4 << 20)}),
            "canonical": archive({"model.obj": obj, "model.mtl": mtl.replace("skin of ours.png", "texture-1"), "texture-1": picture})}


def whole_glb():
    points, faces = small_dome()
    positions = b"".join(struct.pack("<3f", *p) for p in points)
    indices = b"".join(struct.pack("<3H", *f) for f in faces)
    box = [[f(p[i] for p in points) for i in range(3)] for f in (min, max)]
    return hostile.glb({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1], "scale": [0.001, 0.001, 0.001]}, {"mesh": 0, "rotation": [0, 0, 0, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(positions) + len(indices)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(positions)},
                        {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(points), "min": box[0], "max": box[1]},
                      {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 3 * len(faces)}]},
        positions + indices)


def compressed_glb():
    """The same, compressed by Draco's own program."""
    with tempfile.TemporaryDirectory() as folder:
        plain, compressed = pathlib.Path(folder, "plain.glb"), pathlib.Path(folder, "compressed.glb")
        plain.write_bytes(whole_glb())
        subprocess.run(["draco_transcoder", "-i", plain, "-o", compressed], check=True, stdout=subprocess.DEVNULL)
        return compressed.read_bytes()


def coloured_png(width, height, depth=8, kind=6, interlace=0, extra=b""):
    channels = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[kind]
    row = (width * channels * depth + 7) // 8
    rows = b"".join(bytes([y % 5]) + bytes((x * y) & 255 for x in range(row)) for y in range(height))
    palette = hostile.chunk(b"PLTE", bytes(range(3 * min(256, 1 << depth)))) if kind == 3 else b""
    return (b"\x89PNG\r\n\x1a\n" + hostile.chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, interlace)) +
            hostile.chunk(b"pHYs", struct.pack(">IIB", 3937, 3937, 1)) + palette + extra +
            hostile.chunk(b"IDAT", zlib.compress(rows)) + hostile.chunk(b"IEND", b""))


def largest_png():
    """As many pixels as a drawing may have, in colour, in a quarter of a megabyte."""
    squeeze = zlib.compressobj(9)
    row = b"\0" + b"\xff\x00\x00\xff" * 8000
    data = b"".join(squeeze.compress(row) for _ in range(8000)) + squeeze.flush()
    return (b"\x89PNG\r\n\x1a\n" + hostile.chunk(b"IHDR", struct.pack(">IIBBBBB", 8000, 8000, 8, 6, 0, 0, 0)) +
            hostile.chunk(b"pHYs", struct.pack(">IIB", 11811, 11811, 1)) + hostile.chunk(b"IDAT", data) +
            hostile.chunk(b"IEND", b""))


# Disks on 20 x 17 pixels, encoded by libjpeg in each of its ways.
JPEGS = {name: base64.b64decode(text) for name, text in json.loads(
    (pathlib.Path(__file__).with_name("jpegs.json")).read_text()).items()}

SVGS = {
    "rings": "".join(f'<g id="c{i}"><circle cx="{20 + 15 * i}" cy="50" r="12" fill="none" stroke="black" stroke-width="2" '
                     f'transform="rotate({7 * i} 50 50)"/></g>' for i in range(5)),
    "paths": '<path id="a" d="M10 10h5v5l-5 2zm1 1c1 2 3 4 5 6s7 8 9 1q2 3 4 5t6 7a5 8 30 1 0 4 4A3 3 0 0 1 9 9Z" fill-rule="evenodd"/>'
             '<polyline points="1,2 3,4 5e0,-6" stroke="#f00" fill="none" stroke-dasharray="1 2 .5" stroke-linejoin="round"/>',
    "styles": '<style>.a{stroke:rgb(10%,20%,30%);fill:none} #b, g > rect {stroke-width:2px}</style><defs><symbol id="s" '
              'viewBox="0 0 9 9"><rect class="a" width="5" height="5" rx="1"/></symbol></defs>'
              '<use href="#s" x="9" width="20" height="20"/><g id="g" opacity=".5"><rect id="b" class="a" width="3" height="4"/></g>',
    "use of use": "<defs>" + "".join(f'<g id="u{i + 1}"><use href="#u{i}"/><use href="#u{i}" x="1"/></g>' for i in range(16)) +
                  '<g id="u0"><rect width="1" height="1"/></g></defs><use href="#u16"/>',
    "dashes": '<path d="M0 0H100" stroke="black" stroke-dasharray="1e-7"/>',
    "filter": '<filter id="f"><feGaussianBlur stdDeviation="50"/></filter><rect width="80" height="80" filter="url(#f)"/>',
    "pattern": '<pattern id="p" width="1e-4" height="1e-4"><rect width="1" height="1"/></pattern><rect width="90" height="90" fill="url(#p)"/>',
    "text": '<text x="5" y="40" font-size="20">ink</text>',
    "nested pages": '<svg x="5" y="5" width="50" height="50" viewBox="0 0 10 10">' * 20 + '<circle r="5"/>' + "</svg>" * 20,
    "deep": "<g>" * 180 + '<circle r="5"/>' + "</g>" * 180,
}

def copies_of_copies(levels):
    """Each group holds ten copies of the one before."""
    groups = "".join(f'<g id="g{i + 1}">' + "".join(f'<use href="#g{i}" x="{k / 10}"/>' for k in range(10)) + "</g>"
                     for i in range(levels))
    return (f'<defs><g id="g0"><circle cx="50" cy="50" r="20" fill="none" stroke="black" stroke-width="2"/></g>{groups}</defs>'
            f'<use href="#g{levels}"/>')


def waves(count):
    """One path of cubics in rows of 250."""
    rows = count // 250
    high = 0.3 * 90 / rows
    row = "".join(f"c{way:.2f} {side:.3f} {2 * way:.2f} {side:.3f} {3 * way:.2f} 0" for way, side in ((.12, high), (.12, -high)) * 125)
    return f'<path fill="none" stroke="black" stroke-width=".1" d="' + "".join(
        f"M5 {5 + 90 * i / rows:.3f}{row}" for i in range(rows)) + '"/>'


def scattered(count, width=0.1, far=90):
    """A line between points all over the page."""
    points = " ".join(f"{5 + far * (i * 0.6180339887 % 1):.1f},{5 + far * (i * i * 0.7548776662 % 1):.1f}" for i in range(count))
    return f'<polyline fill="none" stroke="black" stroke-width="{width}" stroke-linejoin="round" points="{points}"/>'


def nested_effects(kind, attribute, levels, inside):
    return "".join(f'<{kind} id="e{i}"{f" {attribute}=" + chr(34) + f"url(#e{i - 1})" + chr(34) if i else ""}>{inside}</{kind}>'
                   for i in range(levels)) + f'<rect width="90" height="90" {attribute}="url(#e{levels - 1})"/>'


# Small files that ask for much work.
COSTLY_SVGS = {
    "copies of copies, 11 levels": copies_of_copies(11),
    "copies of copies, 5 levels": copies_of_copies(5),
    "copies of copies, 4 levels": copies_of_copies(4),
    "a chain of copies": '<g id="g0"><rect width="9" height="9"/></g>' + "".join(
        f'<g id="g{i + 1}"><use href="#g{i}"/></g>' for i in range(3000)) + '<use href="#g3000"/>',
    "5000 cubics": waves(5000),
    "60000 cubics": waves(60000),
    "5000 cubics at one point": '<path fill="none" stroke="black" d="M50 50' + "c0 0 0 0 0 0" * 5000 + '"/>',
    "5000 tiny cubics": '<path fill="none" stroke="black" stroke-width="2" d="M10 50' + "c.01 0 .01 0 .016 0" * 5000 + '"/>',
    "5000 cubics over each other": '<path fill="none" stroke="black" d="' + "M10 50c10 30 50 -70 80 0" * 5000 + '"/>',
    "5000 loops": '<path fill="none" stroke="black" d="M10 50' + "c5 0 5 -5 0 -5c-5 0 -5 5 .015 5" * 2500 + '"/>',
    "500 lines": scattered(500),
    "3000 lines": scattered(3000),
    "2000 wide lines": scattered(2000, width=1e5),
    "2000 lines of a third of the page": scattered(2000, width=30),
    "2000 lines far off": scattered(2000, far=1e9),
    "1000 circles in a path": '<path fill="none" stroke="black" stroke-width=".3" d="' + "".join(
        f"M{30 + i % 31} {30 + i % 37}a{5 + i % 13} {5 + i % 11} 0 1 1 .1 0z" for i in range(1000)) + '"/>',
    "3000 ellipses": "".join(f'<ellipse id="e{i}" cx="{30 + i % 41}" cy="{30 + i % 37}" rx="{5 + i % 19}" ry="{5 + i % 17}" '
                             'fill="none" stroke="black" stroke-width=".3"/>' for i in range(3000)),
    "5000 pages over each other": '<rect width="100" height="100" fill-opacity=".01"/>' * 5000,
    "dashes": '<path stroke="black" d="M0 50H100" stroke-dasharray="1e-4"/>',
    "100000 dashes": '<path stroke="black" d="M0 50H100" stroke-dasharray="' + ".1 " * 100000 + '"/>',
    "groups of opacity": '<g opacity=".99">' * 150 + '<circle cx="50" cy="50" r="45"/>' + "</g>" * 150,
    "clips of clips": nested_effects("clipPath", "clip-path", 90, '<circle cx="50" cy="50" r="45"/>'),
    "masks of masks": nested_effects("mask", "mask", 90, '<circle cx="50" cy="50" r="45" fill="white"/>'),
    "300 masks": '<mask id="m"><circle cx="50" cy="50" r="45" fill="white"/></mask>' + '<rect width="100" height="100" mask="url(#m)"/>' * 300,
    "patterns of patterns": "".join(f'<pattern id="p{i}" width=".5" height=".5">' + (
        f'<rect width="50" height="50" fill="url(#p{i - 1})"/>' * 10 if i else '<rect width="5" height="5"/>') + "</pattern>"
        for i in range(6)) + '<rect width="100" height="100" fill="url(#p5)"/>',
    "1000 clipped pages": '<clipPath id="c">' + "".join(f'<circle cx="{i % 97}" cy="{i % 89}" r="10"/>' for i in range(1000)) +
                          "</clipPath>" + '<rect width="100" height="100" clip-path="url(#c)"/>' * 1000,
    "markers": '<marker id="m" markerWidth="9" markerHeight="9" overflow="visible">' + '<circle r="1"/>' * 100 + "</marker>"
               '<path fill="none" stroke="black" marker-mid="url(#m)" d="M5 5' + "l.01 .01" * 5000 + '"/>',
    "a chain of gradients": '<linearGradient id="g0"><stop stop-color="red"/></linearGradient>' + "".join(
        f'<linearGradient id="g{i}" href="#g{i - 1}"/>' for i in range(1, 3000)) + '<rect width="10" height="10" fill="url(#g2999)"/>' * 500,
    "20 blurs": '<filter id="f"><feGaussianBlur stdDeviation="50"/></filter>' + '<rect width="80" height="80" filter="url(#f)"/>' * 20,
    "turbulence": '<filter id="f"><feTurbulence numOctaves="1000" baseFrequency=".5"/></filter><rect width="80" height="80" filter="url(#f)"/>',
    "a large matrix": '<filter id="f"><feConvolveMatrix order="50" kernelMatrix="' + "1 " * 2500 + '"/></filter>'
                      '<rect width="80" height="80" filter="url(#f)"/>',
    "a large radius": '<filter id="f"><feMorphology operator="dilate" radius="200"/></filter><rect width="80" height="80" filter="url(#f)"/>',
    "rules": "<style>" + "".join(f".a{{fill:#{i % 4096:03x}}}" for i in range(9000)) + "</style>" + '<rect class="a" width="1" height="1"/>' * 9000,
    "rules of siblings": "<style>" + "".join(f"rect ~ rect ~ rect.c{i}{{fill:red}}" for i in range(100)) + "</style>" + "".join(
        f'<rect class="c{i % 100}" width="1" height="1"/>' for i in range(2000)),
    "letters": '<text x="5" y="40" font-size="20">' + "ink " * 20000 + "</text>",
    "texts": "".join(f'<text x="5" y="{i % 90}" font-size="20">ink</text>' for i in range(10000)),
}

SETTINGS = [
    "", "{}", '{"print":{"dpi":600,"marks":false}}', '{"scan":{"units":"mm","up":"-y","yaw_deg":12.5,"trim_mm":"auto"}}',
    '{"machine":{"heaters":[{"z_mm":120,"width_mm":300,"height_mm":300,"celsius":450}]},"heat":{"source":"heaters","gains":{"a":1.5}}}',
    '{"pattern":{"offset_mm":[3,-4],"points":[[0,0,1,2,3],[1,1,4,5,6]]},"flattening":{"pins":[[0,0,1,1]],"lambda":1e-3}}',
    '{"sheet":{"width_mm":1e308,"material":"hips"}}', '{"print":{"dpi":3e2}}', "[" * 5000, '{"a":' * 500, '{"print":{"dpi":"\\ud800"}}',
    "\ufeff{}", '{"print":{"dpi":300,"dpi":600}}',
]

TEMPERATURES = [
    "150,151,152\n149,150,151\n", "# s, t\ns,t,celsius\n0,0,150\n100,0,140\n0,100,141\n-90,-90,139\n", "1;2,5;3\n4;5;6\n",
    "150 150\n150 150\n", "s;t;celsius\n0;0;150,5\n", "s,t,celsius\n0,0,150\n0,0,160\n", "1e308,-1e308\n", "nan\n", "1\n" * 3000,
    "s,t,celsius\n" + "".join(f"{i % 50},{i // 50},{100 + i % 7}\n" for i in range(2000)),
]

COVERAGES = "patch,coverage\n" + "".join(f"{ink}{k}a,{0.3 * k + 0.2}\n" for ink in "CMY" for k in range(3))
PATCHES = [
    COVERAGES, COVERAGES.replace(",", ";").replace(".", ","), COVERAGES.replace("C0a", "W0a"), COVERAGES + "C0a,0.5\n",
    "patch,L,a,b\nW0a,95,0,2\nC0a,80,-15,-20\nC1a,70,-30,-35\nC2a,60,-40,-45\nM0b,,,\n", "patch\tR\tG\tB\nW0a\t250\t250\t250\nY2b\t250\t240\t10\n",
    "patch,L,a,b\nW0a,1e308,nan,0\n", "patch,coverage\n" + "C0a,0.1\n" * 500,
    '{"patches":[{"id":"C1a","step":1,"ink":"cyan","coverage":0.2,"area_ratio":1.5},{"id":"Wa","step":1,"ink":"none","coverage":0,"area_ratio":1.5}]}',
    '{"patches":[{"id":"C1a","step":1e9,"ink":"blue","coverage":2,"area_ratio":0}]}', '{"patches":' + "[" * 500,
]

FORM = ('--XX\r\nContent-Disposition: form-data; name="scan"; filename="he\\"ad.STL"\r\nContent-Type: model/stl\r\n\r\nsolid\r\n--X\r\n'
        '--XX\r\nContent-Disposition: form-data; name=settings\r\n\r\n{}\r\n--XX--\r\n')
FORMS = [FORM, "preamble\r\n" + FORM, FORM.replace("--XX--", "--XX"), FORM.replace("\r\n\r\n", "\r\nX: " + "y" * 9000 + "\r\n\r\n"),
         '--XX\r\nContent-Disposition: form-data; name="../../etc"; filename="a\r\nSet-Cookie: b"\r\n\r\n\r\n--XX--', "--XX--",
         FORM[:-6] * 200, "multipart/form-data; boundary=\"a;b\"; boundary=c"]

REQUEST = "POST /api/v1/jobs?a=b HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\nIf-None-Match: \"abc\", W/\"d\"\r\nRange: bytes=0-9\r\n\r\nhello"
REQUESTS = [REQUEST, REQUEST.replace("5", "99999999999999999999"), REQUEST.replace("Range", "Expect: 100-continue\r\nRange"),
            REQUEST.replace("Content-Length: 5", "Transfer-Encoding: chunked"), REQUEST.replace("0-9", "-18446744073709551616"),
            REQUEST.replace("0-9", "5-,7-8"), REQUEST.replace("0-9", "18446744073709551615-"), "GET / HTTP/1.1\r\n" + "A: b\r\n" * 200 + "\r\n",
            "GET " + "/" * 5000 + " HTTP/1.1\r\nHost: a\r\n\r\n", REQUEST + REQUEST, "GET / HTTP/1.1\nHost: a\n\n", "\r\n\r\n"]


def seeds():
    """By target, by name, the bytes."""
    found = {name: {} for name in ("stl", "obj", "ply", "off", "glb", "zip", "png", "jpeg", "svg", "settings", "multipart", "redaction",
                                   "temperature", "patches", "icc", "request")}
    points, faces = small_dome()
    found["stl"] |= {"binary": hostile.stl(triangles()), "text": hostile.ascii_stl(triangles()),
                     "two": hostile.stl(triangles() + triangles(scale=0.5)), "open": hostile.stl(triangles()[:-8]),
                     "crossing": hostile.stl(triangles() + [tuple(tuple(x + 9.7 for x in p) for p in t) for t in triangles()])}
    found["obj"]["whole"] = hostile.obj(points=points, faces=[[i + 1 for i in f] for f in faces])
    found["ply"] |= {"text": ascii_ply(points, faces), "little": hostile.ply(), "big": hostile.ply(order=">")}
    found["off"]["whole"] = off(points, faces)
    found["glb"] |= {"whole": whole_glb(), "compressed": compressed_glb()}
    found["zip"] |= zips()
    for name, (_, _, extension, make) in hostile.SCANS.items():
        if extension in found:
            found[extension][name] = make()
    found["png"] |= {f"kind {kind} depth {depth} interlaced {i}": coloured_png(21, 17, depth, kind, i)
                     for kind, depth in ((0, 1), (0, 16), (2, 8), (3, 4), (4, 8), (6, 16)) for i in (0, 1)}
    found["png"]["largest"] = largest_png()
    found["jpeg"] |= JPEGS
    found["svg"] |= {name: hostile.svg(inner) for name, inner in SVGS.items()}
    found["svg"] |= {f"{name} on a page of metres": hostile.svg(inner, root='width="4900mm" height="4900mm" viewBox="0 0 100 100"')
                     for name, inner in (SVGS | COSTLY_SVGS).items()}
    found["svg"] |= {name: hostile.svg(inner) for name, inner in COSTLY_SVGS.items()}
    for name, (_, _, extension, make) in hostile.PATTERNS.items():
        found["jpeg" if extension == "jpg" else extension][name] = make()
    for target, texts in (("settings", SETTINGS), ("temperature", TEMPERATURES), ("patches", PATCHES)):
        found[target] |= {str(i): text.encode("utf-8", "surrogatepass") for i, text in enumerate(texts)}
    found["icc"] |= {space.decode(): hostile.icc(space) for space in (b"RGB ", b"CMYK", b"GRAY")}
    found["icc"]["wide"] = hostile.icc(gamma=1.8, red=(0.8, 0.29, 0.0))
    found["temperature"]["gray"] = coloured_png(9, 7, 16, 0)
    found["multipart"] |= {str(i): b"\x07" + text.encode() for i, text in enumerate(FORMS)}
    found["request"] |= {str(i): text.encode() for i, text in enumerate(REQUESTS)}
    for target, order in (("stl", 0), ("obj", 1), ("ply", 2), ("off", 3), ("png", 4), ("jpeg", 5)):
        for name, data in found[target].items():
            if len(data) < 20000:  # the first byte chooses the pieces, and by that the extension
                found["redaction"][f"{target} {name}"] = bytes([7 + order - 1]) + data
    return found


def main(folder):
    for target, files in seeds().items():
        (folder / target).mkdir(parents=True, exist_ok=True)
        for name, data in files.items():
            (folder / target / name.replace("/", " ")).write_bytes(data)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
