"""Small files that ask for much work: a job may cost a few seconds of processor time more than with a plain file, or is
refused with a reason."""
import json
import math
import os
import random
import resource
import signal
import struct
import subprocess
import time
import unittest
import zlib

from harness import BIN, Case

MOST_SECONDS = 6  # of processor time beyond a plain drawing; without bounds these took 17 to more than 142


def png(path, width, height, depth, rows):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    raw = b"".join(b"\0" + row for row in rows)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, 0, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b""))


def noise(path, width, height, depth):
    dice = random.Random(width + depth)
    png(path, width, height, depth, [bytes(dice.randrange(256) for _ in range(width * depth // 8)) for _ in range(height)])


def ring(path):
    png(path, 100, 100, 8, [bytes(0 if 30 < math.hypot(x - 50, y - 50) < 35 else 255 for x in range(100)) for y in range(100)])


def nodes(path, count):
    """A GLB whose nodes share one small ball."""
    rings = 8
    points, corners = [], []
    for i in range(rings + 1):
        for j in range(rings):
            polar, around = i * math.pi / rings, 2 * math.pi * j / rings
            points += [60 * math.sin(polar) * math.cos(around), 60 * math.cos(polar), 60 * math.sin(polar) * math.sin(around)]
    for i in range(rings):
        for j in range(rings):
            a, b = i * rings + j, i * rings + (j + 1) % rings
            corners += [a, b, a + rings, b, b + rings, a + rings]
    data = struct.pack(f"<{len(points)}f", *points), struct.pack(f"<{len(corners)}H", *corners)
    text = json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(count))}], "nodes": [{"mesh": 0}] * count,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(points) // 3, "type": "VEC3", "min": [-60] * 3, "max": [60] * 3},
                      {"bufferView": 1, "componentType": 5123, "count": len(corners), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(data[0])},
                        {"buffer": 0, "byteOffset": len(data[0]), "byteLength": len(data[1])}],
        "buffers": [{"byteLength": len(data[0]) + len(data[1])}]}, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary = b"".join(data)
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + 8 + len(text) + 8 + len(binary)) +
                     struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary)


def obj(path, count, faces):
    """Vertices 1 and 2 on the axis, the others on a circle around it."""
    lines = ["v 0 0 100", "v 0 0 0"]
    lines += [f"v {80 * math.cos(2 * math.pi * i / count):.4f} {80 * math.sin(2 * math.pi * i / count):.4f} 50" for i in range(count)]
    path.write_text("\n".join(lines + faces) + "\n")


def fan(path, count):
    pairs = [(3 + i, 3 + (i + 1) % count) for i in range(count)]
    obj(path, count, [f"f 1 {a} {b}\nf 2 {b} {a}" for a, b in pairs])


def one_edge(path, count):
    obj(path, count, [f"f 1 2 {3 + i}" for i in range(count)])


def one_face(path, count):
    obj(path, count, ["f " + " ".join(str(3 + i) for i in range(count))])


def stops(path, count):
    lines = [f'<stop offset="{i / count:.6f}" stop-color="#{i * 7919 % 0xffffff:06x}"/>' for i in range(count)]
    path.write_text('<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100"><defs>'
                    '<linearGradient id="g">' + "".join(lines) + '</linearGradient></defs>'
                    '<circle cx="50" cy="50" r="30" fill="none" stroke="url(#g)" stroke-width="2"/></svg>')


def seconds_of_children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class BoundedWork(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        subprocess.run([BIN / "vacuform", "sample", "--out", cls.folder / "sample"], check=True, capture_output=True)

    def run_with(self, *words):
        before = seconds_of_children()
        done = subprocess.run([BIN / "vacuform", *words, "--out", self.folder / "out"], capture_output=True, text=True, timeout=300)
        return done, seconds_of_children() - before

    def print_with(self, pattern):
        return self.run_with("run", "--scan", self.folder / "sample/head.stl", "--pattern", pattern, "--set=pattern.width_mm=100", "--preview")

    def test_drawings(self):
        plain = self.folder / "ring.png"
        ring(plain)
        done, usual = self.print_with(plain)
        self.assertEqual(done.returncode, 0, done.stderr)
        for name, make in {"noise of 1 bit": lambda p: noise(p, 120, 120, 1), "noise of 8 bits": lambda p: noise(p, 100, 90, 8),
                           "much noise": lambda p: noise(p, 300, 300, 8)}.items():
            with self.subTest(name):
                file = self.folder / "pattern.png"
                make(file)
                done, seconds = self.print_with(file)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertLess(seconds, usual + MOST_SECONDS)

    def test_a_gradient_of_many_stops_is_refused(self):
        file = self.folder / "stops.svg"
        stops(file, 100_000)
        done, seconds = self.print_with(file)
        self.assertEqual(done.returncode, 2)
        self.assertIn("a gradient of the SVG has too many stops: 100000, above the limit of 1000", done.stderr)
        self.assertLess(seconds, 2 * MOST_SECONDS)
        stops(file, 900)
        self.assertEqual(self.print_with(file)[0].returncode, 0)

    def test_scans(self):
        for name, extension, make, says in [
                ("a few nodes", "glb", lambda p: nodes(p, 20), None),
                ("many nodes", "glb", lambda p: nodes(p, 15_000), "in the same place"),
                ("a fan", "obj", lambda p: fan(p, 150_000), "in the same place"),
                ("triangles on one edge", "obj", lambda p: one_edge(p, 150_000), "in the same place"),
                ("one face", "obj", lambda p: one_face(p, 200_000), "in the same place"),
                ("two cones", "obj", lambda p: fan(p, 300), None)]:
            with self.subTest(name):
                file = self.folder / f"scan.{extension}"
                make(file)
                done, seconds = self.run_with("inspect", "--scan", file, "--set=scan.units=mm")
                self.assertEqual(done.returncode, 2 if says else 0, done.stderr)
                self.assertIn(says or "", done.stderr)
                self.assertLess(seconds, MOST_SECONDS)

    def test_work_ends_when_it_is_cancelled(self):
        file = self.folder / "crowded.obj"
        fan(file, 1000)  # just within the limit: each search looks at hundreds of triangles
        for after in 0.3, 1, 2:
            process = subprocess.Popen([BIN / "vacuform", "inspect", "--scan", file, "--set=scan.units=mm", "--out", self.folder / "out"],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(after)
            process.send_signal(signal.SIGINT)
            began = time.monotonic()
            process.wait(timeout=60)
            self.assertLess(time.monotonic() - began, 1 if os.getloadavg()[0] < 2 else 5)


if __name__ == "__main__":
    unittest.main()
