import assert from 'node:assert/strict';
import {test} from 'node:test';
import {Orbit, sectorOf, viewOf, viewOrder, type Pose} from '../../src/scene/orbit';

const pose = (azimuth: number, elevation: number): Pose => ({azimuth, elevation, zoom: 1, x: 0, y: 0, z: 0});
const names = ['front', 'back', 'minus_x', 'plus_x', 'above', 'below'] as const;

// Where the camera is: the face looks along +y.
const direction = ({azimuth, elevation}: Pose): number[] => {
  const a = azimuth * Math.PI / 180, e = elevation * Math.PI / 180;
  return [-Math.sin(a) * Math.cos(e), Math.cos(a) * Math.cos(e), Math.sin(e)].map((value) => Math.round(value * 1e6) / 1e6 + 0);
};

test('each named view looks from where its name says', () => {
  const orbit = new Orbit(() => {});
  const from = Object.fromEntries(names.map((name) => {
    orbit.view(name);
    assert.equal(viewOf(orbit.pose), name);
    return [name, direction(orbit.pose)];
  }));
  assert.deepEqual(from, {front: [0, 1, 0], back: [0, -1, 0], minus_x: [-1, 0, 0], plus_x: [1, 0, 0], above: [0, 0, 1], below: [0, 0, -1]});
});

test("the third key shows the patient's left, the fourth the right", () => {
  assert.deepEqual(viewOrder('minus_x').slice(2, 4), ['minus_x', 'plus_x']);
  assert.deepEqual(viewOrder('plus_x').slice(2, 4), ['plus_x', 'minus_x']);
  assert.deepEqual(viewOrder('unknown').slice(2, 4), ['minus_x', 'plus_x']);
});

test('the spoken sector is that of the named view', () => {
  const orbit = new Orbit(() => {});
  const spoken = names.map((name) => {
    orbit.view(name);
    const {eighth, height} = sectorOf(orbit.pose);
    return height === 0 ? eighth : `height ${height}`;
  });
  assert.deepEqual(spoken, [0, 4, 2, 6, 'height 2', 'height -2']);
  assert.deepEqual(sectorOf(pose(30, 20)), {eighth: 1, height: 1});
  assert.deepEqual(sectorOf(pose(-30, -20)), {eighth: 7, height: -1});
  assert.deepEqual(sectorOf(pose(-179, 0)), {eighth: 4, height: 0});
});

test('a sphere that was fitted is inside of the picture at any shape of the frame', () => {
  const orbit = new Orbit(() => {});
  orbit.fit(0, 0, 80, 150);
  for (const aspect of [0.5, 1, 1.6]) {
    const seen = Math.asin(150 / orbit.distance(aspect));  // half the angle of the sphere
    const half = Math.min(orbit.halfAngle, Math.atan(Math.tan(orbit.halfAngle) * aspect));
    assert.ok(seen <= half + 1e-9 && seen > 0.99 * half, `${seen} of ${half}`);
  }
});

test('the camera follows a new fit until a person moves it', () => {
  const orbit = new Orbit(() => {});
  orbit.fit(1, 2, 3, 100);
  assert.equal(orbit.pose.z, 3);
  orbit.move({zoom: 2});
  orbit.fit(1, 2, 9, 100);
  assert.equal(orbit.pose.z, 3);
  orbit.home();
  assert.equal(orbit.pose.z, 9);
  assert.equal(orbit.pose.zoom, 1);
});

test('panning moves the model with the hand', () => {
  const orbit = new Orbit(() => {});
  orbit.view('front');  // +x is on the left of the picture
  orbit.pan(10, 5);
  assert.deepEqual([orbit.pose.x, orbit.pose.y, orbit.pose.z].map((value) => Math.round(value * 1e6) / 1e6 + 0), [10, 0, -5]);
});

test('the text of a camera restores it; other text changes nothing', () => {
  const orbit = new Orbit(() => {}), other = new Orbit(() => {});
  orbit.move({azimuth: -123.456, elevation: 12, zoom: 2.5, x: 1, y: -2, z: 30});
  other.text = orbit.text;
  assert.equal(other.text, '-123.46_12_2.5_1_-2_30');
  for (const text of ['', '1_2_3', 'a_b_c_d_e_f', '1_2_NaN_0_0_0']) other.text = text;
  assert.equal(other.text, orbit.text);
});

test('turns past the poles and past the back stay in range', () => {
  const orbit = new Orbit(() => {});
  orbit.turn(-500, 500);
  assert.equal(orbit.pose.elevation, 90);
  assert.ok(Math.abs(orbit.pose.azimuth) <= 180);
});
