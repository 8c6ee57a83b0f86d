// Scans in every format, written by the tests. The body is a box of 100 x 150 x 200 with its foot at z = 0 and a face of 8
// corners and 12 triangles that look outwards.
export const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [i & 1 ? 50 : -50, i & 2 ? 75 : -75, i & 4 ? 200 : 0]) as [number, number, number][];
export const faces: [number, number, number][] = [
  [0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]];

export const utf8 = (text: string): Uint8Array => new TextEncoder().encode(text);

export function joined(...parts: Uint8Array[]): Uint8Array {
  const all = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

export function stlBinary(points = corners, triangles = faces): Uint8Array {
  const bytes = new Uint8Array(84 + 50 * triangles.length), view = new DataView(bytes.buffer);
  view.setUint32(80, triangles.length, true);
  triangles.forEach((face, k) => face.forEach((corner, i) => points[corner]!.forEach((value, c) =>
    view.setFloat32(84 + 50 * k + 12 + 12 * i + 4 * c, value, true))));
  return bytes;
}

export const stlAscii = (): Uint8Array => utf8('solid a head\n' + faces.map((face) =>
  ' facet normal 0 0 -nan\n  outer loop\n' + face.map((i) => `   vertex ${corners[i]!.map((v) => v.toExponential(3)).join(' ')}\n`).join('') +
  '  endloop\n endfacet\n').join('') + 'endsolid a head\n');

// Faces that share an edge are written as squares, some with negative indices and texture coordinates.
export const obj = (): Uint8Array => utf8('# a head\nmtllib a.mtl\n' + corners.map((p) => `v ${p.join(' ')} 1 0 0\n`).join('') +
  'vt 0 0\nvn 0 0 1\nf 1/1/1 3/1/1 4/1/1 2/1/1\nf -4 -3 -1 -2\r\n' +
  faces.slice(4).map((face) => `f ${face.map((i) => `${i + 1}//1`).join(' ')}\n`).join(''));

export const off = (): Uint8Array => utf8(`OFF\n# a comment\n8 12 0\n${corners.map((p) => p.join(' ')).join('\n')}\n` +
  faces.map((face) => `3 ${face.join(' ')} 255 0 0`).join('\n') + '\n');

export function ply(format: 'ascii' | 'binary_little_endian' | 'binary_big_endian'): Uint8Array {
  const header = utf8(`ply\nformat ${format} 1.0\ncomment made by a test\nelement vertex 8\nproperty float x\nproperty double y\n` +
    'property float z\nproperty uchar red\nelement face 12\nproperty list uchar int vertex_indices\nproperty short part\nend_header\n');
  if (format === 'ascii')
    return joined(header, utf8(corners.map((p) => p.join(' ') + ' 7\n').join('') + faces.map((f) => `3 ${f.join(' ')} -1\n`).join('')));
  const little = format === 'binary_little_endian', body = new DataView(new ArrayBuffer(8 * 17 + 12 * 15));
  corners.forEach(([x, y, z], k) => {
    body.setFloat32(17 * k, x, little);
    body.setFloat64(17 * k + 4, y, little);
    body.setFloat32(17 * k + 12, z, little);
  });
  faces.forEach((face, k) => {
    const at = 8 * 17 + 15 * k;
    body.setUint8(at, 3);
    face.forEach((corner, i) => body.setInt32(at + 1 + 4 * i, corner, little));
  });
  return joined(header, new Uint8Array(body.buffer));
}

// Positions in metres; a node scales them to millimetres and a child node mirrors them in x.
export function glb(change: (root: Record<string, any>) => void = () => {}): Uint8Array {
  const points = new Float32Array(corners.flatMap(([x, y, z]) => [-x / 1000, y / 1000, z / 1000]));
  const indices = new Uint16Array(faces.flatMap(([a, b, c]) => [a, c, b]));
  const binary = joined(new Uint8Array(points.buffer), new Uint8Array(indices.buffer));
  const root = {
    asset: {version: '2.0'}, scene: 0, scenes: [{nodes: [0]}],
    nodes: [{scale: [1000, 1000, 1000], children: [1]}, {mesh: 0, scale: [-1, 1, 1]}],
    meshes: [{primitives: [{attributes: {POSITION: 0}, indices: 1}]}],
    accessors: [{bufferView: 0, componentType: 5126, count: 8, type: 'VEC3'}, {bufferView: 1, componentType: 5123, count: 36, type: 'SCALAR'}],
    bufferViews: [{buffer: 0, byteLength: 96}, {buffer: 0, byteOffset: 96, byteLength: 72}], buffers: [{byteLength: 168}]};
  change(root);
  let json = JSON.stringify(root);
  json += ' '.repeat((4 - json.length % 4) % 4);
  const head = new DataView(new ArrayBuffer(20)), chunk = new DataView(new ArrayBuffer(8));
  [0x46546C67, 2, 28 + json.length + binary.length, json.length, 0x4E4F534A].forEach((value, i) => head.setUint32(4 * i, value, true));
  [binary.length, 0x004E4942].forEach((value, i) => chunk.setUint32(4 * i, value, true));
  return joined(new Uint8Array(head.buffer), utf8(json), new Uint8Array(chunk.buffer), binary);
}

export const all = (): [string, Uint8Array][] => [
  ['head.stl', stlBinary()], ['ascii.stl', stlAscii()], ['head.obj', obj()], ['head.off', off()], ['ascii.ply', ply('ascii')],
  ['little.ply', ply('binary_little_endian')], ['big.ply', ply('binary_big_endian')], ['head.glb', glb()]];
