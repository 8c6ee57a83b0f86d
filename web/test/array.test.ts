import assert from 'node:assert/strict';
import {test} from 'node:test';
import {conducts, couplingsOf, farthestFirst, fillOf, gapsOf, layersOf, stepped, strongest, tintOf, withLayer, type Circuits} from '../src/state/array';
import {inkOf, marksOnly, pageOf, wholeLines} from '../src/state/ink';
import {encloses, type Line} from '../src/state/result';

const files = (...names: string[]): {name: never}[] => names.map((name) => ({name: name as never}));
const sixFiles = files('print-reverse-bridges.svg', 'print-reverse-dielectric.svg', 'print-reverse.svg', 'print-bridges.svg', 'print-dielectric.svg', 'print.svg', 'print.pdf');

test('layers come in the order of printing, each with its face', () => {
  assert.deepEqual(layersOf(sixFiles, 'inner').map(({name, number, step, face, reverse}) => [number, name, step, face, reverse]), [
    [1, 'print', 'conductor', 'inner', false], [2, 'print-dielectric', 'dielectric', 'inner', false], [3, 'print-bridges', 'bridges', 'inner', false],
    [4, 'print-reverse', 'conductor', 'outer', true], [5, 'print-reverse-dielectric', 'dielectric', 'outer', true],
    [6, 'print-reverse-bridges', 'bridges', 'outer', true]]);
  // two faces without bridges: the numbers have no gap
  assert.deepEqual(layersOf(files('print.svg', 'print-reverse.svg'), 'outer').map(({number, face}) => [number, face]), [[1, 'outer'], [2, 'inner']]);
});

test('a print of one layer has no list of layers', () => {
  assert.deepEqual(layersOf(files('print.svg', 'print.pdf', 'colours.svg'), 'outer'), []);
});

test('the nearest ink is painted last, whichever face is printed first', () => {
  const inner = layersOf(sixFiles, 'inner'), words = (from: 'outer' | 'inner'): string[] => farthestFirst(inner, from).map(({face, step}) => `${face} ${step}`);
  assert.deepEqual(farthestFirst(layersOf(sixFiles, 'outer'), 'outer').map(({name}) => name),
    ['print-reverse-bridges', 'print-reverse-dielectric', 'print-reverse', 'print', 'print-dielectric', 'print-bridges']);
  assert.deepEqual(words('outer'), ['inner bridges', 'inner dielectric', 'inner conductor', 'outer conductor', 'outer dielectric', 'outer bridges']);
  assert.deepEqual(words('inner'), words('outer').reverse());
  assert.notEqual(tintOf({step: 'conductor', reverse: false}).colour, tintOf({step: 'conductor', reverse: true}).colour);
});

test('resist comes after the bridges, a picture last and in its own colours', () => {
  const layers = layersOf(files('print-picture.svg', 'print-reverse-resist.svg', 'print-resist.svg', 'print-bridges.svg', 'print-dielectric.svg', 'print.svg', 'print-reverse.svg'), 'outer');
  assert.deepEqual(layers.map(({number, step, face}) => `${number} ${step} ${face}`), ['1 conductor outer', '2 dielectric outer', '3 bridges outer',
    '4 resist outer', '5 picture outer', '6 conductor inner', '7 resist inner']);
  assert.deepEqual(layers.filter(conducts).map(({name}) => name), ['print', 'print-bridges', 'print-reverse']);
  assert.equal(farthestFirst(layers, 'outer').at(-1)?.step, 'picture');
  assert.equal(fillOf({step: 'picture', reverse: false}, '#ff8800'), '#ff8800');
  assert.equal(fillOf({step: 'resist', reverse: false}, '#000000'), tintOf({step: 'resist', reverse: false}).colour);
});

test('a layer is hidden once, and shown again', () => {
  const hidden = withLayer(withLayer(withLayer([], 'print-reverse', false), 'print', false), 'print', false);
  assert.deepEqual(hidden, ['print', 'print-reverse']);
  assert.deepEqual(withLayer(hidden, 'print', true), ['print-reverse']);
});

const k = [[1, -0.01, null], [-0.01, 1, 0.04], [null, 0.04, 1]], coils = ['a', 'b', 'c'];

test('the strongest pair is found whatever its sign, and one loop has no table', () => {
  assert.deepEqual(strongest({coils, k}), [2, 1]);
  assert.deepEqual(strongest({coils, k: [[1, -0.05, 0], [-0.05, 1, 0.04], [0, 0.04, 1]]}), [1, 0]);
  assert.equal(couplingsOf({couplings: {coils: ['a'], k: [[1]]}}), null);
  assert.equal(couplingsOf({couplings: null}), null);
});

test('arrow keys lead over the diagonal and not out of the table', () => {
  assert.deepEqual(stepped([1, 0], 'ArrowRight', 3), [1, 2]);
  assert.deepEqual(stepped([1, 2], 'ArrowLeft', 3), [1, 0]);
  assert.deepEqual(stepped([0, 1], 'ArrowDown', 3), [2, 1]);
  assert.deepEqual(stepped([2, 0], 'ArrowDown', 3), null);
  assert.deepEqual(stepped([0, 1], 'ArrowLeft', 3), null, 'the diagonal is at the edge');
  assert.deepEqual(stepped([2, 1], 'End', 3), [2, 1]);
  assert.deepEqual(stepped([0, 2], 'Home', 3), [0, 1]);
  assert.equal(stepped([0, 2], 'a', 3), null);
  for (const [a, b] of [[0, 1], [1, 0], [2, 0], [1, 2]] as const)
    for (const key of ['ArrowUp', 'ArrowDown', 'ArrowLeft', 'ArrowRight', 'Home', 'End']) {
      const to = stepped([a, b], key, 3);
      assert.ok(!to || to[0] !== to[1], `${a} ${b} ${key}`);
    }
});

test('gaps come by number with their loop, face and place', () => {
  const gap = (number: number, port: boolean): Record<string, unknown> =>
    ({number, port, drawn: false, wanted_pf: 20.31, standard_pf: port ? 0 : 20, plate: null, place_mm: [1, -2, number]});
  const circuits = {coils: [{id: 'a', face: 'outer'}, {id: 'b', face: 'inner'}], electrical: {frequency_mhz: 127.74, loops: [
    {id: 'b', gaps: [gap(3, true), gap(4, false)]}, {id: 'a', gaps: [gap(1, true), gap(2, false)]}]}} as unknown as Circuits;
  const gaps = gapsOf({circuits});
  assert.deepEqual(gaps.map(({number, loop, face, port, value}) => [number, loop, face, port, value]),
    [[1, 'a', 'outer', true, 0], [2, 'a', 'outer', false, 20], [3, 'b', 'inner', true, 0], [4, 'b', 'inner', false, 20]]);
  assert.deepEqual(gaps[3]?.place, [1, -2, 4]);
  assert.deepEqual(gapsOf({circuits: {...circuits, electrical: null}}), []);
  assert.deepEqual(gapsOf({}), []);
});

test('a printed capacitor has what is printed, and its tolerance', () => {
  const printed = {number: 2, port: false, drawn: false, wanted_pf: 3.56, standard_pf: null, plate: {pf: 3.48, tolerance: 0.05}, place_mm: [1, 2, 3]};
  const circuits = {coils: [{id: 'a', face: 'outer'}], electrical: {frequency_mhz: 298.04, loops: [{id: 'a', gaps: [printed]}]}} as unknown as Circuits;
  assert.deepEqual(gapsOf({circuits}).map(({value, tolerance}) => [value, tolerance]), [[3.48, 0.05]]);
  assert.equal(gapsOf({circuits})[0]?.printed, true);
});

test('a port says how long its tail is', () => {
  const port = {number: 1, port: true, drawn: false, wanted_pf: 40, standard_pf: 39, plate: null, place_mm: [1, 2, 3]};
  const gaps = [port, {...port, number: 2, port: false}], tail = {length_mm: 84.2, ohm: 1.5, inductance_nh: 60};
  const circuits = {coils: [{id: 'a', face: 'outer', tail}, {id: 'b', face: 'outer', tail: null}],
    electrical: {frequency_mhz: 127.74, loops: [{id: 'a', gaps}, {id: 'b', gaps: [{...port, number: 3}]}]}} as unknown as Circuits;
  assert.deepEqual(gapsOf({circuits}).map((gap) => gap.tail), [84.2, 0, 0]);
});

const page = (mirrored: boolean): string => `<?xml version="1.0"?>
<svg xmlns="http://www.w3.org/2000/svg" viewBox="-130.000 -100.000 260.000 200.000">
  <g id="pattern"${mirrored ? ' transform="scale(-1 1)"' : ''}>
    <g id="marks of a coil">
      <path fill="#000000" fill-opacity="0.5" fill-rule="evenodd" d="M1 2L3 4Z"/>
      <path class="centreline" fill="none" stroke="none" data-width-mm="2" d="M9 9L8 8Z"/>
    </g>
  </g>
  <g id="marks" fill="none">
    <g id="mark-window">
      <path d="M0 0 L5 5"/>
    </g>
    <g id="mark-legend">
      <text transform="translate(1,2)">step 1 of 6</text>
    </g>
    <g id="mark-gap-numbers">
      <text transform="translate(10.5,-20.25)" font-size="2" text-anchor="middle" xml:space="preserve">17</text>
    </g>
  </g>
</svg>`;

test('ink is read without centre lines and marks, and lies as seen from above on either face', () => {
  assert.deepEqual(inkOf(page(false)).paths, [{d: 'M1 2L3 4Z', fill: '#000000', evenOdd: true, opacity: 0.5}]);
  assert.deepEqual(inkOf(page(false)).numbers, [{x: 10.5, y: -20.25, size: 2, text: '17'}]);
  // paths are mirrored by their group, numbers are not: they stand where they are read on the page
  assert.deepEqual(inkOf(page(true)).paths, inkOf(page(false)).paths);
  assert.equal(inkOf(page(true)).numbers[0]?.x, -10.5);
  assert.deepEqual(pageOf(page(true)), {box: [-130, -100, 260, 200], mirrored: true});
  assert.equal(pageOf(page(false)).mirrored, false);
});

test('the marks alone are without ink, legend and numbers', () => {
  const marks = marksOnly(page(false));
  assert.match(marks, /mark-window/);
  assert.doesNotMatch(marks, /pattern|step 1|17|evenodd/);
  assert.equal(marks.split('<g').length, marks.split('</g>').length, 'groups are closed');
});

// A circle about (x, 0) in pieces of the given degrees, every other one turned round.
const arcs = (x: number, ...pieces: [from: number, to: number][]): Line[] => pieces.map(([from, to], i) => {
  const line = Array.from({length: 9}, (_, k): [number, number] => {
    const angle = (from + (to - from) * k / 8) * Math.PI / 180;
    return [x + 30 * Math.cos(angle), 30 * Math.sin(angle)];
  });
  return i % 2 ? line.reverse() : line;
});

test('a loop that gaps and bridges interrupt is whole again, whatever the order of its pieces', () => {
  const conductor = new Map([['a', arcs(0, [200, 290], [4, 90], [94, 180], [2, 4], [178, 180], [300, 358])]]), bridge = new Map([['a', arcs(0, [180, 200])]]);
  const [line, ...more] = wholeLines([conductor, bridge]).get('a')!;
  assert.equal(more.length, 0, 'all pieces are in one line');
  for (const angle of [0, 45, 92, 135, 190, 250, 295, 330]) {
    const [c, s] = [Math.cos(angle * Math.PI / 180), Math.sin(angle * Math.PI / 180)];
    assert.ok(encloses([line!], [28 * c, 28 * s]), `${angle} degrees, inside`);
    assert.ok(!encloses([line!], [32 * c, 32 * s]), `${angle} degrees, outside`);
  }
});

test('what is closed, and what lies far apart, stays as it is', () => {
  const ring = arcs(0, [0, 360])[0]!, far = arcs(200, [0, 90])[0]!;
  ring[ring.length - 1] = [...ring[0]!];
  assert.deepEqual(wholeLines([new Map([['a', [ring, far]]])]).get('a'), [ring, far]);
});
