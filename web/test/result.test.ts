import assert from 'node:assert/strict';
import {test} from 'node:test';
import {initialMoves, centreLines, compared, coilsOf, encloses, initialResult, isMoved, laid, lying, move, patternOf, placed, previewPlace, queryOf, redo, resultOf,
        rowOf, sorted, toChart, toDrawing, undo, wantedOf, withPoints, type Flat, type PrintReport, type Row} from '../src/state/result';
import {coarse, picturePlace} from '../src/read/formed';

test('a link restores the view, and the first view needs none', () => {
  assert.equal(queryOf(initialResult), '');
  assert.deepEqual(resultOf(''), initialResult);
  const view = {...initialResult, tab: 'sheet', map: 'area', cut: 0.38, isolines: false, coil: 'a & b', other: 'c',
                hidden: ['print-bridges', 'print-reverse'], camera: '25_15_1_0_0_60'} as const;
  assert.deepEqual(resultOf(queryOf(view)), view);
  const side = {...initialResult, mode: 'side'} as const;
  assert.deepEqual(resultOf(queryOf(side)), side);
  assert.deepEqual(resultOf('cut=900&mode=x&and=b&hide=x_%20'), initialResult);
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

test('the print is compared with the drawing over the same coils', () => {
  assert.deepEqual(compared(report), {count: 2, same: true, round: [0.035, 0.3], area: [0.01, 0.01]});
  // printed as drawn, only one of them would lie on the head; a square has no circularity
  const coils = (report.coils ?? []).map((coil, i) => i === 1 ? {...coil, without: side(0.7, false)} : coil) as PrintReport['coils'];
  assert.deepEqual(compared({...report, coils: coils!}), {count: 1, same: false, round: [0.02, 0.3], area: [0.01, 0.01]});
  const square = {...report, coils: coils!.map((coil) => ({...coil, with: {...coil.with!, circularity: null}}))} as PrintReport;
  assert.equal(compared(square)!.round, null);
  assert.equal(compared({...report, coils: coils!.map((coil) => ({...coil, without: null}))}), null);
});

test('a coil has its neighbours, the strongest coupling first', () => {
  const coil = coilsOf(report)[0];
  assert.deepEqual(coil.neighbours, [{id: 'coil-2', k: -0.04}, {id: 'coil-1', k: 0.01}]);
  assert.equal(coil.coupling, 0.04);
  assert.equal(coil.roundWithout, 0.3);
});

const svg = `<g id="pattern"><g id="a &amp; b"><path fill="#000" d="M9 9L8 8Z"/>
  <path class="centreline" fill="none" d="M10 0C10 5.52 5.52 10 0 10C-5.52 10 -10 5.52 -10 0L0 -10Z"/></g><g id="other"><path d="M0 0"/></g></g>`;

test('centre lines are read from the print with t up', () => {
  const [line] = centreLines(svg).get('a & b')!;
  assert.deepEqual([line[0], line.at(-1)], [[10, -0], [10, -0]]);
  assert.ok(line.some(([s, t]) => Math.abs(Math.hypot(s, t) - 10) < 0.01 && s > 5 && t < -5), 'the curve bulges like a circle');
  assert.equal(centreLines(svg).size, 1);
});

test('a place is inside of a coil if its centre line goes around it', () => {
  const lines = centreLines(svg).get('a & b')!;
  assert.ok(encloses(lines, [0, 0]));
  assert.ok(encloses(lines, [6, -6]), 'inside of the curve');
  assert.ok(!encloses(lines, [6, 6]), 'outside of the straight side');
});

test('moves can be undone and redone, until the drawing is moved again', () => {
  const job = {settings: {pattern: {offset_mm: [1, 2], rotate_deg: 10, scale: 1.1}}};
  let moves = initialMoves(job);
  assert.deepEqual(placed(moves), {x: 1, y: 2, turn: 10, scale: 1.1, points: []});
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

test('pairs are moves too', () => {
  const row: Row = [1, 2, 3, 4, 5];
  let moves = initialMoves({settings: {pattern: {points: [row]}}});
  moves = move(moves, {...placed(moves), points: [[1, 2, 3, 4, 5]]});
  assert.ok(!isMoved(moves), 'the same pairs again are no move');
  moves = move(moves, {...placed(moves), points: []});
  assert.ok(isMoved(moves));
  assert.deepEqual(patternOf(placed(moves)), {offset_mm: [0, 0], rotate_deg: 0, scale: 1, points: []});
  assert.deepEqual(placed(undo(moves)).points, [row]);
});

// A wanted placement with these points of the drawing; the points of the mold do not matter here.
const plain = wantedOf({settings: {}});
const by = (...drawn: Flat[]): Row[] => drawn.map(([u, v]) => [u, v, 0, 0, 0]);
const near = (a: readonly number[], b: readonly number[], within = 1e-9): void =>
  a.forEach((value, k) => assert.ok(Math.abs(value - b[k]!) < within, `${a} instead of ${b}`));

test('without points a drawing lies as the settings say, and one point shifts it there', () => {
  assert.deepEqual(laid({...plain, x: 3, turn: 20}, []), {x: 3, y: 0, turn: 20, scale: 1});
  const lies = laid({...plain, turn: 90, scale: 2, points: by([10, 0])}, [[5, 6]])!;
  near([lies.turn, lies.scale], [90, 2]);
  near(toChart(lies, [10, 0]), [5, 6]);
  near(toChart(lies, [11, 0]), [5, 8]);
});

test('of two points the first is met, and the other one gives the direction; the size stays', () => {
  const lies = laid({...plain, points: by([1, 1], [11, 1])}, [[0, 0], [0, 99]])!;
  near([lies.turn, lies.scale], [90, 1]);
  near(toChart(lies, [1, 1]), [0, 0]);
  near(toChart(lies, [11, 1]), [0, 10]);
});

test('three points are met by least squares, and offset and rotation come on top', () => {
  const truth = {x: 5, y: -7, turn: -150, scale: 1.3}, drawn: Flat[] = [[0, 0], [30, 5], [-10, 40], [12, -25]];
  const targets = drawn.map((point) => toChart(truth, point)), lies = laid({...plain, scale: 1.3, points: by(...drawn)}, targets)!;
  near([lies.x, lies.y, lies.turn, lies.scale], [5, -7, -150, 1.3]);
  // what moves away from a point moves towards another: the middle is met
  const moved = laid({...plain, scale: 1.3, x: 2, turn: 10, points: by(...drawn)}, targets)!, middle: Flat = [8, 5];
  near([moved.turn], [-140]);
  near(toChart(moved, middle), [toChart(truth, middle)[0] + 2, toChart(truth, middle)[1]]);
});

test('points at one place give no direction', () => {
  assert.equal(laid({...plain, points: by([1, 1], [1, 1])}, [[0, 0], [5, 5]]), null);
  assert.equal(laid({...plain, points: by([1, 1], [9, 1])}, [[5, 5], [5, 5]]), null);
});

test('other pairs alone say where the drawing lies; the last one that goes leaves it where it is', () => {
  const lies = {x: 12.345, y: -3, turn: 370, scale: 1.5}, now = {...plain, x: 8, y: 8, turn: 30, scale: 1.5}, rows = by([1, 2], [3, 4]);
  assert.deepEqual(withPoints(now, rows, lies), {x: 0, y: 0, turn: 0, scale: 1.5, points: rows});
  assert.deepEqual(withPoints(now, rows.slice(1), lies), {x: 0, y: 0, turn: 10, scale: 1.5, points: rows.slice(1)});
  assert.deepEqual(withPoints(now, [], lies), {x: 12.35, y: -3, turn: 10, scale: 1.5, points: []});
  assert.deepEqual(withPoints(now, rows, null), {...now, points: rows}, 'nobody knows where it lies');
});

test('a row has hundredths of a millimetre, and a point of the drawing is found from the chart', () => {
  assert.deepEqual(rowOf([1.23456, -0.001], [-2.005, 3, 4.999]), [1.23, 0, -2, 3, 5]);
  const lies = {x: 3, y: 4, turn: 33, scale: 0.7};
  near(toDrawing(lies, toChart(lies, [20, -30])), [20, -30]);
});

test('where points have laid a drawing is found from the formed sheet', () => {
  const truth = {x: 9, y: -4, turn: 25, scale: 0.8}, top: Flat = [2, -13];
  const drawn: Flat[] = [[0, 0], [40, 3], [-20, 35], [-35, -30], [25, -28]], sheet = drawn.map((p): Flat => toChart({...truth, x: truth.x + top[0], y: truth.y + top[1]}, p));
  const lies = lying({drawn, sheet}, toDrawing(truth, [0, 0]), 0.8)!;
  near([lies.x, lies.y, lies.turn, lies.scale], [9, -4, 25, 0.8]);
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
