"""Prints how far the print moves off the head when the scan is turned, mirrored, shifted or scaled.

    python3 tests/bench/invariance.py BIN SCAN.stl [--grid MM ...]

Turns the file's own points about z, mirrors, shifts and scales them (with every length of sheet and machine), runs
`vacuform run` on each, and follows every vertex of the sheet that lies on the first head to where the same point of the
other sheet lies: the distance, moved back, in millimetres of the first head. Only triangles that touch the head with all
corners count, on both sheets: nothing else is printed on. The window is round, so that it turns too.
"""
import argparse
import math
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "integration"))
import meshes

DOT = ('<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="20mm" viewBox="-10 -10 20 20">'
       '<circle r="6" fill="none" stroke="black"/></svg>')
MOLD = 1  # the contact of formed.ply


class Motion:
    """Mirrors x, turns about z, scales, then shifts."""

    def __init__(self, degrees=0.0, mirror=False, scale=1.0, shift=(0.0, 0.0, 0.0)):
        self.cos, self.sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        self.mirror, self.scale, self.shift = mirror, scale, shift

    def plane(self, x, y):
        x = -x if self.mirror else x
        return self.scale * (self.cos * x - self.sin * y), self.scale * (self.sin * x + self.cos * y)

    def of_file(self, triangles):
        moved = []
        for triangle in triangles:
            corners = [(*self.plane(x, y), self.scale * z) for x, y, z in triangle]
            corners = [tuple(a + b for a, b in zip(p, self.shift)) for p in corners]
            moved.append(corners[::-1] if self.mirror else corners)
        return moved


class Formed:
    def __init__(self, folder):
        ply = meshes.Ply((folder / "formed.ply").read_bytes())
        self.rest, self.points = list(zip(ply.vertices["s"], ply.vertices["t"])), ply.points
        self.faces, self.contact = ply.faces, ply.vertices["contact"]
        self.printed = {v for face in self.faces if self.lies_on_head(face) for v in face}
        self.cell = 2 * max(abs(self.rest[a][0] - self.rest[b][0]) for a, b, _ in self.faces)
        self.cells = {}
        for face in self.faces:
            spans = [sorted(int(self.rest[v][axis] // self.cell) for v in face) for axis in (0, 1)]
            for i in range(spans[0][0], spans[0][2] + 1):
                for j in range(spans[1][0], spans[1][2] + 1):
                    self.cells.setdefault((i, j), []).append(face)

    def lies_on_head(self, face):
        return all(self.contact[v] == MOLD for v in face)

    def at(self, s, t):
        """Where a point of the flat sheet lies, or None off the head."""
        for face in self.cells.get((int(s // self.cell), int(t // self.cell)), ()):
            (s0, t0), (s1, t1), (s2, t2) = (self.rest[v] for v in face)
            whole = (s1 - s0) * (t2 - t0) - (t1 - t0) * (s2 - s0)
            if whole == 0:
                continue
            second = ((s - s0) * (t2 - t0) - (t - t0) * (s2 - s0)) / whole
            third = ((s1 - s0) * (t - t0) - (t1 - t0) * (s - s0)) / whole
            weights = 1 - second - third, second, third
            if min(weights) >= -1e-6:
                return self.lies_on_head(face) and [sum(w * self.points[v][k] for w, v in zip(weights, face)) for k in range(3)]
        return None


def formed(bin_folder, folder, triangles, grid, scale):
    folder.mkdir()
    (folder / "scan.stl").write_bytes(meshes.stl(triangles))
    (folder / "pattern.svg").write_text(DOT)
    lengths = {"sheet.width_mm": 320, "sheet.height_mm": 320, "sheet.thickness_mm": 1, "sheet.resolution_mm": grid,
               "machine.window_width_mm": 300, "machine.drape_speed_mm_s": 50, "forming.step_mm": grid / 1.5}
    words = [f"{name}={scale * value:.12g}" for name, value in lengths.items()]
    words += ["machine.window=circle", "scan.units=mm", "scan.up=+z", "print.dpi=72", "print.marks=false"]
    done = subprocess.run([bin_folder / "vacuform", "run", "--scan", folder / "scan.stl", "--pattern", folder / "pattern.svg",
                           "--out", folder, "--quiet", *(w for s in words for w in ("--set", s))],
                          capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(done.stderr)
    return Formed(folder)


def distances(first, other, motion):
    for v in first.printed:
        rest, place = first.rest[v], first.points[v]
        if there := other.at(*motion.plane(*rest)):
            yield math.dist(there, (*motion.plane(*place[:2]), motion.scale * place[2])) / motion.scale


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("scan", type=pathlib.Path)
    parser.add_argument("--grid", type=float, nargs="+", default=[1.5])
    arguments = parser.parse_args()
    motions = {"turned by 30 degrees": Motion(30), "turned by 45 degrees": Motion(45), "turned by 90 degrees": Motion(90),
               "mirrored": Motion(mirror=True), "scaled by 2": Motion(scale=2),
               "shifted by 1.2 m": Motion(shift=(700.0, -900.0, 400.0))}
    scan = meshes.read_stl(arguments.scan.read_bytes())
    print(f"{'scan':22s} {'grid mm':>7s} {'mean mm':>8s} {'p95 mm':>8s} {'p99 mm':>8s} {'max mm':>8s}")
    for grid in arguments.grid:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            first = formed(arguments.bin, folder / "first", scan, grid, 1)
            for k, (name, motion) in enumerate(motions.items()):
                other = formed(arguments.bin, folder / str(k), motion.of_file(scan), grid, motion.scale)
                d = sorted(distances(first, other, motion))
                share = lambda part: d[math.ceil(part * len(d)) - 1]
                print(f"{name:22s} {grid:7.2f} {sum(d) / len(d):8.4f} {share(.95):8.4f} {share(.99):8.4f} {d[-1]:8.4f}", flush=True)


if __name__ == "__main__":
    main()
