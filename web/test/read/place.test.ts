import assert from 'node:assert/strict';
import {test} from 'node:test';
import {axes} from '../../src/read/facts';
import {frontOfGltf, place, quartered, turnOf, type Matrix3, type Placement} from '../../src/read/place';

const plain: Placement = {scale: 1, up: '+z', mirror: false, roll: 0, pitch: 0, front: '+y', yaw: 0};
const apply = (m: Matrix3, p: number[]): number[] =>
  [0, 1, 2].map((k) => Math.round((m[3 * k]! * p[0]! + m[3 * k + 1]! * p[1]! + m[3 * k + 2]! * p[2]!) * 1e9) / 1e9 + 0);
const determinant = (m: Matrix3): number =>
  m[0]! * (m[4]! * m[8]! - m[5]! * m[7]!) - m[1]! * (m[3]! * m[8]! - m[5]! * m[6]!) + m[2]! * (m[3]! * m[7]! - m[4]! * m[6]!);
const unit = (axis: string): number[] => ['x', 'y', 'z'].map((name) => axis[1] === name ? (axis[0] === '+' ? 1 : -1) : 0);

test('brings each up axis to the ceiling without mirroring', () => {
  for (const up of axes) {
    assert.deepEqual(apply(turnOf({...plain, up}), unit(up)), [0, 0, 1]);
    assert.equal(Math.round(determinant(turnOf({...plain, up}))), 1);
  }
});

test('brings each front side to +y', () => {
  for (const front of ['+x', '-x', '+y', '-y'] as const) assert.deepEqual(apply(turnOf({...plain, front}), unit(front)), [0, 1, 0]);
});

test('finds the front of a glTF file, its +z, in the upright scan', () => {
  const of = (up: Placement['up'], mirror = false, roll = 0, pitch = 0): string => frontOfGltf({up, mirror, roll, pitch}) ?? 'none';
  assert.deepEqual(axes.map((up) => `${up} ${of(up)}`), ['+x -x', '-x +x', '+y -y', '-y +y', '+z none', '-z none']);
  assert.deepEqual([of('+x', true), of('-x', true), of('+y', true)], ['+x', '-x', '-y']);
  assert.deepEqual([of('+y', false, 40), of('+y', false, 50), of('+z', false, 50), of('+z', false, 0, 90)], ['-y', 'none', '-y', '+x']);
  for (const up of ['+x', '-x', '+y', '-y'] as const)
    for (const mirror of [false, true])
      assert.deepEqual(apply(turnOf({...plain, up, mirror, front: frontOfGltf({up, mirror, roll: 0, pitch: 0})!}), [0, 0, 1]), [0, 1, 0]);
});

test('takes quarter turns from a yaw into the front, without moving the scan', () => {
  for (const front of ['+x', '-x', '+y', '-y'] as const)
    for (const yaw of [-180, -135.5, -90, -50, -45, 0, 12.3, 45, 46, 90, 137, 180]) {
      const same = quartered(front, yaw);
      assert.ok(Math.abs(same.yaw) <= 45, `${front} ${yaw} ${same.yaw}`);
      turnOf({...plain, ...same}).forEach((value, i) => assert.ok(Math.abs(value - turnOf({...plain, front, yaw})[i]!) < 1e-9));
    }
});

test('turns in the fixed order: up, mirror, roll, pitch, front, yaw', () => {
  // +y up lies: its x stays, its z goes to -y. A roll of 90 about x brings +y to +z, then a pitch of 90 about y +z to +x.
  assert.deepEqual(apply(turnOf({...plain, roll: 90}), [0, 1, 0]), [0, 0, 1]);
  assert.deepEqual(apply(turnOf({...plain, roll: 90, pitch: 90}), [0, 1, 0]), [1, 0, 0]);
  assert.deepEqual(apply(turnOf({...plain, roll: 90, pitch: 90, front: '+x'}), [0, 1, 0]), [0, 1, 0]);
  assert.deepEqual(apply(turnOf({...plain, roll: 90, pitch: 90, front: '+x', yaw: 90}), [0, 1, 0]), [-1, 0, 0]);
  assert.deepEqual(apply(turnOf({...plain, mirror: true, yaw: 90}), [1, 0, 0]), [0, -1, 0]);
  assert.ok(determinant(turnOf({...plain, mirror: true})) < 0);
});

test('the scale is in every direction', () => {
  assert.equal(Math.round(determinant(turnOf({...plain, scale: 10, yaw: 30, roll: 20}))), 1000);
});

// A cylinder of radius 60 around (20, -30), from z = 5 to 105.
const cylinder = new Float32Array(Array.from({length: 360}, (_, i) => i * Math.PI / 180)
  .flatMap((a) => [5, 105].flatMap((z) => [20 + 60 * Math.cos(a), -30 + 60 * Math.sin(a), z])));

test('stands the scan on the platform over the middle', () => {
  const placed = place(cylinder, plain, 0);
  [-20, 30, -5].forEach((value, k) => assert.ok(Math.abs(placed.shift[k]! - value) < 0.1, `${placed.shift}`));
  assert.ok(Math.abs(placed.height - 100) < 1e-3 && placed.half.every((value) => Math.abs(value - 60) < 0.1));
});

test('names the highest place of the scan as it stands', () => {
  const {top} = place(new Float32Array([-40, 0, 0, 40, 0, 0, 0, 40, 0, 0, -40, 0, 10, -20, 90]), {...plain, front: '+x'}, 0);
  [20, 10].forEach((value, k) => assert.ok(Math.abs(top[k]! - value) < 0.1, `${top}`));  // a quarter turn to the left
});

test('the cut is on the platform, or on the plug', () => {
  const placed = place(cylinder, plain, 40, 15);
  assert.ok(Math.abs(placed.shift[2] - (15 - 45)) < 1e-3);
  assert.ok(Math.abs(placed.height - 75) < 1e-3);
  assert.ok(Math.abs(placed.size[2] - 100) < 1e-3);
});
