// The meshes of all nodes of the scene, in world coordinates.
import {MeshBuilder, ReadError, type Progress, type ScanMesh} from './bytes';

type Json = {[name: string]: unknown};
type Matrix = number[];  // 4 x 4 by columns, as glTF has it

const identity: Matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
const componentBytes: Record<number, number> = {5121: 1, 5123: 2, 5125: 4, 5126: 4};

export const isGlb = (bytes: Uint8Array): boolean =>
  bytes[0] === 103 && bytes[1] === 108 && bytes[2] === 84 && bytes[3] === 70;  // "glTF"

const isObject = (value: unknown): value is Json => typeof value === 'object' && value !== null && !Array.isArray(value);
const whole = (value: unknown, absent = -1): number =>
  value === undefined ? absent : typeof value === 'number' && value >= 0 && Number.isInteger(value) ? value : -1;
function nth(root: Json, name: string, index: unknown): Json {
  const list = root[name], item: unknown = Array.isArray(list) ? list[whole(index)] : undefined;
  if (!isObject(item)) throw new ReadError('header', null, name);
  return item;
}

export function readGlb(bytes: Uint8Array, progress: Progress): ScanMesh {
  const data = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  const ends = (): ReadError => new ReadError('ends', {unit: 'byte', at: bytes.length});
  if (bytes.length < 20) throw ends();
  if (data.getUint32(4, true) !== 2) throw new ReadError('header', {unit: 'byte', at: 4});
  if (data.getUint32(8, true) > bytes.length) throw ends();
  const jsonBytes = data.getUint32(12, true);
  if (data.getUint32(16, true) !== 0x4E4F534A) throw new ReadError('header', {unit: 'byte', at: 16});
  if (20 + jsonBytes > bytes.length) throw ends();
  let root: Json;
  try {
    root = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + jsonBytes))) as Json;
  } catch {
    throw new ReadError('header', {unit: 'byte', at: 20});
  }
  if (!isObject(root)) throw new ReadError('header', {unit: 'byte', at: 20});
  for (const name of Array.isArray(root['extensionsRequired']) ? root['extensionsRequired'] : [])
    if (/draco|meshopt|quantization/i.test(String(name))) throw new ReadError('compressed', null, String(name));
  const begin = 28 + jsonBytes, hasBinary = begin <= bytes.length && data.getUint32(begin - 4, true) === 0x004E4942;
  const length = hasBinary ? data.getUint32(begin - 8, true) : 0;
  if (begin + length > bytes.length && hasBinary) throw ends();

  function view(index: unknown, type: string, components: number): {at: number; count: number; stride: number; component: number} {
    const where = {unit: 'accessor' as const, at: whole(index)}, accessor = nth(root, 'accessors', index);
    if (accessor['sparse']) throw new ReadError('sparse', where);
    const component = whole(accessor['componentType']), size = (componentBytes[component] ?? 0) * components;
    if (accessor['type'] !== type || size === 0) throw new ReadError('header', where);
    const buffer = nth(root, 'bufferViews', accessor['bufferView']);
    if (whole(buffer['buffer']) !== 0 || nth(root, 'buffers', 0)['uri'] !== undefined) throw new ReadError('outside', where);
    const start = whole(buffer['byteOffset'], 0), bytesOfView = whole(buffer['byteLength']), offset = whole(accessor['byteOffset'], 0),
      stride = whole(buffer['byteStride'], size), count = whole(accessor['count']);
    if (Math.min(start, bytesOfView, offset, count) < 0 || stride < size) throw new ReadError('header', where);
    if (start + bytesOfView > length || (count > 0 && offset + (count - 1) * stride + size > bytesOfView))
      throw new ReadError('ends', where);
    return {at: begin + start + offset, count, stride, component};
  }

  const mesh = new MeshBuilder();
  function primitive(part: unknown, m: Matrix): void {
    if (!isObject(part)) throw new ReadError('header', null, 'primitives');
    const mode = whole(part['mode'], 4);
    if (mode < 4) return;  // points and lines
    const extensions = part['extensions'], attributes = part['attributes'];
    if (isObject(extensions) && extensions['KHR_draco_mesh_compression'])
      throw new ReadError('compressed', null, 'KHR_draco_mesh_compression');
    if (mode > 6 || !isObject(attributes)) throw new ReadError('header', null, 'primitives');
    const points = view(attributes['POSITION'], 'VEC3', 3), base = mesh.points;
    if (points.component !== 5126) throw new ReadError('compressed', null, 'KHR_mesh_quantization');
    for (let k = 0; k < points.count; ++k) {
      if (k % 65536 === 0) progress(points.at / bytes.length);
      const at = points.at + k * points.stride;
      const x = data.getFloat32(at, true), y = data.getFloat32(at + 4, true), z = data.getFloat32(at + 8, true);
      const row = (r: number): number => m[r]! * x + m[4 + r]! * y + m[8 + r]! * z + m[12 + r]!;
      mesh.point(row(0), row(1), row(2));
    }
    const list = part['indices'] === undefined ? null : view(part['indices'], 'SCALAR', 1);
    if (list?.component === 5126) throw new ReadError('header', null, 'indices');
    const n = list?.count ?? points.count;
    const corner = (i: number): number => {
      const at = list ? list.at + i * list.stride : 0;
      const index = !list ? i : list.component === 5121 ? data.getUint8(at)
        : list.component === 5123 ? data.getUint16(at, true) : data.getUint32(at, true);
      if (index >= points.count) throw new ReadError('index', null, String(index));
      return base + index;
    };
    const mirrored = m[0]! * (m[5]! * m[10]! - m[6]! * m[9]!) - m[4]! * (m[1]! * m[10]! - m[2]! * m[9]!) +
                     m[8]! * (m[1]! * m[6]! - m[2]! * m[5]!) < 0;
    for (let i = 0; i < (mode === 4 ? Math.floor(n / 3) : n - 2); ++i) {
      const [a, b, c] = mode === 4 ? [3 * i, 3 * i + 1, 3 * i + 2]
        : mode === 5 ? [i, i + 1 + i % 2, i + 2 - i % 2] : [0, i + 1, i + 2];
      mesh.triangle(corner(a), corner(mirrored ? c : b), corner(mirrored ? b : c));
    }
  }

  const nodes = root['nodes'];
  if (!Array.isArray(nodes)) throw new ReadError('header', null, 'nodes');
  const visited = new Set<number>();
  const open: {index: number; matrix: Matrix}[] = [];
  const push = (children: unknown, matrix: Matrix): void => {
    if (!Array.isArray(children)) throw new ReadError('header', null, 'nodes');
    for (const child of children) {
      const index = whole(child);
      if (index < 0 || index >= nodes.length || visited.has(index)) throw new ReadError('header', {unit: 'node', at: index});
      visited.add(index);
      open.push({index, matrix});
    }
  };
  const scenes = root['scenes'], scene: unknown = Array.isArray(scenes) ? scenes[whole(root['scene'], 0)] : undefined;
  const children = new Set(nodes.flatMap((node) => isObject(node) && Array.isArray(node['children']) ? node['children'] : []));
  push(isObject(scene) && scene['nodes'] ? scene['nodes'] : nodes.map((_, i) => i).filter((i) => !children.has(i)), identity);
  for (let next = open.pop(); next; next = open.pop()) {
    const node = nth(root, 'nodes', next.index), matrix = times(next.matrix, localMatrix(node, next.index));
    if (node['mesh'] !== undefined) {
      const parts = nth(root, 'meshes', node['mesh'])['primitives'];
      for (const part of Array.isArray(parts) ? parts : []) primitive(part, matrix);
    }
    if (node['children'] !== undefined) push(node['children'], matrix);
  }
  return mesh.finish('GLB', true);
}

function times(a: Matrix, b: Matrix): Matrix {
  return identity.map((_, i) => {
    const row = i % 4, column = i - row;
    return a[row]! * b[column]! + a[4 + row]! * b[column + 1]! + a[8 + row]! * b[column + 2]! + a[12 + row]! * b[column + 3]!;
  });
}

function localMatrix(node: Json, index: number): Matrix {
  const numbers = (name: string, absent: number[]): number[] => {
    const given = node[name];
    if (given === undefined) return absent;
    if (!Array.isArray(given) || given.length !== absent.length || !given.every((value) => Number.isFinite(value)))
      throw new ReadError('header', {unit: 'node', at: index});
    return given as number[];
  };
  if (node['matrix'] !== undefined) return numbers('matrix', identity);
  const [tx, ty, tz] = numbers('translation', [0, 0, 0]), [sx, sy, sz] = numbers('scale', [1, 1, 1]);
  const turn = numbers('rotation', [0, 0, 0, 1]), length = Math.hypot(...turn) || 1;
  const [x, y, z, w] = turn.map((value) => value / length) as [number, number, number, number];
  return [
    (1 - 2 * (y * y + z * z)) * sx!, 2 * (x * y + z * w) * sx!, 2 * (x * z - y * w) * sx!, 0,
    2 * (x * y - z * w) * sy!, (1 - 2 * (x * x + z * z)) * sy!, 2 * (y * z + x * w) * sy!, 0,
    2 * (x * z + y * w) * sz!, 2 * (y * z - x * w) * sz!, (1 - 2 * (x * x + y * y)) * sz!, 0,
    tx!, ty!, tz!, 1];
}
