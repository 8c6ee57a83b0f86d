import assert from 'node:assert/strict';
import {test} from 'node:test';
import {cluster, forScreen} from '../../src/read/cluster';
import {factsOf, sizesOf, unitOf} from '../../src/read/facts';
import {prepare} from '../../src/read/prepare';
import {readScan} from '../../src/read/scan';
import {corners, faces, stlBinary} from './files';

type Point = [number, number, number];

// A sphere of `rings` rings; `open`: without the cap at -z.
function sphere(radius: number, rings: number, open = false): Uint8Array {
  const points: Point[] = [], triangles: Point[] = [], columns = 2 * rings;
  for (let i = 0; i <= rings; ++i)
    for (let j = 0; j <= columns; ++j) {
      const a = Math.PI * i / rings, b = 2 * Math.PI * j / columns;
      points.push([radius * Math.sin(a) * Math.cos(b), radius * Math.sin(a) * Math.sin(b), radius * Math.cos(a)]);
    }
  for (let i = 0; i < (open ? Math.round(rings * 0.7) : rings); ++i)
    for (let j = 0; j < columns; ++j) {
      const p = i * (columns + 1) + j, q = p + columns + 1;
      if (i > 0) triangles.push([p, q, p + 1]);
      if (i < rings - 1) triangles.push([p + 1, q, q + 1]);
    }
  return stlBinary(points, triangles);
}

test('guesses the unit only if one makes a plausible size', () => {
  const of = (side: number) => unitOf(factsOf(readScan(sphere(side / 2, 8), 'a.stl')));
  assert.equal(of(190), 'mm');
  assert.equal(of(0.19), 'm');
  assert.equal(of(19), 'cm');
  assert.equal(of(7.5), 'in');
  assert.equal(of(10), undefined);    // 100 mm or 254 mm
  assert.equal(of(3000), undefined);
  assert.equal(of(115_000), 'um');
  assert.equal(of(0.6), undefined);   // 183 mm in feet, or 600 mm in metres
});

test('compares the size in each unit with heads', () => {
  const sizes = sizesOf(factsOf(readScan(stlBinary(), 'a.stl')));  // 100 x 150 x 200
  assert.deepEqual(sizes.map(({unit, like}) => `${unit} ${like}`), ['mm adult', 'cm large', 'm large', 'in large', 'um small', 'ft large']);
  assert.deepEqual(sizes[1]!.mm.map(Math.round), [1000, 1500, 2000]);
  const newborn = sizesOf(factsOf(readScan(sphere(5.5, 8), 'a.stl')));  // 11 across
  assert.deepEqual(newborn.map(({unit, like}) => `${unit} ${like}`), ['mm small', 'cm newborn', 'm large', 'in adult', 'um small', 'ft large']);
});

test('the opening of a scan tells which side is up', () => {
  const facts = factsOf(readScan(sphere(90, 20, true), 'a.stl'));
  assert.deepEqual(facts.up, {axis: '+z', told: true});
  const mesh = readScan(sphere(90, 20, true), 'a.stl');
  for (let i = 0; i < mesh.positions.length; i += 3) {
    const [x, y, z] = mesh.positions.slice(i, i + 3) as unknown as Point;
    mesh.positions.set([y, z, x], i);  // a turn: z becomes y
  }
  assert.deepEqual(factsOf(mesh).up, {axis: '+y', told: true});
});

test('a flat foot tells which side is up, a sphere tells nothing', () => {
  const dome = readScan(sphere(90, 20), 'a.stl');
  for (let i = 0; i < dome.positions.length; i += 3) dome.positions[i] = Math.max(dome.positions[i]!, -50);
  assert.deepEqual(factsOf(dome).up, {axis: '+x', told: true});
  assert.deepEqual(factsOf(readScan(sphere(90, 20), 'a.stl')).up, {axis: '+z', told: false});
});

test('knows triangles that face inwards', () => {
  assert.equal(factsOf(readScan(stlBinary(), 'a.stl')).insideOut, false);
  assert.equal(factsOf(readScan(stlBinary(corners, faces.map(([a, b, c]) => [a, c, b])), 'a.stl')).insideOut, true);
  const mirrored = corners.map(([x, y, z]): Point => [-x, y, z]);
  assert.equal(factsOf(readScan(stlBinary(mirrored), 'a.stl')).insideOut, true);
});

test('corners at one place become one for the screen, with normals that point outwards', () => {
  const shown = forScreen(readScan(stlBinary(), 'a.stl'), 1000);
  assert.equal(shown.positions.length, 24);
  assert.equal(shown.indices.length, 36);
  for (let i = 0; i < 8; ++i)
    for (let k = 0; k < 2; ++k)
      assert.equal(Math.sign(shown.normals[4 * i + k]!), Math.sign(shown.positions[3 * i + k]!));
});

test('a mesh with too many triangles becomes coarser and keeps its shape', () => {
  const mesh = readScan(sphere(100, 200), 'a.stl');  // 159,600 triangles
  const shown = forScreen(mesh, 20_000);
  assert.ok(shown.indices.length <= 60_000 && shown.indices.length > 15_000, `${shown.indices.length / 3} triangles`);
  for (let i = 0; i < shown.positions.length; i += 3) {
    const r = Math.hypot(...shown.positions.slice(i, i + 3));
    assert.ok(r > 98 && r < 100.001, `a corner at ${r} mm`);
  }
});

test('clustering keeps every triangle whose corners stay apart', () => {
  const mesh = readScan(stlBinary(), 'a.stl');
  assert.equal(cluster(mesh, 1).indices.length, 36);
  assert.equal(cluster(mesh, 1000).indices.length, 0);
});

test('prepares facts of the whole scan and a mesh that can be shown', () => {
  const scan = prepare(sphere(95, 400), 'a.stl');  // 638,400 triangles
  assert.equal(scan.facts.triangles, 638_400);
  assert.ok(scan.shown.indices.length / 3 <= 500_000);
  assert.ok(scan.coarse && scan.coarse.indices.length / 3 <= 40_000);
});
