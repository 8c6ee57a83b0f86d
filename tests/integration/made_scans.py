"""Scans that the tests make themselves. Each is written once, into a folder that ends with the process."""
import functools
import pathlib
import random
import tempfile

import scan_files
import scan_generator
import scan_shapes
from harness import vacuform


@functools.cache
def folder():
    return tempfile.TemporaryDirectory(prefix="vacuform-scans-")


def written(name, data):
    path = pathlib.Path(folder().name, name)
    path.write_bytes(data)
    return path


@functools.cache
def sample(head):
    out = pathlib.Path(folder().name, head)
    done = vacuform("sample", "--head", head, "--out", out)
    assert done.returncode == 0, done.stderr
    return out / "head.stl"


@functools.cache
def newborn():
    """The bundled head form at the size of a newborn's: 93 x 119 mm, smooth, binary STL."""
    return written("newborn.stl", sample("newborn").read_bytes())


@functools.cache
def adult():
    return written("adult.stl", sample("adult").read_bytes())


@functools.cache
def figurine():
    """A relief 60 mm high with two horns and a muzzle, saddles between them, and ears that overhang, in mm."""
    parts = [scan_shapes.ellipsoid((0, 0, 8), (52, 68, 40)), scan_shapes.ellipsoid((0, -24, 40), (17, 26, 20))]
    for side in -1, 1:
        parts.append(scan_shapes.capsule((side * 17, 20, 32), (side * 26, 31, 42), 14, 12))
        parts.append(scan_shapes.ellipsoid((side * 50, 8, 10), (8, 12, 7)))
    return written("figurine.stl", scan_files.stl(scan_shapes.meshed(scan_shapes.union(parts, 8), (-70, -72, 0), (70, 72, 66), 3.5)))


@functools.cache
def bust():
    """Head and shoulders, 2.7 units high: no unit of length makes that a plausible size."""
    mesh = scan_shapes.bust(random.Random(1))
    return written("bust.obj", scan_files.obj(scan_shapes.scaled(mesh, 2.7 / max(p[2] for p in mesh[0]))))


@functools.cache
def damaged():
    """A head in metres with noise, a hole and an open neck."""
    scan = scan_generator.Scan("damaged", 24)
    assert (scan.kind, scan.unit, scan.holes, scan.open_below) == ("head", "m", 1, True) and scan.noise > 0, scan.damage()
    return written("damaged." + scan.extension, scan.data)


@functools.cache
def corrupt():
    """A GLB that went through a copy as text: what is no UTF-8 is replaced by U+FFFD."""
    data = scan_files.glb(scan_shapes.block((0, 0, 0), (90, 110, 80), 7))
    return written("corrupt-head.glb", data.decode("utf-8", "replace").encode())
