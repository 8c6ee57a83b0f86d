"""The pages of an array in Inkscape: as large as they say, with the registration marks and the coils where the file has them, on both
faces, to 0.01 mm. A reading of its own takes the numbers from the file; Inkscape is asked for the boxes that it draws."""
import re
import subprocess
import unittest
import xml.etree.ElementTree as ElementTree

import made_scans
from harness import Case, vacuform
from test_own_layers import A, B, FAST, group, ring, svg
from test_random_drawings import SVG

EXACT = 0.01  # mm
MM = 25.4 / 96


def inkscape(*words):
    done = subprocess.run(["inkscape", *map(str, words)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def drawn_boxes(file):
    """Of everything with an id: left, top, width and height on the page, mm, as Inkscape draws it."""
    out = {}
    for line in inkscape("--query-all", file).splitlines():
        name, *numbers = line.rsplit(",", 4)
        out[name] = [float(n) * MM for n in numbers]
    return out


def points(d):
    """Points close enough to each other on a path of M, L, C and Z."""
    out, command = [], None
    numbers = []
    for word in re.findall(r"[MLCZ]|-?[\d.]+", d):
        if word in "MLCZ":
            command, numbers = word, []
            continue
        numbers.append(float(word))
        if len(numbers) < (6 if command == "C" else 2):
            continue
        if command == "C":
            p, (ax, ay, bx, by, x, y) = out[-1], numbers
            for i in range(1, 101):
                t = i / 100
                out.append(tuple((1 - t) ** 3 * s + 3 * t * (1 - t) ** 2 * a + 3 * t * t * (1 - t) * b + t ** 3 * e
                                 for s, a, b, e in ((p[0], ax, bx, x), (p[1], ay, by, y))))
        else:
            out.append(tuple(numbers))
        numbers = []
    return out


def written_box(of, left, top, mirrored, margin=0):
    places = [p for path in of.iter(SVG + "path") for p in points(path.get("d"))]
    xs, ys = [-x if mirrored else x for x, _ in places], [y for _, y in places]
    return [min(xs) - margin - left, min(ys) - margin - top, max(xs) - min(xs) + 2 * margin, max(ys) - min(ys) + 2 * margin]


class Inkscape(Case):
    def assert_box(self, drawn, written, what):
        worst = max(abs(a - b) for a, b in zip(drawn, written))
        self.worst = max(self.worst, worst)
        self.assertLess(worst, EXACT, (what, drawn, written))

    def test_pages_of_both_faces_have_their_sizes(self):
        text = svg(group("conductor", ring(A, 3)), group("conductor inner", ring(B, 3)), group("resist inner", ring(B, 5)))
        (self.folder / "two-faces.svg").write_text(text)
        out = self.folder / "out"
        done = vacuform("run", "--scan", made_scans.adult(), "--pattern", self.folder / "two-faces.svg", *FAST, "--set", "sheet.width_mm=297",
                        "--set", "sheet.height_mm=310", "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.worst = 0
        files = sorted(out.glob("print*.svg"), key=lambda file: file.stem)
        self.assertEqual([file.stem for file in files], ["print", "print-reverse", "print-reverse-resist"])
        for file in files:
            root, drawn = ElementTree.parse(file).getroot(), drawn_boxes(file)
            left, top, width, height = map(float, root.get("viewBox").split())
            self.assertEqual((width, height), (297, 310))
            groups = {g.get("id"): g for g in root.iter(SVG + "g")}
            mirrored = groups["pattern"].get("transform") == "scale(-1 1)"
            self.assertEqual(mirrored, file.stem != "print")
            coils = [name for name in groups if name.startswith("coil")]
            self.assertEqual(len(coils), 1)
            self.assert_box(drawn[coils[0]], written_box(groups[coils[0]], left, top, mirrored), (file.stem, coils[0]))
            marks = [name for name in groups if name.startswith("mark-registration")]
            self.assertEqual(len(marks), 4)
            for name in marks:
                self.assert_box(drawn[name], written_box(groups[name], left, top, False), (file.stem, name))
            self.assert_box(drawn["mark-frame"], written_box(groups["mark-frame"], left, top, False, 0.15 / 2), (file.stem, "frame"))
            # The page, as Inkscape exports it.
            inkscape("--export-area-page", f"--export-filename={self.folder / 'page.pdf'}", file)
            for pdf in self.folder / "page.pdf", out / f"{file.stem}.pdf":
                box = re.search(rb"/MediaBox\s*\[\s*([\d. ]+)\]", pdf.read_bytes())[1].split()
                size = [float(n) * 25.4 / 72 for n in box[2:]]
                self.assert_box(size, [297, 310], pdf)
        print(f"Inkscape and the files differ by {self.worst:.4f} mm at most")


if __name__ == "__main__":
    unittest.main()
