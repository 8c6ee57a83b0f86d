import assert from 'node:assert/strict';
import {test} from 'node:test';
import {FormedFault, readFormed} from '../src/read/formed';

// A sheet of two triangles, as the worker writes it.
function made(change: (gltf: any) => void = () => {}): ArrayBuffer {
  const views: object[] = [], accessors: object[] = [], parts: Uint8Array[] = [];
  let at = 0;
  const add = (bytes: Uint8Array): number => {
    views.push({buffer: 0, byteOffset: at, byteLength: bytes.length});
    const padded = new Uint8Array(Math.ceil(bytes.length / 4) * 4);
    padded.set(bytes);
    parts.push(padded);
    at += padded.length;
    return views.length - 1;
  };
  const accessor = (values: Float32Array | Uint32Array, size: number): number => {
    accessors.push({bufferView: add(new Uint8Array(values.buffer)), componentType: values instanceof Float32Array ? 5126 : 5125,
                    count: values.length / size, type: ['', 'SCALAR', 'VEC2', 'VEC3'][size]});
    return accessors.length - 1;
  };
  const floats = (size: number, ...values: number[]): number => accessor(Float32Array.from(values), size);
  const attributes = {
    POSITION: floats(3, 0, 0, 0, 10, 0, 0, 10, 10, 5, 0, 10, 5), NORMAL: floats(3, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1),
    TEXCOORD_0: floats(2, 0, 1, 1, 1, 1, 0, 0, 0), _SHEET: floats(2, -5, -5, 5, -5, 5, 5, -5, 5), _PATTERN: floats(2, 0, 0, 1, 0, 1, 1, 0, 0),
    _THICKNESS: floats(1, 1, 0.9, 0.8, 0.7), _TEMPERATURE: floats(1, 140, 141, 142, 143), _CONTACT: floats(1, 1, 1, 0, 3),
    _SHAPE: floats(1, 1, 1.1, 1.2, -1), _AREA: floats(1, 1, 1.3, 1.4, -1), _CHART: floats(1, 1, 1, 1, 0), _GAP: floats(1, 0, 0, 2.5, 9),
  };
  const indices = accessor(Uint32Array.from([0, 1, 2, 0, 2, 3]), 1);
  // The second variant comes first, so that names decide and not the order.
  const images = [add(Uint8Array.of(2, 2, 2)), add(Uint8Array.of(1, 1, 1, 1, 1))].map((bufferView) => ({bufferView, mimeType: 'image/png'}));
  const gltf = {
    asset: {version: '2.0'}, accessors, bufferViews: views, buffers: [{byteLength: at}], images,
    textures: [{source: 0}, {source: 1}], materials: [0, 1].map((index) => ({pbrMetallicRoughness: {baseColorTexture: {index}}})),
    extensions: {KHR_materials_variants: {variants: [{name: 'printed as drawn'}, {name: 'pre-distorted'}]}},
    meshes: [{primitives: [{attributes, indices, extensions: {KHR_materials_variants: {
      mappings: [{material: 0, variants: [0]}, {material: 1, variants: [1]}]}}}]}],
  };
  change(gltf);
  const text = new TextEncoder().encode(JSON.stringify(gltf)), jsonBytes = Math.ceil(text.length / 4) * 4;
  const file = new Uint8Array(28 + jsonBytes + at).fill(32), view = new DataView(file.buffer);
  [0x46546c67, 2, file.length, jsonBytes, 0x4e4f534a].forEach((value, i) => view.setUint32(4 * i, value, true));
  file.set(text, 20);
  view.setUint32(20 + jsonBytes, at, true);
  view.setUint32(24 + jsonBytes, 0x004e4942, true);
  let put = 28 + jsonBytes;
  for (const part of parts) {
    file.set(part, put);
    put += part.length;
  }
  return file.buffer;
}
const refuses = (change: (gltf: any) => void, what: RegExp): void =>
  void assert.throws(() => readFormed(made(change)), (error) => error instanceof FormedFault && what.test(error.message));

test('every number and both pictures are read', async () => {
  const formed = readFormed(made());
  assert.deepEqual([...formed.positions.slice(6)], [10, 10, 5, 0, 10, 5]);
  assert.deepEqual([...formed.sheet], [-5, -5, 5, -5, 5, 5, -5, 5]);
  assert.deepEqual([...formed.indices], [0, 1, 2, 0, 2, 3]);
  assert.deepEqual([...formed.contact], [1, 1, 0, 3]);
  assert.deepEqual([...formed.chart], [1, 1, 1, 0]);
  assert.deepEqual([...formed.maps.keys()].sort(), ['area', 'gap', 'shape', 'temperature', 'thickness']);
  assert.deepEqual([...formed.maps.get('temperature')!], [140, 141, 142, 143]);
  assert.deepEqual([...formed.maps.get('area')!].map((value) => value.toFixed(1)), ['1.0', '1.3', '1.4', '-1.0']);
  assert.deepEqual([...new Uint8Array(await formed.printed.arrayBuffer())], [1, 1, 1, 1, 1]);
  assert.deepEqual([...new Uint8Array(await formed.drawn.arrayBuffer())], [2, 2, 2]);
});

test('a file that is cut off anywhere is refused with a sentence', () => {
  const whole = made();
  for (let length = 0; length < whole.byteLength; ++length)
    assert.throws(() => readFormed(whole.slice(0, length)), (error) => error instanceof FormedFault && error.message.startsWith('formed.glb: '));
});

test('what does not fit together is refused by name', () => {
  refuses((gltf) => delete gltf.meshes[0].primitives[0].attributes._CHART, /_CHART/);
  refuses((gltf) => { gltf.accessors[5].count = 3; }, /_THICKNESS/);
  refuses((gltf) => { gltf.accessors[0].count = 1e9; }, /too short/);
  refuses((gltf) => { gltf.bufferViews[0].byteOffset = -4; }, /too short/);
  refuses((gltf) => { gltf.bufferViews[2].byteLength = 1e12; gltf.accessors[2].count = 1e11; }, /too short/);
  refuses((gltf) => { gltf.accessors[1].componentType = 5123; }, /NORMAL/);
  refuses((gltf) => { gltf.extensions.KHR_materials_variants.variants[1].name = 'other'; }, /pre-distorted/);
  refuses((gltf) => { gltf.accessors.at(-1).byteOffset = 8; gltf.accessors.at(-1).count = 4; }, /triangle/);
  refuses((gltf) => { gltf.accessors.at(-1).bufferView = 0; }, /triangle/);
});
