"""A name in every place where a file can carry one, through the real server by form and in pieces: it is found nowhere
afterwards, neither on the disk nor in artifacts, answers and the log."""
import base64
import io
import json
import pathlib
import unittest
import zipfile

import hostile
from harness import Case, Server, curl

NAME = b"JaneDoe1984"
TEXT = NAME.decode()
SETTINGS = {"sheet": {"resolution_mm": 12}, "print": {"dpi": 72}, "pattern": {"width_mm": 60}}
JPEG = base64.b64decode(json.loads((pathlib.Path(__file__).resolve().parents[1] / "fuzz" / "jpegs.json").read_text())["colour"])


def glb():
    """A dome with names in every text, in extras, and in a picture of its texture."""
    points, faces = hostile.dome()
    corners = b"".join(hostile.struct.pack("<3f", x, z, -y) for x, y, z in points)
    indices = b"".join(hostile.struct.pack("<3I", *face) for face in faces)
    picture = hostile.png(8, 8, extra=hostile.chunk(b"tEXt", b"Author\0" + NAME))
    views, at = [], 0
    for part in (corners, indices, picture):
        views.append({"buffer": 0, "byteOffset": at, "byteLength": len(part), "name": TEXT})
        at += len(part)
    return hostile.glb({
        TEXT: {TEXT: 1}, "asset": {"version": "2.0", "generator": "Scanner of " + TEXT, "copyright": TEXT, "extras": {TEXT: [TEXT, 1984]}},
        "scene": 0, "scenes": [{"nodes": [0], "name": TEXT}], "nodes": [{"mesh": 0, "name": TEXT, "extras": TEXT}],
        "meshes": [{"name": TEXT, "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"name": TEXT}], "textures": [{"source": 0, "name": TEXT}],
        "images": [{"bufferView": 2, "mimeType": "image/png", "name": TEXT}], "buffers": [{"byteLength": at + len(NAME)}], "bufferViews": views, "extensions": {TEXT: {"a": TEXT}},
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(points)},
                      {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 3 * len(faces)}]}, corners + indices + picture + NAME) + NAME


def text_scans():
    points, faces = hostile.dome()
    rows = "".join("%r %r %r\n" % p for p in points)
    tagged = "".join("%r %r %r 7\n" % p for p in points)
    ply = (f"ply\nformat ascii 1.0\ncomment {TEXT}\nobj_info {TEXT}\nelement vertex {len(points)}\nproperty float x\nproperty float y\n"
           f"property float z\nproperty uchar {TEXT}\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nelement {TEXT} 1\nproperty uchar {TEXT}\nend_header\n")
    corners = "".join("3 %d %d %d\n" % f for f in faces)
    return {"ply": (ply + tagged + corners + f"1\n{TEXT}\n").encode(),
            "off": f"OFF # {TEXT}\n# {TEXT}\n{len(points)} {len(faces)} 0\n{rows}{corners}{TEXT}\n".encode(),
            "obj": f"# {TEXT}\nmtllib {TEXT}.mtl\no {TEXT}\ng {TEXT}\nusemtl {TEXT}\n".encode() + hostile.obj(),
            "stl": hostile.ascii_stl(hostile.dome_triangles(), name=TEXT)}


def segment(marker, data):
    return b"\xff" + bytes([marker]) + hostile.struct.pack(">H", len(data) + 2) + data


def patterns():
    ring = '<circle cx="50" cy="50" r="20" fill="none" stroke="black" stroke-width="2"/>'
    rows = b"".join(b"\0" + (b"\xf0" * 13 if y % 20 < 10 else b"\xff" * 13) for y in range(100))
    png = hostile.png(100, 100, rows=rows, extra=b"".join(hostile.chunk(kind, b"Author\0" + NAME) for kind in (
        b"tEXt", b"iTXt", b"eXIf", b"iCCP", b"sPLT", b"caNv")))
    jpeg = JPEG[:2] + b"".join(segment(m, b"Exif\0\0" + NAME) for m in (0xE1, 0xE2, 0xED, 0xFE)) + JPEG[2:] + NAME
    picture = base64.b64encode(png).decode()
    svg = hostile.svg(
        f'<title>{TEXT}</title><desc>{TEXT}</desc><metadata><rdf:RDF><dc:creator>{TEXT}</dc:creator></rdf:RDF></metadata><!-- {TEXT} -->'
        f'<sodipodi:namedview inkscape:who="{TEXT}">{TEXT}</sodipodi:namedview><style>/* {TEXT} */ g {{ stroke: black }}</style>'
        f'<g id="coil" inkscape:label="{TEXT}" data-name="{TEXT}" owner="{TEXT}">{ring}</g><text display="none">{TEXT}</text><who n="{TEXT}">&who;</who>'
        f'<image width="9" height="9" xlink:href="data:image/png;base64,{picture}"/>',
        root='width="100mm" height="100mm" viewBox="0 0 100 100" xmlns:xlink="http://www.w3.org/1999/xlink" xmlns:dc="d" xmlns:rdf="r" '
             f'xmlns:sodipodi="http://{TEXT}" xmlns:inkscape="i" sodipodi:docname="{TEXT}.svg" inkscape:export-filename="/home/{TEXT}/a.png"',
        prolog=f'<?xml version="1.0"?><?xpacket {TEXT}?><!-- {TEXT} --><!DOCTYPE svg [<!ENTITY who "{TEXT}">]>')
    return {"svg": svg, "png": png, "jpg": jpeg}


class Names(Case):
    def test_a_name_is_kept_nowhere(self):
        scans = {**text_scans(), "glb": glb()}
        drawings = patterns()
        table = f"# {TEXT}\n120,121\n122,123\n".encode()
        answers = []
        with Server(self.folder, workers=2) as server:
            self.server, jobs = server, []
            for i, (extension, scan) in enumerate({**scans, "STL": hostile.stl(hostile.dome_triangles(), header=NAME)}.items()):
                kind = list(drawings)[i % len(drawings)]
                words = ["-F", f"scan=@{self.file(extension, scan)}", "-F", f"pattern=@{self.file(kind, drawings[kind])}",
                         "-F", "settings=" + json.dumps(SETTINGS)]
                if i == 0:
                    words += ["-F", f"temperature=@{self.file('csv', table)}"]
                answers.append(curl(*words, server.api + "/jobs"))
                self.assertEqual(answers[-1].status, 202, answers[-1])
                jobs.append(answers[-1].json["id"])
            for extension, content in scans.items():
                self.upload(extension, content)
            for job in jobs:
                ended = server.wait(job)
                self.assertEqual(ended["state"], "succeeded", ended["problem"])
                answers.append(curl(f"{server.api}/jobs/{job}/log"))
                archive = zipfile.ZipFile(io.BytesIO(curl(f"{server.api}/jobs/{job}/artifacts.zip").body))
                for artifact in archive.namelist():
                    self.assertNotIn(NAME, archive.read(artifact), artifact)
        for answer in answers:
            self.assertNotIn(NAME, answer.body)
        for path in [p for p in server.data.rglob("*") if p.is_file()]:
            self.assertNotIn(NAME, path.read_bytes(), path)
        self.assertNotIn(TEXT, server.program.says())

    def file(self, extension, content):
        path = self.folder / f"{TEXT}.{extension}"
        path.write_bytes(content)
        return path

    def upload(self, extension, content):
        """In two pieces, which part in the middle of the file's first name."""
        name = base64.b64encode(f"{TEXT}.{extension}".encode()).decode()
        begin = curl("-X", "POST", "-H", "Tus-Resumable: 1.0.0", "-H", f"Upload-Length: {len(content)}", "-H",
                     f"Upload-Metadata: filename {name},input c2Nhbg==", self.server.api + "/uploads")
        at = content.find(NAME) + 4
        for offset, piece in ((0, content[:at]), (at, content[at:])):
            sent = curl("-X", "PATCH", "-H", "Tus-Resumable: 1.0.0", "-H", "Content-Type: application/offset+octet-stream", "-H",
                        f"Upload-Offset: {offset}", "--data-binary", f"@{self.file('piece', piece)}", self.server.url + begin.headers["location"])
            self.assertEqual(sent.status, 204, sent)


if __name__ == "__main__":
    unittest.main()
