import assert from 'node:assert/strict';
import {test} from 'node:test';
import {colourAt, css, marksOf, rangeOf, roundStep, type HeatName, type Rgb} from '../src/scene/colour';

const lightness = ([r, g, b]: Rgb): number => {
  const linear = (v: number): number => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  const y = 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  return y > 0.008856 ? 116 * Math.cbrt(y) - 16 : 903.3 * y;
};
const settings = {thickness: 1, thinLimit: 0.3, distortionLimit: 1.1, window: [121, 160] as const};

test('every map goes from dark to bright or back without a turn, so that it is read in gray too', () => {
  for (const [map, way] of [['thickness', 1], ['temperature', 1], ['shape', -1], ['area', -1]] as [HeatName, number][])
    for (let i = 0; i < 100; ++i)
      assert.ok(way * (lightness(colourAt(map, (i + 1) / 100)) - lightness(colourAt(map, i / 100))) > 0, `${map} at ${i} %`);
});

test('undistorted is almost white, and outside of the range the colour stays', () => {
  assert.equal(css(colourAt('area', 0)), 'rgb(247 247 247)');
  assert.deepEqual(colourAt('area', -1), colourAt('area', 0));
  assert.deepEqual(colourAt('thickness', 7), colourAt('thickness', 1));
});

test('the range comes from the settings alone', () => {
  assert.deepEqual([rangeOf('thickness', settings).low, rangeOf('thickness', settings).high], [0.3, 1]);
  assert.deepEqual([rangeOf('temperature', settings).low, rangeOf('temperature', settings).high], [121, 160]);
  assert.equal(rangeOf('shape', settings).limit, 1.1);
});

test('marks lie at round numbers within the range', () => {
  assert.deepEqual(marksOf({low: 1, high: 2, step: 0.2}), [1, 1.2, 1.4, 1.6, 1.8, 2]);
  assert.deepEqual(marksOf(rangeOf('thickness', settings)), [0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1]);
  assert.equal(roundStep(0.07), 0.1);
  assert.equal(roundStep(0.0201), 0.05);
});
