"""The colours of a scan as the print: from the command line and through the service, and what is refused."""
import base64
import hashlib
import io
import json
import math
import re
import struct
import unittest
import zipfile
import zlib

import hostile
from harness import Case, Server, curl, vacuform
from png_rows import rgb_rows

NAME = b"Erika Mustermann"
COARSE = {"scan": {"units": "mm"}, "sheet": {"resolution_mm": 6}, "print": {"dpi": 72, "marks": False, "compensate_colours": False},
          "pattern": {"source": "scan"}}
RED, BLUE = (200, 30, 20), (20, 40, 210)


def texture(left, right):
    rows = b"".join(b"\0" + bytes(left) * 4 + bytes(right) * 4 for _ in range(8))
    return (b"\x89PNG\r\n\x1a\n" + hostile.chunk(b"IHDR", struct.pack(">IIBBBBB", 8, 8, 8, 2, 0, 0, 0)) +
            hostile.chunk(b"tEXt", b"Author\0" + NAME) + hostile.chunk(b"IDAT", zlib.compress(rows)) + hostile.chunk(b"IEND", b""))


def coloured_dome(picture):
    """A dome of 45 mm whose texture is laid over it from above, from its left (x = -50 mm) to its right."""
    points, faces = hostile.dome()
    vertices = b"".join(struct.pack("<5f", -x, z, y, x / 100 + 0.5, 0.5 - y / 100) for x, y, z in points)
    indices = b"".join(struct.pack("<3I", *face) for face in faces)
    views, at = [], 0
    for part, more in ((vertices, {"byteStride": 20}), (indices, {}), (picture, {})):
        views.append({"buffer": 0, "byteOffset": at, "byteLength": len(part), **more})
        at += len(part)
    return hostile.glb({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}], "textures": [{"source": 0}],
        "images": [{"bufferView": 2, "mimeType": "image/png"}], "buffers": [{"byteLength": at}], "bufferViews": views,
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(points)},
                      {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "type": "VEC2", "count": len(points)},
                      {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 3 * len(faces)}]},
        vertices + indices + picture)


def pixels(png):
    """Rows of the colours of a picture."""
    return [[tuple(row[x:x + 3]) for x in range(0, len(row), 3)] for row in rgb_rows(png)]


def textures(glb):
    """The pictures of a GLB."""
    size = struct.unpack_from("<I", glb, 12)[0]
    about, start = json.loads(glb[20:20 + size]), 20 + size + 8
    views = [about["bufferViews"][image["bufferView"]] for image in about["images"]]
    return [glb[start + view["byteOffset"]:start + view["byteOffset"] + view["byteLength"]] for view in views]


def archive_of(files):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return out.getvalue()


def without_label(folder, name):
    """The file without the name of the print, which is another one for other settings."""
    label = json.loads((folder / "report.json").read_text())["label"].encode()
    return (folder / name).read_bytes().replace(label, b"")


def hashes(folder):
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.iterdir()}


class Colours(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scan, cls.settings = cls.folder / "dome.glb", cls.folder / "colours.json"
        cls.scan.write_bytes(coloured_dome(texture(RED, BLUE)))
        cls.settings.write_text(json.dumps(COARSE))
        cls.out = cls.folder / "out"
        done = cls.run_with(cls.scan, cls.out)
        assert done.returncode == 0, done.stderr

    @classmethod
    def run_with(cls, scan, out, *words):
        return vacuform("run", "--scan", scan, "--settings", cls.settings, "--out", out, *words)

    def test_the_print_has_the_colours_where_the_scan_has_them(self):
        rows = pixels((self.out / "print.png").read_bytes())
        middle, per_mm = len(rows) // 2, 72 / 25.4
        for x, y, wanted in ((-15, 10, RED), (15, 10, BLUE), (-15, -10, RED), (15, -10, BLUE), (140, 140, (255, 255, 255))):
            self.assertEqual(rows[middle - round(y * per_mm)][middle + round(x * per_mm)], wanted, (x, y))
        report = json.loads((self.out / "report.json").read_text())
        self.assertEqual(report["pattern"]["format"], "scan")
        self.assertEqual(list(report["sha256"]), ["scan"])
        colours = report["pattern"]["colours"]
        self.assertGreater(colours["full_mm2"], 6000)  # of 12,700 mm2
        self.assertTrue(0 < colours["faded_share"] < 0.5, colours)
        self.assertIn(b"/Subtype /Image", (self.out / "print.pdf").read_bytes())

    def test_the_part_is_compared_with_the_scan(self):
        report = json.loads((self.out / "report.json").read_text())
        errors = report["pattern"]["colours"]["errors"]
        touching, pixel = errors["touching"], 25.4 / 72
        self.assertLess(touching["along_mm"]["p99"], pixel)  # a quarter of a pixel both ways, as the sheet stretches it
        self.assertGreater(touching["along_mm"]["mean"], 0.3 * pixel)
        self.assertLess(touching["position_mm"]["max"], 1)
        self.assertLess(touching["ciede2000"]["mean"], 1)
        self.assertGreater(errors["whole"]["ciede2000"]["mean"], touching["ciede2000"]["mean"])  # where the colours fade
        self.assertEqual([off["shift_mm"] for off in errors["off_register"]], [0.5, 1])
        for off in errors["off_register"]:
            self.assertTrue(off["shift_mm"] < off["along_mm"]["mean"] < 2 * off["shift_mm"], off)
            self.assertGreater(off["ciede2000"]["mean"], touching["ciede2000"]["mean"])
        names = ["preview-position.png", "preview-colour.png", "preview-original.png", "preview-align.png"]
        self.assertEqual([a["name"] for a in report["artifacts"] if a["name"] in names], names)
        for name, height in zip(names, (1000, 1000, 2196, 1396)):
            self.assertEqual(struct.unpack_from(">II", (self.out / name).read_bytes(), 16), (1000, height), name)
        page = (self.out / "report.html").read_text()
        self.assertIn("The scan and the formed part side by side", page)
        self.assertIn("Touching, print 0.5 mm off its marks", page)

    def test_the_scan_and_the_part_look_alike_from_above(self):
        rows = pixels((self.out / "preview-original.png").read_bytes())
        middle = 104 + 4 * 400 + 217  # of the last row of tiles
        for x, hue in ((200, 0), (300, 2)):  # red left of the middle, blue right of it
            scan, part = rows[middle][x], rows[middle][500 + x]
            self.assertEqual(scan.index(max(scan)), hue, scan)
            self.assertLess(max(abs(a - b) for a, b in zip(scan, part)), 25, (scan, part))

    def test_formed_glb_has_the_errors_of_the_colours(self):
        def attributes(folder):
            glb = (folder / "formed.glb").read_bytes()
            about = json.loads(glb[20:20 + struct.unpack_from("<I", glb, 12)[0]])
            return about["meshes"][0]["primitives"][0]["attributes"], about["accessors"]

        names, accessors = attributes(self.out)
        position, colour = (accessors[names[name]] for name in ("_POSITION", "_COLOUR"))
        self.assertEqual((position["min"], colour["min"]), ([-1], [-1]))
        self.assertTrue(0.5 < position["max"][0] < 4, position)
        self.assertTrue(10 < colour["max"][0] < 100, colour)

    def test_more_ink_is_printed_where_the_sheet_stretches(self):
        out = self.folder / "compensated"
        done = self.run_with(self.scan, out, "--set", "print.compensate_colours=true", "--set", "pattern.inked_face=inner")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = pixels((out / "print.png").read_bytes())
        middle, per_mm = len(rows) // 2, 72 / 25.4
        data = (out / "formed.ply").read_bytes()
        head, _, body = data.partition(b"end_header\n")
        count = int(re.search(rb"element vertex (\d+)", head)[1])
        def coverage(byte):
            v = byte / 255
            return 1 - (v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4)
        checked, stretched = 0, 0
        for x, y, z, s, t, u, v, thickness, *_ in struct.iter_unpack("<9fB", body[:37 * count]):
            if not 6 < math.hypot(s, t) < 34 or s > -6:
                continue  # the left half of the dome is red
            i, j = middle - round(s * per_mm), middle - round(t * per_mm)  # the print for the inner face is mirrored
            ratio = 1 / thickness  # the sheet is 1 mm thick, and its volume stays
            self.assertAlmostEqual(coverage(rows[j][i][0]), min(1, ratio * coverage(RED[0])), delta=0.02, msg=(s, t))
            checked, stretched = checked + 1, max(stretched, ratio)
        self.assertGreater(checked, 30)
        self.assertGreater(stretched, 1.1)
        report = json.loads((out / "report.json").read_text())
        ink = report["pattern"]["colours"]["ink"]
        self.assertGreater(ink["short_share"], 0.5)  # nearly full magenta, yellow and cyan stretch everywhere
        warning = next(w for w in report["warnings"] if w["code"] == "ink-not-enough")
        self.assertAlmostEqual(warning["figure"]["value"], 100 * ink["short_share"], delta=0.05)
        self.assertEqual(warning["marks"][0]["place_mm"], ink["place_mm"])
        before = json.loads((self.out / "report.json").read_text())
        self.assertIsNone(before["pattern"]["colours"]["ink"])
        self.assertNotIn("ink-not-enough", [w["code"] for w in before["warnings"]])

    def test_the_print_is_marked_as_srgb(self):
        png, pdf = (self.out / "print.png").read_bytes(), (self.out / "print.pdf").read_bytes()
        self.assertIn(b"sRGB", png[:100])
        self.assertNotIn(b"iCCP", png)
        self.assertEqual(pdf.count(b"/DefaultRGB [/ICCBased "), 1)
        in_svg = re.search(rb"base64,([A-Za-z0-9+/=]+)", (self.out / "print.svg").read_bytes())[1]
        self.assertIn(b"sRGB", base64.b64decode(in_svg)[:100])

    def test_a_profile_converts_the_colours_and_is_embedded(self):
        profile = hostile.icc()  # Adobe RGB
        (self.folder / "printer.icc").write_bytes(profile)
        out = self.folder / "profiled"
        done = self.run_with(self.scan, out, "--icc", self.folder / "printer.icc", "--set", "pattern.source=scan")
        self.assertEqual(done.returncode, 0, done.stderr)
        png, pdf = (out / "print.png").read_bytes(), (out / "print.pdf").read_bytes()
        at = png.index(b"iCCP")
        size = struct.unpack(">I", png[at - 4:at])[0]
        name, _, packed = png[at + 4:at + 4 + size].partition(b"\0")
        self.assertEqual((name, zlib.decompress(packed[1:])), (b"ICC profile", profile))
        self.assertNotIn(b"sRGB", png[:100])
        self.assertIn(b"/ColorSpace [/ICCBased ", pdf)
        rows = pixels(png)
        middle, per_mm = len(rows) // 2, 72 / 25.4
        # The same light in Adobe RGB, from the primaries of both.
        for x, wanted in ((-15, self.in_adobe_rgb(RED)), (15, self.in_adobe_rgb(BLUE)), (140, (255, 255, 255))):
            found = rows[middle - round(10 * per_mm)][middle + round(x * per_mm)]
            for a, b in zip(found, wanted):
                self.assertAlmostEqual(a, b, delta=2, msg=(found, wanted))
        report = json.loads((out / "report.json").read_text())
        self.assertEqual(report["sha256"]["icc"], hashlib.sha256(profile).hexdigest())
        self.assertNotEqual(report["label"], json.loads((self.out / "report.json").read_text())["label"])

    @staticmethod
    def in_adobe_rgb(colour):
        linear = [v / 255 / 12.92 if v <= 10 else ((v / 255 + 0.055) / 1.055) ** 2.4 for v in colour]
        r, g, b = linear
        mixed = (0.71515 * r + 0.28485 * g, g, 0.04116 * g + 0.95884 * b)
        return tuple(round(255 * max(0, v) ** (1 / 2.2)) for v in mixed)

    def test_a_model_that_lacks_its_library_is_refused_by_name(self):
        folder = self.folder / "lacking"
        folder.mkdir()
        (folder / "a.obj").write_text("mtllib renamed.mtl\n" + hostile.obj().decode())
        (folder / "a.mtl").write_text("newmtl a\nKd 1 0 0\n")
        done = self.run_with(folder / "a.obj", self.folder / "of-lacking")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("the material library renamed.mtl, which is not beside it", done.stderr)

    def test_a_ply_names_several_textures_and_an_obj_several_libraries(self):
        points, faces = hostile.dome()
        folder = self.folder / "several"
        folder.mkdir()
        for name, colour in (("a b.png", RED), ("c.png", BLUE)):
            (folder / name).write_bytes(texture(colour, colour))
        (folder / "head.ply").write_text(
            f"ply\nformat ascii 1.0\ncomment TextureFile a b.png\ncomment TextureFile c.png\nelement vertex {len(points)}\n"
            f"property float x\nproperty float y\nproperty float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\n"
            "property list uchar float texcoord\nproperty int texnumber\nend_header\n" + "".join(f"{x} {y} {z}\n" for x, y, z in points) +
            "".join(f"3 {a} {b} {c} 6 0 0 1 0 0 1 {int(sum(points[i][0] for i in (a, b, c)) > 0)}\n" for a, b, c in faces))
        (folder / "head.obj").write_text(
            "mtllib A.mtl c.mtl\n" + "".join(f"v {x} {y} {z}\n" for x, y, z in points) +
            "".join(f"usemtl {'c' if sum(points[i][0] for i in face) > 0 else 'a'}\nf " + " ".join(str(i + 1) for i in face) + "\n" for face in faces))
        for name, colour in (("a", RED), ("c", BLUE)):
            (folder / f"{name}.mtl").write_text(f"newmtl {name}\nKd {' '.join(str(v / 255) for v in colour)}\n")
        for scan in "head.ply", "head.obj":
            out = self.folder / f"of-several-{scan}"
            done = self.run_with(folder / scan, out, "--set", "scan.up=+z")
            self.assertEqual(done.returncode, 0, done.stderr)
            rows = pixels((out / "print.png").read_bytes())
            middle, per_mm = len(rows) // 2, 72 / 25.4
            for x, wanted in (-15, RED), (15, BLUE):
                found = rows[middle - round(10 * per_mm)][middle + round(x * per_mm)]
                for a, b in zip(found, wanted):
                    self.assertAlmostEqual(a, b, delta=2, msg=(scan, x, found))

    def test_other_profiles_are_refused_by_name(self):
        for profile, says in ((hostile.icc(b"CMYK"), "for CMYK"), (hostile.icc(b"GRAY"), "for gray"), (b"hello", "not an ICC profile"),
                              (hostile.icc()[:140], "damaged"), (hostile.icc() + bytes(5 << 20), "printer.icc")):
            (self.folder / "printer.icc").write_bytes(profile)
            done = self.run_with(self.scan, self.folder / "refused", "--icc", self.folder / "printer.icc")
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(says, done.stderr)
            self.assertIn("printer.icc", done.stderr)
            self.assertFalse((self.folder / "refused").exists())

    def test_an_obj_prints_the_same_from_a_folder_and_from_a_zip(self):
        points, faces = hostile.dome()
        name = NAME.decode()
        obj = (f"# {name}\nmtllib head of {name}.mtl\n" + "".join(f"v {x} {y} {z}\n" for x, y, z in points) +
               "".join(f"vt {x / 100 + 0.5} {y / 100 + 0.5}\n" for x, y, z in points) + f"usemtl skin of {name}\n" +
               "".join("f " + " ".join(f"{i + 1}/{i + 1}" for i in face) + "\n" for face in faces))
        mtl = f"# {name}\nnewmtl skin of {name}\nKd 1 1 1\nmap_Kd pictures/{name}.png\n"
        folder = self.folder / "model"
        (folder / "pictures").mkdir(parents=True)
        (folder / "head.obj").write_text(obj)
        (folder / f"head of {name}.mtl").write_text(mtl)
        (folder / "pictures" / f"{name}.png").write_bytes(texture(RED, BLUE))
        packed = self.folder / "head.zip"
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in sorted(folder.rglob("*")):
                archive.write(file, f"export/{file.relative_to(folder)}")
        outs = {}
        settings = ("--set", "scan.up=+z")
        for scan in packed, folder / "head.obj":
            outs[scan] = self.folder / f"of-{scan.name}"
            done = self.run_with(scan, outs[scan], *settings)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(*((out / "print.png").read_bytes() for out in outs.values()))
        rows, of_glb = pixels((outs[packed] / "print.png").read_bytes()), pixels((self.out / "print.png").read_bytes())
        middle, per_mm = len(rows) // 2, 72 / 25.4
        for x, y, wanted in ((-15, 10, RED), (15, 10, BLUE), (140, 140, (255, 255, 255))):
            self.assertEqual(rows[middle - round(y * per_mm)][middle + round(x * per_mm)], wanted, (x, y))
        self.assertEqual(len(rows), len(of_glb))
        with Server(self.folder, workers=1) as server:
            out = self.folder / "zip-submitted"
            done = vacuform("submit", "--server", server.url, "--scan", packed, "--settings", self.settings, *settings,
                            "--wait", "--out", out)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(hashes(out), hashes(outs[packed]))
            for path in [p for p in server.data.rglob("*") if p.is_file()]:
                self.assertNotIn(NAME, path.read_bytes(), path)
            (self.folder / "bad.zip").write_bytes(archive_of({"a.obj": obj, "a.mtl": "newmtl a\nmap_Kd ../../secret.png\n"}))
            refused = curl("-F", f"scan=@{self.folder / 'bad.zip'}", "-F", "settings=" + json.dumps(COARSE), server.api + "/jobs")
            self.assertEqual(refused.status, 422, refused)
            self.assertIn("a path leads to a parent folder: ../../secret.png", refused.json["what"])
            self.assertNotIn("secret", server.program.says())

    def test_hostile_zips_are_refused_by_name(self):
        obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n"
        for number, (files, said) in enumerate((
                ({"a.obj": obj, "a.mtl": "newmtl a\nmap_Kd skin.png\n"}, "lacks the image skin.png"),
                ({"a.obj": obj, "a.mtl": "newmtl a\nmap_Kd /etc/skin.png\n"}, "a path is absolute: /etc/skin.png"),
                ({"a.obj": obj, "a.mtl": "newmtl a\nmap_Kd skin.tga\n", "skin.tga": "tga"}, "skin.tga is a TGA image"),
                ({"a.obj": obj, "b.obj": obj}, "more than one model"),
                ({"a.obj": "\n" * (8 << 20)}, "unpacks to more than 200 times its size"),
                ({"readme.txt": "nothing"}, "holds no model"))):
            scan = self.folder / f"hostile-{number}.zip"
            scan.write_bytes(archive_of(files))
            done = self.run_with(scan, self.folder / "refused")
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(said, done.stderr)

    def test_names_in_the_texture_are_kept_nowhere(self):
        for file in self.out.iterdir():
            self.assertNotIn(NAME, file.read_bytes(), file.name)

    def test_a_drawing_over_the_colours_is_two_prints_in_register(self):
        drawing = self.folder / "ring.svg"
        drawing.write_bytes(hostile.GOOD_SVG)
        folders = {source: self.folder / source for source in ("file", "both", "marked")}
        for source, words in (("file", ("--set", "pattern.source=file")), ("both", ("--set", "pattern.source=both")),
                              ("marked", ("--set", "pattern.source=both", "--set", "print.marks=true"))):
            done = self.run_with(self.scan, folders[source], "--pattern", drawing, *words)
            self.assertEqual(done.returncode, 0, done.stderr)
        for kind in "png", "svg", "pdf":
            both, alone = (without_label(folders[source], f"print.{kind}") for source in ("both", "file"))
            if kind == "pdf":  # it has the page of the colours behind that of the drawing
                self.assertIn(b"/Type /Pages /Count 2 ", both)
                alone = alone[:alone.index(b"4 0 obj\n<< /Type /Pages")]
                both = both[:len(alone)]
            self.assertEqual(both, alone, kind)
            self.assertEqual(without_label(folders["both"], f"colours.{kind}"), without_label(self.out, f"print.{kind}"), kind)
            self.assertFalse((folders["file"] / f"colours.{kind}").exists())
        self.assertFalse((folders["file"] / "preview-original.png").exists())
        self.assertNotIn(b'"_POSITION"', (folders["file"] / "formed.glb").read_bytes())
        layers = [re.search(r'<g id="marks".*</g>', (folders["marked"] / f"{name}.svg").read_text(), re.S).group()
                  for name in ("print", "colours")]
        self.assertEqual(*layers)
        self.assertIn("mark-", layers[0])
        report = json.loads((folders["both"] / "report.json").read_text())
        self.assertEqual(list(report["sha256"]), ["scan", "pattern"])
        self.assertEqual(report["pattern"]["format"], "SVG")
        self.assertGreater(report["pattern"]["colours"]["full_mm2"], 6000)
        alone = json.loads((self.out / "report.json").read_text())["pattern"]["colours"]
        self.assertEqual(report["pattern"]["colours"], alone)  # the same colours, errors too
        self.assertEqual([a["name"] for a in report["artifacts"]][:6],
                         ["print.png", "print.svg", "print.pdf", "colours.png", "colours.svg", "colours.pdf"])

    def test_formed_glb_shows_the_drawing_over_the_colours(self):
        drawing, out = self.folder / "disc.svg", self.folder / "disc"
        drawing.write_bytes(hostile.svg('<circle cx="50" cy="50" r="8" fill="black"/>'))
        done = self.run_with(self.scan, out, "--pattern", drawing, "--set", "pattern.source=both")
        self.assertEqual(done.returncode, 0, done.stderr)
        for png in textures((out / "formed.glb").read_bytes()):
            rows = pixels(png)
            middle, per_mm = len(rows) // 2, 72 / 25.4
            for x, y, wanted in ((0, 0, (0, 0, 0)), (-15, 10, RED), (15, -10, BLUE), (140, 140, (255, 255, 255))):
                self.assertEqual(rows[middle - round(y * per_mm)][middle + round(x * per_mm)], wanted, (x, y))

    def test_the_service_makes_the_same(self):
        with Server(self.folder, workers=1) as server:
            out = self.folder / "submitted"
            done = vacuform("submit", "--server", server.url, "--scan", self.scan, "--settings", self.settings, "--wait", "--out", out)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(hashes(out), hashes(self.out))
            for path in [p for p in server.data.rglob("*") if p.is_file()]:
                self.assertNotIn(NAME, path.read_bytes(), path)
            self.profiles(server)
            pattern = self.folder / "ring.svg"
            pattern.write_bytes(hostile.GOOD_SVG)
            refused = server.post(self.scan, pattern, COARSE)
            self.assertEqual((refused.status, refused.json["type"]), (422, "/problems/bad-settings"), refused)
            for place, more in ((self.folder / "both-run", ("run",)),
                                (self.folder / "both-submitted", ("submit", "--server", server.url, "--wait"))):
                done = vacuform(*more, "--scan", self.scan, "--pattern", pattern, "--settings", self.settings,
                                "--set", "pattern.source=both", "--out", place)
                self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(hashes(self.folder / "both-submitted"), hashes(self.folder / "both-run"))
            alone = vacuform("submit", "--server", server.url, "--scan", self.scan, "--settings", self.settings,
                             "--set", "pattern.source=both", "--wait")
            self.assertEqual(alone.returncode, 2, alone.stderr)
            self.assertIn("a pattern", alone.stderr)

    def profiles(self, server):
        """An ICC profile goes with a job, and with the jobs made from it."""
        icc = self.folder / "service.icc"
        icc.write_bytes(hostile.icc())
        self.assertEqual(self.run_with(self.scan, self.folder / "icc-run", "--icc", icc).returncode, 0)
        done = vacuform("submit", "--server", server.url, "--scan", self.scan, "--icc", icc, "--settings", self.settings, "--wait",
                        "--out", self.folder / "icc-submitted")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(hashes(self.folder / "icc-submitted"), hashes(self.folder / "icc-run"))
        job = curl(f"{server.api}/jobs/" + curl(server.api + "/jobs?limit=1").json["jobs"][0]["id"]).json
        self.assertEqual(job["inputs"]["icc"]["sha256"], hashlib.sha256(icc.read_bytes()).hexdigest())
        again = curl("-F", f"from={job['id']}", server.api + "/jobs")
        self.assertEqual((again.status, again.json["inputs"]["icc"]), (202, job["inputs"]["icc"]))
        icc.write_bytes(hostile.icc(b"CMYK"))
        done = vacuform("submit", "--server", server.url, "--scan", self.scan, "--icc", icc, "--settings", self.settings, "--wait")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("for CMYK", done.stderr)

    def test_refusals(self):
        plain, pattern, webp = self.folder / "plain.stl", self.folder / "ring.svg", self.folder / "webp.glb"
        plain.write_bytes(hostile.stl(hostile.dome_triangles()))
        pattern.write_bytes(hostile.GOOD_SVG)
        webp.write_bytes(coloured_dome(b"RIFF\x20\0\0\0WEBPVP8 " + bytes(16)))
        for scan, words, said in (
                (plain, (), "the scan has no colours (STL (binary))"),
                (webp, (), "the texture is neither PNG nor JPEG"),
                (self.scan, ("--pattern", pattern), "a pattern is given, but the colours of the scan are to be printed"),
                (self.scan, ("--set", "pattern.source=file"), "there is no pattern"),
                (self.scan, ("--set", "pattern.source=both"), "there is no pattern"),
                (plain, ("--set", "pattern.source=both", "--pattern", pattern), "the scan has no colours (STL (binary))"),
                (self.scan, ("--set", "pattern.placement=segments"), "pattern.source=scan has none (pattern.placement)"),
                (self.scan, ("--set", "coils.decouple=true"), "(coils.decouple)"),
                (self.scan, ("--set", "flattening.weights=ink"), "(flattening.weights)")):
            done = self.run_with(scan, self.folder / "refused", *words)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(said, done.stderr)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)


if __name__ == "__main__":
    unittest.main()
