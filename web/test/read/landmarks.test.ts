import assert from 'node:assert/strict';
import {test} from 'node:test';
import {axes} from '../../src/read/facts';
import {straighten, type Point, type Straight} from '../../src/read/landmarks';
import {tilting, turnOf, type Matrix3, type Placement} from '../../src/read/place';

const head: Point[] = [[0, 95, 0], [-70, 0, 0], [70, 0, 0]];  // nose, left ear, right ear
const plain: Placement = {scale: 1, up: '+z', mirror: false, roll: 0, pitch: 0, front: '+y', yaw: 0};
const apply = (m: Matrix3, p: Point): Point => [0, 1, 2].map((k) => m[3 * k]! * p[0] + m[3 * k + 1]! * p[1] + m[3 * k + 2]! * p[2]) as unknown as Point;
const transposed = (m: Matrix3): Matrix3 => m.map((_, i) => m[3 * (i % 3) + Math.floor(i / 3)]!);
// A scan that stands straight with this placement.
const scanOf = (placement: Placement, points = head): Point[] =>
  points.map((p) => apply(transposed(turnOf({...placement, scale: 1})), p).map((value) => value / placement.scale + 7) as unknown as Point);
const found = (points: Point[], base: Partial<Placement> = {}): Straight => {
  const straight = straighten(points, {...plain, ...base});
  assert.ok(straight);
  return straight;
};
const near = (a: number, b: number, what: string): void => assert.ok(Math.abs(a - b) <= 0.1, `${what}: ${a}, not ${b}`);

// The points in the machine, the ears' middle at the origin.
function placed(points: Point[], placement: Placement): Point[] {
  const all = points.map((p) => apply(turnOf(placement), p)), [, left, right] = all as [Point, Point, Point];
  return all.map((p) => p.map((value, k) => value - (left[k]! + right[k]!) / 2) as unknown as Point);
}

test('finds the numbers that placed a head', () => {
  for (const up of axes)
    for (const front of ['+y', '+x', '-y', '-x'] as const)
      for (const mirror of [false, true]) {
        const placement: Placement = {scale: 10, up, mirror, roll: 12.3, pitch: -21.4, front, yaw: 31.5};
        const straight = found(scanOf(placement), placement);
        assert.equal(straight.front, front);
        assert.equal(straight.flipped, false);
        for (const key of ['roll', 'pitch', 'yaw'] as const) near(straight[key], placement[key], `${key} with ${up} up`);
      }
});

test('a head on its side, or turned round, stands straight afterwards', () => {
  for (const turns of [{roll: 55}, {pitch: -55, yaw: 20}, {yaw: -44.9, front: '-y' as const}, {roll: -30, pitch: 30, yaw: 44}]) {
    const points = scanOf({...plain, up: '-y', ...turns}), straight = found(points, {up: '-y'});
    const stands = placed(points, {...plain, up: '-y', ...straight});
    stands.forEach((p, i) => p.forEach((value, k) => assert.ok(Math.abs(value - head[i]![k]!) < 0.5, `${p} of ${JSON.stringify(turns)}`)));
  }
});

test('a straight head needs no turn', () => {
  assert.deepEqual(found(head), {roll: 0, pitch: 0, front: '+y', yaw: 0, flipped: false});
});

test('a mirror image has its left ear at +x, with the nose in front all the same', () => {
  const points = scanOf({...plain, up: '-y', roll: 10, pitch: 5, yaw: 15}).map(([x, y, z]): Point => [-x, y, z]);
  const straight = found(points, {up: '-y'});
  assert.equal(straight.flipped, true);
  const stands = placed(points, {...plain, up: '-y', ...straight});
  stands.forEach((p, i) => p.forEach((value, k) => assert.ok(Math.abs(value - head[i]![k]! * (k ? 1 : -1)) < 0.5, `${p}`)));
  assert.equal(found(points, {up: '-y', mirror: true}).flipped, false);
});

test('two swapped landmarks and a head upside down look like a mirror image', () => {
  assert.equal(found([head[0]!, head[2]!, head[1]!]).flipped, true);
  assert.equal(found([head[1]!, head[0]!, head[2]!]).flipped, true);
  assert.equal(found(head, {up: '-z'}).flipped, true);
});

test('refuses points that no head has', () => {
  const [nose, left, right] = head as [Point, Point, Point];
  assert.equal(straighten([[0, 15, 0], left, right], plain), null);
  assert.equal(straighten([left, left, right], plain), null);
  assert.equal(straighten([nose, left, left], plain), null);
  assert.equal(straighten(head, {...plain, scale: 0.1}), null);
  assert.equal(straighten(head, {...plain, scale: 3}), null);
  assert.equal(straighten(head, {...plain, up: '+y'}), null);
  found(head.map(([x, y, z]): Point => [x / 10, y / 10, z / 10]), {scale: 10});
});

test('what tilts a scan in the picture goes the way of the hand', () => {
  for (const azimuth of [0, 25, 90, 130, 180, -60, -100])
    for (const [front, yaw] of [['+y', 0], ['+x', 10], ['-x', -40], ['-y', 30]] as const) {
      const [key, sign] = tilting(azimuth, front, yaw), placement: Placement = {...plain, front, yaw};
      // the side that one looks at goes down by a small turn, and hardly sideways
      const a = azimuth * Math.PI / 180, eye: Point = [-Math.sin(a), Math.cos(a), 0];
      const still = transposed(turnOf(placement)), moved = apply(turnOf({...placement, [key]: sign}), apply(still, eye));
      assert.ok(moved[2] < -0.7 * Math.PI / 180, `${key} from ${azimuth}, ${front}, ${yaw}: ${moved}`);
      assert.ok(Math.hypot(moved[0] - eye[0], moved[1] - eye[1]) < 1e-3);
    }
});
