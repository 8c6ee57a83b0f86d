// A formed.glb of any size: a sheet of 300 mm over a dome, with rings as its texture.
import {deflateSync} from 'node:zlib';

const crcTable = Array.from({length: 256}, (_, n) => {
  let c = n;
  for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c >>> 0;
});
const crc = (bytes) => (bytes.reduce((c, byte) => crcTable[(c ^ byte) & 255] ^ (c >>> 8), 0xffffffff) ^ 0xffffffff) >>> 0;

// A PNG of size * size pixels: rings around the middle, `wide` pixels apart.
function rings(size, wide) {
  const rows = Buffer.alloc(size * (1 + size * 4));
  for (let y = 0; y < size; ++y)
    for (let x = 0; x < size; ++x) {
      const ink = Math.hypot(x - size / 2, y - size / 2) % wide < 6 ? 0 : 255;
      rows.fill(ink, y * (1 + size * 4) + 1 + x * 4, y * (1 + size * 4) + 4 + x * 4);
      rows[y * (1 + size * 4) + 4 + x * 4] = 255;
    }
  const chunk = (type, data) => {
    const body = Buffer.concat([Buffer.from(type), data]);
    const ends = Buffer.alloc(8);
    ends.writeUInt32BE(data.length);
    ends.writeUInt32BE(crc(body), 4);
    return Buffer.concat([ends.subarray(0, 4), body, ends.subarray(4)]);
  };
  const head = Buffer.alloc(13);
  head.writeUInt32BE(size);
  head.writeUInt32BE(size, 4);
  head.set([8, 6, 0, 0, 0], 8);
  return Buffer.concat([Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]), chunk('IHDR', head),
                        chunk('IDAT', deflateSync(rows, {level: 1})), chunk('IEND', Buffer.alloc(0))]);
}

// `cells` * `cells` squares of two triangles each.
export function largeSheet(cells) {
  const side = 300;
  const rows = cells + 1;
  const count = rows * rows;
  const height = (x, y) => 120 * Math.exp(-(x * x + y * y) / 6000);
  const sizes = {POSITION: 3, NORMAL: 3, TEXCOORD_0: 2, _SHEET: 2, _PATTERN: 2, _THICKNESS: 1, _CONTACT: 1, _SHAPE: 1,
                 _AREA: 1, _CHART: 1, _GAP: 1};
  const values = Object.fromEntries(Object.entries(sizes).map(([name, size]) => [name, new Float32Array(count * size)]));
  for (let i = 0; i < count; ++i) {
    const [u, v] = [i % rows / cells, Math.floor(i / rows) / cells];
    const [x, y] = [(u - 0.5) * side, (v - 0.5) * side];
    const z = height(x, y);
    const slope = [z * x / 3000, z * y / 3000, 1];
    const length = Math.hypot(...slope);
    values.POSITION.set([x, y, z], 3 * i);
    values.NORMAL.set(slope.map((part) => part / length), 3 * i);
    values.TEXCOORD_0.set([u, 1 - v], 2 * i);
    values._SHEET.set([x, y], 2 * i);
    values._PATTERN.set([x, y], 2 * i);
    values._THICKNESS[i] = 1 / length;
    values._CONTACT[i] = z > 20 ? 1 : 0;
    values._GAP[i] = Math.max(0, 20 - z);
    values._SHAPE[i] = length;
    values._AREA[i] = length;
    values._CHART[i] = 1;
  }
  const indices = new Uint32Array(cells * cells * 6);
  for (let j = 0, at = 0; j < cells; ++j)
    for (let i = 0; i < cells; ++i, at += 6) {
      const a = j * rows + i;
      indices.set([a, a + 1, a + rows + 1, a, a + rows + 1, a + rows], at);
    }

  const parts = [...Object.values(values), indices].map((array) => Buffer.from(array.buffer));
  parts.push(rings(1024, 60), rings(1024, 90));
  const bufferViews = [];
  const padded = [];
  let offset = 0;
  for (const part of parts) {
    bufferViews.push({buffer: 0, byteOffset: offset, byteLength: part.length});
    padded.push(part, Buffer.alloc((4 - part.length % 4) % 4));
    offset += part.length + (4 - part.length % 4) % 4;
  }
  const types = {1: 'SCALAR', 2: 'VEC2', 3: 'VEC3'};
  const names = Object.keys(sizes);
  const accessors = names.map((name, i) => ({bufferView: i, componentType: 5126, count, type: types[sizes[name]]}));
  Object.assign(accessors[0], {min: [-side / 2, -side / 2, 0], max: [side / 2, side / 2, 120]});
  accessors.push({bufferView: names.length, componentType: 5125, count: indices.length, type: 'SCALAR'});
  const material = (index) => ({pbrMetallicRoughness: {baseColorTexture: {index}}});
  const gltf = {
    asset: {version: '2.0'}, extensionsUsed: ['KHR_materials_variants'],
    extensions: {KHR_materials_variants: {variants: [{name: 'pre-distorted'}, {name: 'printed as drawn'}]}},
    scene: 0, scenes: [{nodes: [0]}], nodes: [{mesh: 0}],
    meshes: [{primitives: [{
      attributes: Object.fromEntries(names.map((name, i) => [name, i])), indices: names.length, material: 0,
      extensions: {KHR_materials_variants: {mappings: [{material: 0, variants: [0]}, {material: 1, variants: [1]}]}}}]}],
    materials: [material(0), material(1)], textures: [{source: 0}, {source: 1}],
    images: [1, 2].map((i) => ({bufferView: names.length + i, mimeType: 'image/png'})),
    accessors, bufferViews, buffers: [{byteLength: offset}]};
  let json = Buffer.from(JSON.stringify(gltf));
  json = Buffer.concat([json, Buffer.alloc((4 - json.length % 4) % 4, ' ')]);
  const head = Buffer.alloc(20);
  head.write('glTF');
  [2, 28 + json.length + offset, json.length, 0x4e4f534a].forEach((number, i) => { head.writeUInt32LE(number, 4 + 4 * i); });
  const binary = Buffer.alloc(8);
  binary.writeUInt32LE(offset);
  binary.writeUInt32LE(0x004e4942, 4);
  return Buffer.concat([head, json, binary, ...padded]);
}
