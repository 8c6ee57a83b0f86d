import assert from 'node:assert/strict';
import {test} from 'node:test';
import {distance, Surface, type Point, type SurfacePoint} from '../src/scene/measure';

interface Mesh {
  positions: Float32Array;
  indices: Uint32Array;
}

// An icosahedron whose triangles are divided `times` times, with its corners on a sphere.
function sphere(radius: number, times: number): Mesh {
  const g = (1 + Math.sqrt(5)) / 2;
  const points: number[][] = [[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g], [0, -1, -g], [0, 1, -g],
                              [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]];
  let faces = [[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
               [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]];
  for (let i = 0; i < times; ++i) {
    const middles = new Map<string, number>();
    const middle = (a: number, b: number): number => {
      const key = [a, b].sort().join();
      if (!middles.has(key)) middles.set(key, points.push(points[a].map((v, k) => (v + points[b][k]) / 2)) - 1);
      return middles.get(key)!;
    };
    for (let p = 0; p < points.length; ++p) onSphere(points, p, radius);
    faces = faces.flatMap(([a, b, c]) => {
      const [x, y, z] = [middle(a, b), middle(b, c), middle(c, a)];
      return [[a, x, z], [x, b, y], [z, y, c], [x, y, z]];
    });
  }
  for (let p = 0; p < points.length; ++p) onSphere(points, p, radius);
  return {positions: Float32Array.from(points.flat()), indices: Uint32Array.from(faces.flat())};
}
function onSphere(points: number[][], at: number, radius: number): void {
  const length = Math.hypot(...points[at]);
  points[at] = points[at].map((v) => v * radius / length);
}

// The same triangles, none of which shares a vertex with another.
function apart({positions, indices}: Mesh): Mesh {
  return {positions: Float32Array.from([...indices].flatMap((i) => [...positions.subarray(3 * i, 3 * i + 3)])), indices: indices.map((_, i) => i)};
}

function inside({positions, indices}: Mesh, face: number, a: number, b: number): SurfacePoint {
  const corner = (k: number): number[] => [...positions.subarray(3 * indices[3 * face + k], 3 * indices[3 * face + k] + 3)];
  const [p, q, r] = [corner(0), corner(1), corner(2)];
  return {face, point: p.map((v, k) => v + a * (q[k] - v) + b * (r[k] - v)) as unknown as Point};
}
function* places(mesh: Mesh, count: number): Generator<SurfacePoint> {
  let seed = 12345;
  const random = (): number => (seed = (seed * 1103515245 + 12345) % 2 ** 31) / 2 ** 31;
  for (let i = 0; i < count; ++i) {
    const a = random(), b = random() * (1 - a);
    yield inside(mesh, Math.floor(random() * mesh.indices.length / 3), a, b);
  }
}
const alongPoints = (points: readonly Point[]): number =>
  points.slice(1).reduce((sum, point, i) => sum + distance(points[i], point), 0);

test('a way on a sphere of 75 mm is within 0.1 % of the great circle', () => {
  const mesh = sphere(75, 4);  // edges of 5 mm
  const surface = new Surface(mesh.positions, mesh.indices);
  const all = [...places(mesh, 61)];
  let worst = 0;
  for (let i = 0; i + 1 < all.length; ++i) {
    const [a, b] = [all[i], all[i + 1]];
    const cosine = a.point.reduce((sum, v, k) => sum + v * b.point[k], 0) / Math.hypot(...a.point) / Math.hypot(...b.point);
    const exact = 75 * Math.acos(cosine);
    const way = surface.way(a, b)!;
    assert.ok(way.length >= distance(a.point, b.point) - 1e-6);
    assert.ok(Math.abs(alongPoints(way.points) - way.length) < 1e-3, 'the drawn line is as long as the figure');
    const error = Math.abs(way.length - exact) / exact;
    // Almost opposite each other, ways in all directions are almost equally long.
    if (exact > 75 * Math.PI * 0.95) assert.ok(error < 0.01);
    else worst = Math.max(worst, error);
  }
  console.log(`largest error ${(100 * worst).toFixed(3)} %`);
  assert.ok(worst < 0.001, `${worst}`);
});

test('the error on a sphere falls with the square of the edge length', () => {
  const errorAt = (times: number): number => {
    const mesh = sphere(75, times);
    const [a, b] = [inside(mesh, 0, 0.3, 0.3), inside(mesh, Math.floor(mesh.indices.length / 6), 0.2, 0.4)];
    const cosine = a.point.reduce((sum, v, k) => sum + v * b.point[k], 0) / Math.hypot(...a.point) / Math.hypot(...b.point);
    return Math.abs(new Surface(mesh.positions, mesh.indices).way(a, b)!.length - 75 * Math.acos(cosine));
  };
  assert.ok(errorAt(5) < errorAt(2) / 16, `${errorAt(2)} ${errorAt(5)}`);
});

test('on a bent strip of paper the way is exact', () => {
  // A cylinder of radius 20: unrolled, it is a plane with x along the arc.
  const n = 40, positions: number[] = [], indices: number[] = [], turnOf = (i: number): number => i / n * Math.PI;
  for (let j = 0; j <= n; ++j)
    for (let i = 0; i <= n; ++i) positions.push(20 * Math.cos(turnOf(i)), 20 * Math.sin(turnOf(i)), j * 1.7);
  for (let j = 0; j < n; ++j)
    for (let i = 0; i < n; ++i) {
      const a = j * (n + 1) + i;
      indices.push(a, a + 1, a + n + 2, a, a + n + 2, a + n + 1);
    }
  const mesh = {positions: Float32Array.from(positions), indices: Uint32Array.from(indices)};
  const chord = 2 * 20 * Math.sin(Math.PI / n / 2);  // of a facet
  const flat = (face: number, a: number, b: number): [number, number] => {
    const cell = Math.floor(face / 2), i = cell % n, j = Math.floor(cell / n);
    return face % 2 === 0 ? [(i + a + b) * chord, (j + b) * 1.7] : [(i + a) * chord, (j + a + b) * 1.7];
  };
  const surface = new Surface(mesh.positions, mesh.indices);
  for (const [f, g] of [[3, 3150], [1001, 2222], [79, 3120], [0, 3199]]) {
    const [p, q] = [flat(f, 0.2, 0.3), flat(g, 0.5, 0.1)];
    const way = surface.way(inside(mesh, f, 0.2, 0.3), inside(mesh, g, 0.5, 0.1))!;
    assert.ok(Math.abs(way.length - Math.hypot(p[0] - q[0], p[1] - q[1])) < 1e-4, `${way.length}`);
  }
});

test('triangles that share places but no vertices are one surface', () => {
  const joined = sphere(75, 3), loose = apart(joined);
  const a = inside(joined, 5, 0.2, 0.2), b = inside(joined, 900, 0.2, 0.2);
  assert.ok(Math.abs(new Surface(joined.positions, joined.indices).way(a, b)!.length -
                     new Surface(loose.positions, loose.indices).way(a, b)!.length) < 1e-6);
});

test('between separate surfaces there is no way', () => {
  const positions = Float32Array.from([0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0]);
  const mesh = {positions, indices: Uint32Array.from([0, 1, 2, 3, 4, 5])};
  assert.equal(new Surface(mesh.positions, mesh.indices).way(inside(mesh, 0, 0.2, 0.2), inside(mesh, 1, 0.2, 0.2)), null);
});
