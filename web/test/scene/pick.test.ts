import assert from 'node:assert/strict';
import {test} from 'node:test';
import type {Formed} from '../../src/read/formed';
import {having, nearest} from '../../src/scene/pick';

// A sheet of 5 x 5 vertices 10 mm apart at the height 50; the chart is without its rim. The drawing is turned by 90 degrees.
function flat(): Formed {
  const positions: number[] = [], sheet: number[] = [], pattern: number[] = [], chart: number[] = [], indices: number[] = [];
  for (let j = 0; j < 5; ++j)
    for (let i = 0; i < 5; ++i) {
      const s = 10 * i - 20, t = 10 * j - 20, on = Math.max(Math.abs(s), Math.abs(t)) <= 10;
      positions.push(s, t, 50);
      sheet.push(s, t);
      pattern.push(on ? t : 0, on ? -s : 0);
      chart.push(on ? 1 : 0);
      if (i < 4 && j < 4) indices.push(5 * j + i, 5 * j + i + 1, 5 * j + i + 6, 5 * j + i, 5 * j + i + 6, 5 * j + i + 5);
    }
  const zeros = new Float32Array(25), f = (values: number[]): Float32Array => Float32Array.from(values);
  return {positions: f(positions), sheet: f(sheet), pattern: f(pattern), chart: f(chart), indices: Uint32Array.from(indices), normals: f(chart.flatMap(() => [0, 0, 1])),
          texture: zeros, contact: zeros, maps: new Map([['gap', zeros], ['position', f(chart.map((on) => on ? 0.25 : -1))]]), printed: new Blob(), drawn: new Blob()};
}
const near = (a: readonly number[] | null | undefined, b: readonly number[]): void =>
  assert.ok(a && a.every((value, k) => Math.abs(value - b[k]!) < 1e-3), `${a} instead of ${b}`);

test('the nearest point lies between the vertices, and on the chart where that is asked for', () => {
  near(nearest(flat(), [3, 4, 51]).point, [3, 4, 50]);
  near(nearest(flat(), [3, 4, 51]).pattern, [4, -3]);
  near(nearest(flat(), [18, 0, 50]).point, [18, 0, 50]);
  near(nearest(flat(), [18, 0, 50], true).point, [10, 0, 50]);
});

test('a map is read where all corners have a value', () => {
  const inside = nearest(flat(), [3, 4, 50]), rim = nearest(flat(), [18, 0, 50]);
  near([inside.values.get('position')!, inside.values.get('gap')!], [0.25, 0]);
  assert.deepEqual([rim.values.get('position'), rim.values.get('gap')], [null, 0]);
});

test('a point of the drawing and a point of the flat sheet are found on the part', () => {
  near(having(flat(), 'pattern', [4, -3])?.point, [3, 4, 50]);
  near(having(flat(), 'sheet', [-7, 2])?.pattern, [2, 7]);
  assert.equal(having(flat(), 'pattern', [40, 0]), null);
});
