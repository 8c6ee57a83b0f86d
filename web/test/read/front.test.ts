// The picture from the front: which side is where, what hides what, and where the cut is.
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {forScreen} from '../../src/read/cluster';
import {frontPicture, type FrontPicture} from '../../src/read/front';
import {turnOf, type Placement} from '../../src/read/place';

type Box = [low: [number, number, number], high: [number, number, number]];
function boxes(...all: Box[]) {
  const positions: number[] = [], indices: number[] = [];
  for (const [low, high] of all) {
    const first = positions.length / 3;
    for (let i = 0; i < 8; ++i) positions.push(...[0, 1, 2].map((k) => (i >> k & 1 ? high : low)[k]!));
    for (const [a, b, c, d] of [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] as const)
      indices.push(...[a, b, c, a, c, d].map((i) => first + i));
  }
  return forScreen({positions: new Float32Array(positions), indices: new Uint32Array(indices)}, 1e6);
}
// A head of 120 x 160 x 200 mm, off centre, with a block at its left ear (-x, upper half) alone.
const head = (): ReturnType<typeof boxes> => boxes([[10, -30, 5], [130, 130, 205]], [[-10, 30, 105], [10, 50, 155]]);
const upright: Placement = {scale: 1, up: '+z', mirror: false, roll: 0, pitch: 0, front: '+y', yaw: 0};
const alpha = ({width, pixels}: FrontPicture, x: number, y: number): number => pixels[4 * (y * width + x) + 3]!;

test('the left ear at -x is on the right of the picture', () => {
  const picture = frontPicture(head(), turnOf(upright), 0, 402);
  assert.equal(picture.height, 402);
  assert.equal(picture.width, 282);  // 140 mm at 2 pixels a mm
  assert.equal(alpha(picture, 270, 150), 255);  // the ear: 105 to 155 mm up, 20 mm wide
  assert.equal(alpha(picture, 270, 300), 0);
  assert.equal(alpha(picture, 10, 150), 255);   // the head begins at the left edge
  let ear = 0;
  for (let y = 0; y < picture.height; ++y) for (let x = 242; x < picture.width; ++x) ear += alpha(picture, x, y) ? 1 : 0;
  assert.ok(Math.abs(ear - 40 * 100) < 300, String(ear));
});

test('turned by half, the same ear is on the left, and mirrored too', () => {
  for (const other of [{...upright, front: '-y' as const}, {...upright, mirror: true}, {...upright, yaw: 180}]) {
    const picture = frontPicture(head(), turnOf(other), 0, 402);
    assert.equal(alpha(picture, 10, 150), 255);
    assert.equal(alpha(picture, 10, 300), 0);
    assert.equal(alpha(picture, 270, 300), 255);
  }
});

test('a scan that lies is upright in the picture, in any unit', () => {
  const lying = head();  // y up: the crown at +y
  for (let i = 0; i < lying.positions.length; i += 3) {
    const [y, z] = [lying.positions[i + 1]!, lying.positions[i + 2]!];
    lying.positions[i + 1] = z;
    lying.positions[i + 2] = -y;
  }
  const picture = frontPicture(lying, turnOf({...upright, up: '+y', scale: 0.1}), 0, 402);
  assert.deepEqual([picture.width, picture.height], [282, 402]);
  assert.equal(alpha(picture, 270, 150), 255);
  assert.equal(alpha(picture, 270, 300), 0);
});

test('what is cut away is translucent, and the face above it is not', () => {
  const picture = frontPicture(head(), turnOf(upright), 50, 402);
  assert.equal(alpha(picture, 100, 295), 255);
  const below = alpha(picture, 100, 306);
  assert.ok(below > 0 && below < 160, String(below));
});

test('the nearer surface hides the farther one', () => {
  // a bright plate in front of a head whose own front is turned away from the light
  const nose = boxes([[-60, -50, 0], [60, 50, 200]], [[-10, 50, 80], [10, 70, 120]]);
  const bare = frontPicture(boxes([[-60, -50, 0], [60, 50, 200]]), turnOf(upright), 0, 402), with_ = frontPicture(nose, turnOf(upright), 0, 402);
  const red = ({width, pixels}: FrontPicture, x: number, y: number): number => pixels[4 * (y * width + x)]!;
  assert.equal(red(bare, 30, 200), red(with_, 30, 200));
  let differs = 0;
  for (let y = 0; y < 402; ++y) for (let x = 0; x < bare.width; ++x) differs += red(bare, x, y) !== red(with_, x, y) ? 1 : 0;
  assert.ok(differs > 0 && differs <= 42 * 82, String(differs));
  const behind = frontPicture(nose, turnOf({...upright, yaw: 180}), 0, 402), back = frontPicture(boxes([[-60, -50, 0], [60, 50, 200]]), turnOf({...upright, yaw: 180}), 0, 402);
  assert.deepEqual(behind.pixels, back.pixels);  // from the back the nose is hidden
});
