import assert from 'node:assert/strict';
import {test} from 'node:test';
import {ReadError} from '../../src/read/bytes';
import {factsOf} from '../../src/read/facts';
import {readScan} from '../../src/read/scan';
import {all, corners, glb, joined, obj, off, ply, stlAscii, stlBinary, utf8} from './files';

const faultOf = (bytes: Uint8Array, name = 'x'): ReadError => {
  try {
    readScan(bytes, name);
  } catch (error) {
    assert.ok(error instanceof ReadError, `not a ReadError: ${String(error)}`);
    return error;
  }
  throw new Error('the file was read');
};

for (const [name, bytes] of all())
  test(`reads the box of ${name}`, () => {
    const mesh = readScan(bytes, name), facts = factsOf(mesh);
    assert.equal(facts.triangles, 12);
    facts.low.forEach((value, k) => assert.ok(Math.abs(value - [-50, -75, 0][k]!) < 1e-3, `${facts.low}`));
    facts.high.forEach((value, k) => assert.ok(Math.abs(value - [50, 75, 200][k]!) < 1e-3, `${facts.high}`));
    assert.equal(facts.insideOut, false);
    assert.equal(facts.zFront, name.endsWith('.glb'));  // of these formats, only glTF defines a front
  });

test('knows the formats by their bytes, whatever the name says', () => {
  const formats = all().map(([, bytes]) => readScan(bytes, 'scan.bin').format);
  assert.deepEqual(formats, ['STL (binary)', 'STL (ASCII)', 'OBJ', 'OFF', 'PLY (ASCII)', 'PLY (little-endian)', 'PLY (big-endian)', 'GLB']);
});

test('a binary STL may begin with the word solid', () => {
  const bytes = stlBinary();
  bytes.set(utf8('solid by a scanner\nfacet'));
  assert.equal(readScan(bytes, 'a.stl').format, 'STL (binary)');
});

test('reads ASCII numbers like the language does', () => {
  const values = ['1', '-1.5', '+.25', '1e2', '1.25E-3', '0.1', '123456.789', '3.14159265358979312'];
  const bytes = utf8(values.map((value) => `v ${value} 0 0\n`).join('') + 'f 1 2 3\n');
  const {positions} = readScan(bytes, 'a.obj');
  values.forEach((value, i) => assert.equal(positions[3 * i], Math.fround(Number(value))));
});

// A cut file must be refused, unless only text after the last number of the geometry is cut. An OBJ does not say how long it
// is: cut after a row, it is read with fewer triangles.
const tails: Record<string, number> = {'ascii.stl': ' a head\n'.length, 'head.off': ' 255 0 0\n'.length, 'ascii.ply': '1\n'.length};
for (const [name, bytes] of all())
  test(`every truncation of ${name} is refused with a typed error`, () => {
    const read: number[] = [];
    for (let length = 0; length < bytes.length; ++length) {
      try {
        const mesh = readScan(bytes.slice(0, length), name);
        read.push(length);
        assert.ok(mesh.indices.length <= 36);
      } catch (error) {
        assert.ok(error instanceof ReadError, `${length} bytes: ${String(error)}`);
      }
    }
    if (name === 'head.obj') assert.ok(read.length < bytes.length / 2);
    else assert.ok(read.every((length) => length >= bytes.length - (tails[name] ?? 0)), `read with ${read} of ${bytes.length} bytes`);
  });

for (const [name, bytes] of all())
  test(`changed bytes of ${name} never break the reader`, () => {
    let seed = 12345;
    const random = (below: number): number => (seed = (Math.imul(seed, 1103515245) + 12345) >>> 0) % below;
    for (let round = 0; round < 400; ++round) {
      const changed = bytes.slice();
      for (let k = 0; k <= round % 4; ++k) changed[random(changed.length)] = random(256);
      try {
        const {positions, indices} = readScan(changed, name);
        assert.ok(indices.every((index) => index < positions.length / 3));
        assert.ok(positions.every((value) => Number.isFinite(value)));
      } catch (error) {
        assert.ok(error instanceof ReadError, `round ${round}: ${(error as Error).stack}`);
      }
    }
  });

test('says where a number cannot be read', () => {
  const error = faultOf(utf8('v 0 0 0\nv 1 x 0\n'), 'a.obj');
  assert.equal(error.fault, 'number');
  assert.deepEqual(error.where, {unit: 'line', at: 2});
  assert.equal(error.detail, 'x');
});

test('refuses corners that do not exist', () => {
  assert.equal(faultOf(utf8('v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n')).fault, 'index');
  assert.equal(faultOf(utf8('v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n')).fault, 'index');
  assert.equal(faultOf(utf8('OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n')).fault, 'index');
  assert.equal(faultOf(glb((root) => { root['accessors'][0].count = 7; })).fault, 'index');
});

test('refuses a file that promises more than it has before it takes memory for it', () => {
  assert.equal(faultOf(utf8('OFF\n2000000000 1 0\n0 0 0\n')).fault, 'header');
  assert.equal(faultOf(joined(ply('ascii').slice(0, 40), utf8('\nelement vertex 4000000000\nproperty float x\nend_header\n'))).fault, 'ends');
  assert.equal(faultOf(glb((root) => { root['accessors'][0].count = 1e9; })).fault, 'ends');
});

test('refuses coordinates that cannot be', () => {
  assert.equal(faultOf(utf8('v 1e30 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n')).fault, 'far');
  assert.equal(faultOf(stlBinary(corners.map(([x, y]) => [x, y, NaN]))).fault, 'far');
});

test('names what a GLB needs that cannot be shown', () => {
  const draco = faultOf(glb((root) => { root['extensionsRequired'] = ['KHR_draco_mesh_compression']; }));
  assert.equal(draco.fault, 'compressed');
  assert.equal(draco.detail, 'KHR_draco_mesh_compression');
  assert.equal(faultOf(glb((root) => { root['buffers'][0].uri = 'a.bin'; })).fault, 'outside');
  assert.equal(faultOf(glb((root) => { root['accessors'][0].sparse = {}; })).fault, 'sparse');
  assert.equal(faultOf(glb((root) => { root['nodes'][1].children = [0]; })).fault, 'header');  // a cycle
});

test('points without triangles are no scan', () => {
  assert.equal(faultOf(utf8('v 0 0 0\nv 1 0 0\n'), 'a.obj').fault, 'no_triangles');
  assert.equal(faultOf(stlBinary([], [])).fault, 'no_triangles');
});

test('tells other files by their bytes', () => {
  assert.equal(faultOf(new Uint8Array()).fault, 'empty');
  assert.equal(faultOf(utf8('PK\x03\x04 whatever')).detail, 'ZIP');
  assert.equal(faultOf(joined(new Uint8Array(128), utf8('DICM'), new Uint8Array(20))).detail, 'DICOM');
  assert.equal(faultOf(utf8('a letter to a friend'), 'letter.txt').fault, 'unknown');
});

test('tells a file that was copied as text', () => {
  const bytes = stlBinary();
  const copied = utf8(new TextDecoder('utf-8', {fatal: false}).decode(bytes));
  assert.equal(faultOf(copied, 'a.stl').fault, 'damaged');
  const marks = joined(utf8('glTF'), ...Array.from({length: 40}, () => new Uint8Array([0xEF, 0xBF, 0xBD, 1])));
  assert.equal(faultOf(marks).fault, 'damaged');
  const feeds = joined(utf8('glTF'), ...Array.from({length: 40}, () => new Uint8Array([0, 0, 13, 10])));
  assert.equal(faultOf(feeds).fault, 'damaged');
});

test('reads strips of a PLY file', () => {
  const text = 'ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n' +
    'element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n4 0 1 2 3\n';
  assert.deepEqual([...readScan(utf8(text), 'a.ply').indices], [0, 1, 2, 2, 1, 3]);
});

test('tells progress of long files', () => {
  const text = Array.from({length: 140_000}, (_, i) => `v ${i} 0 0\n`).join('') + 'f 1 2 3\n';
  const told: number[] = [];
  readScan(utf8(text), 'a.obj', (share) => told.push(share));
  assert.ok(told.length >= 3 && told.every((share, i) => share >= (told[i - 1] ?? 0) && share <= 1), `${told}`);
});

test('the test files are of the formats that they claim', () => {
  for (const bytes of [stlAscii(), obj(), off()]) assert.ok(bytes.every((byte) => byte < 128));
});
