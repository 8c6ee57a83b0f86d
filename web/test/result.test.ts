import assert from 'node:assert/strict';
import {test} from 'node:test';
import {begun, centreLines, coilsOf, encloses, initialResult, isMoved, laid, lying, move, patternOf, placed, previewPlace, queryOf, redo, resultOf,
        rowOf, sorted, toChart, toDrawing, undo, wantedOf, withPoints, type Flat, type PrintReport, type Row} from '../src/state/result';
import {coarse, picturePlace} from '../src/read/formed';

test('a link restores the view, and the first view needs none', () => {
  assert.equal(queryOf(initialResult), '');
  assert.deepEqual(resultOf(''), initialResult);
  const view = {...initialResult, tab: 'sheet', map: 'area', cut: 0.38, isolines: false, coil: 'a & b', camera: '25_15_1_0_0_60'} as const;
  assert.deepEqual(resultOf(queryOf(view)), view);
  const side = {...initialResult, mode: 'side'} as const;
  assert.deepEqual(resultOf(queryOf(side)), side);
  assert.deepEqual(resultOf('map=nothing&cut=900&mode=x'), initialResult);
});

const side = (round: number, onHead = true): object => ({
  on_head: onHead, centre_mm: [0, 0, 50], diameter_mm: 40, circularity: round, shape_error: 0.5, area_mm2: 1256, area_error: -0.01,
  worst_stretch: 1.2, inductance_nh: 80});
const report = {
  coils: [['coil-10', 0.02], ['coil-2', 0.05], ['coil-1', 0.9, false]].map(([id, round, onHead]) =>
    ({id, drawn_diameter_mm: 40, with: side(round as number, onHead as boolean), without: side(0.3)})),
  pairs: [{coils: ['coil-10', 'coil-2'], with: {k: -0.04}}, {coils: ['coil-10', 'coil-1'], with: {k: 0.01}}, {coils: ['coil-1', 'coil-2'], with: null}],
} as unknown as PrintReport;

test('the worst coil comes first, those beside the head last', () => {
  const coils = coilsOf(report), ids = (by: Parameters<typeof sorted>[1], down: boolean): string[] => sorted(coils, by, down).map(({id}) => id);
  assert.deepEqual(ids('round', true), ['coil-2', 'coil-10', 'coil-1']);
  assert.deepEqual(ids('round', false), ['coil-10', 'coil-2', 'coil-1']);
  assert.deepEqual(ids('id', false), ['coil-2', 'coil-10', 'coil-1']);
});

test('a coil has its neighbours, the strongest coupling first', () => {
  const coil = coilsOf(report)[0];
  assert.deepEqual(coil.neighbours, [{id: 'coil-2', k: -0.04}, {id: 'coil-1', k: 0.01}]);
  assert.equal(coil.coupling, 0.04);
  assert.equal(coil.roundWithout, 0.3);
});

const svg = `<g id="pattern"><g id="a &amp; b"><path fill="#000" d="M9 9L8 8Z"/>
  <path class="centreline" fill="none" d="M10 0C10 5.52 5.52 10 0 10C-5.52 10 -10 5.52 -10 0L0 -10Z"/></g><g id="other"><path d="M0 0"/></g></g>`;

test('centre lines are read from the print with t up, and from a mirrored one turned back', () => {
  const [line] = centreLines(svg, false).get('a & b')!;
  assert.deepEqual([line[0], line.at(-1)], [[10, -0], [10, -0]]);
  assert.ok(line.some(([s, t]) => Math.abs(Math.hypot(s, t) - 10) < 0.01 && s > 5 && t < -5), 'the curve bulges like a circle');
  assert.deepEqual(centreLines(svg, true).get('a & b')![0][0], [-10, -0]);
  assert.equal(centreLines(svg, false).size, 1);
});

test('a place is inside of a coil if its centre line goes around it', () => {
  const lines = centreLines(svg, false).get('a & b')!;
  assert.ok(encloses(lines, [0, 0]));
  assert.ok(encloses(lines, [6, -6]), 'inside of the curve');
  assert.ok(!encloses(lines, [6, 6]), 'outside of the straight side');
});

test('moves can be undone and redone, until the drawing is moved again', () => {
  const job = {settings: {pattern: {offset_mm: [1, 2], rotate_deg: 10, scale: 1.1}}};
  let moves = begun(job);
  assert.deepEqual(placed(moves), {x: 1, y: 2, turn: 10, scale: 1.1});
  moves = move(moves, {...placed(moves), x: 5});
  moves = move(moves, {...placed(moves), x: 5});
  assert.equal(moves.steps.length, 2, 'the same place again is no move');
  assert.ok(isMoved(moves));
  moves = undo(undo(moves));
  assert.ok(!isMoved(moves));
  assert.equal(placed(redo(moves)).x, 5);
  moves = move(moves, {...placed(moves), turn: 90});
  assert.equal(placed(redo(moves)).turn, 90);
});

test('the preview shows each point of the drawing where the new placement puts it', () => {
  const from = {x: 3, y: -2, turn: 30, scale: 1.2}, to = {x: -5, y: 8, turn: -40, scale: 0.9}, top = [7, -9] as const;
  const onChart = (p: typeof from, [u, v]: readonly number[]): [number, number] => {
    const c = Math.cos(p.turn * Math.PI / 180) * p.scale, s = Math.sin(p.turn * Math.PI / 180) * p.scale;
    return [c * u - s * v + p.x, s * u + c * v + p.y];
  };
  const size = [300, -200] as const, origin = [0.5, 0.5] as const;
  const m = previewPlace(from, to, top, size, origin);
  // A point of the drawing lies on the chart where `to` puts it. There, the vertex has the pattern coordinates that the
  // job gave it; the picture must be read where the job's drawing has that point.
  const point = [12, -7], chart = onChart(to, point);
  const angle = -from.turn * Math.PI / 180, x = (chart[0] - from.x) / from.scale, y = (chart[1] - from.y) / from.scale;
  const vertex = [Math.cos(angle) * x - Math.sin(angle) * y, Math.sin(angle) * x + Math.cos(angle) * y];
  const read = [0, 3].map((r) => m[r] * vertex[0] + m[r + 1] * vertex[1] + m[r + 2]);
  const flat = onChart(from, point), expected = [(flat[0] + top[0]) / size[0] + origin[0], (flat[1] + top[1]) / size[1] + origin[1]];
  read.forEach((value, k) => assert.ok(Math.abs(value - expected[k]) < 1e-12, `${read} instead of ${expected}`));
});

// A sheet of 5 x 4 vertices over 80 x 60 mm.
function grid(): {sheet: Float32Array; texture: Float32Array; indices: Uint32Array} {
  const sheet: number[] = [], texture: number[] = [], indices: number[] = [];
  for (let j = 0; j < 4; ++j)
    for (let i = 0; i < 5; ++i) {
      sheet.push(-40 + 20 * i, -30 + 20 * j);
      texture.push((-40 + 20 * i) / 100 + 0.5, 0.5 - (-30 + 20 * j) / 80);
    }
  for (let j = 0; j < 3; ++j)
    for (let i = 0; i < 4; ++i) indices.push(5 * j + i, 5 * j + i + 1, 5 * j + i + 6, 5 * j + i, 5 * j + i + 6, 5 * j + i + 5);
  return {sheet: Float32Array.from(sheet), texture: Float32Array.from(texture), indices: Uint32Array.from(indices)};
}

test('where the sheet lies on the pictures is found from its corners', () => {
  const [size, origin] = picturePlace(grid());
  [[size[0], 100], [size[1], -80], [origin[0], 0.5], [origin[1], 0.5]].forEach(([value, expected]) =>
    assert.ok(Math.abs(value - expected) < 1e-4, `${value}`));
});

test('the coarse sheet covers the same rectangle with about a quarter of the triangles', () => {
  const {sheet, indices} = grid(), few = coarse({sheet, indices})!;
  let area = 0;
  for (let i = 0; i < few.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => [sheet[2 * few[i + k]], sheet[2 * few[i + k] + 1]]);
    area += Math.abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
  }
  assert.equal(area, 80 * 60);
  assert.equal(few.length / 3, 8);
  assert.equal(coarse({sheet, indices: indices.slice(3)}), null, 'not a grid');
});
