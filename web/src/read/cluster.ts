// Meshes for the screen: corners at one place become one, and a mesh with too many triangles becomes coarser. Vertex
// clustering after Rossignac and Borrel 1993, "Multi-resolution 3D approximations for rendering complex scenes".
import type {Mesh} from './bytes';

export interface ShownMesh extends Mesh {
  normals: Int8Array;  // xyzw of each corner, 127 long; w is 0 and keeps them aligned
}

function sizeOf(positions: Float32Array): {low: number[]; size: number[]; diagonal: number} {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; ++i) {
    const k = i % 3, value = positions[i]!;
    if (value < low[k]!) low[k] = value;
    if (value > high[k]!) high[k] = value;
  }
  const size = low.map((value, k) => high[k]! - value);
  return {low, size, diagonal: Math.hypot(...size)};
}

// One vertex, the mean, for all vertices of a cell of a cubic grid; triangles that lose a corner are dropped.
export function cluster(mesh: Mesh, cell: number): Mesh {
  const {positions, indices} = mesh, points = positions.length / 3, {low} = sizeOf(positions);
  let bits = 1;
  while (1 << bits < 2 * points) ++bits;
  const slots = new Int32Array(1 << bits).fill(-1), mask = slots.length - 1;  // open addressing
  const cells = new Int32Array(3 * points), sums = new Float64Array(3 * points), counts = new Uint32Array(points);
  const merged = new Uint32Array(points);
  let count = 0;
  for (let i = 0; i < points; ++i) {
    const x = Math.round((positions[3 * i]! - low[0]!) / cell), y = Math.round((positions[3 * i + 1]! - low[1]!) / cell),
      z = Math.round((positions[3 * i + 2]! - low[2]!) / cell);
    let slot = (Math.imul(x, 73856093) ^ Math.imul(y, 19349663) ^ Math.imul(z, 83492791));
    slot = (slot ^ slot >>> 15) & mask;
    let found = slots[slot]!;
    while (found >= 0 && (cells[3 * found] !== x || cells[3 * found + 1] !== y || cells[3 * found + 2] !== z))
      found = slots[slot = (slot + 1) & mask]!;
    if (found < 0) {
      found = slots[slot] = count++;
      cells.set([x, y, z], 3 * found);
    }
    merged[i] = found;
    ++counts[found]!;
    for (let k = 0; k < 3; ++k) sums[3 * found + k]! += positions[3 * i + k]!;
  }
  const means = new Float32Array(3 * count);
  for (let i = 0; i < means.length; ++i) means[i] = sums[i]! / counts[Math.floor(i / 3)]!;
  const kept = new Uint32Array(indices.length);
  let length = 0;
  for (let i = 0; i < indices.length; i += 3) {
    const a = merged[indices[i]!]!, b = merged[indices[i + 1]!]!, c = merged[indices[i + 2]!]!;
    if (a === b || b === c || c === a) continue;
    kept[length++] = a;
    kept[length++] = b;
    kept[length++] = c;
  }
  return {positions: means, indices: kept.slice(0, length)};
}

// At most about `triangles` triangles; at the least, corners closer than a millionth of the size become one.
export function forScreen(mesh: Mesh, triangles: number): ShownMesh {
  const {diagonal} = sizeOf(mesh.positions);
  let shown = cluster(mesh, diagonal * 1e-6);
  if (shown.indices.length > 3 * triangles) {
    let area = 0;
    forAreas(shown, (x, y, z) => { area += Math.hypot(x, y, z) / 2; });
    const fine = shown;
    for (let cell = Math.sqrt(2 * area / triangles); shown.indices.length > 3 * triangles; cell *= 1.2) shown = cluster(fine, cell);
  }
  return {...shown, normals: normalsOf(shown)};
}

// The vector area, doubled, of each triangle.
export function forAreas(mesh: Mesh, use: (x: number, y: number, z: number, first: number) => void): void {
  const {positions: p, indices} = mesh;
  for (let i = 0; i < indices.length; i += 3) {
    const a = 3 * indices[i]!, b = 3 * indices[i + 1]!, c = 3 * indices[i + 2]!;
    const ux = p[b]! - p[a]!, uy = p[b + 1]! - p[a + 1]!, uz = p[b + 2]! - p[a + 2]!;
    const vx = p[c]! - p[a]!, vy = p[c + 1]! - p[a + 1]!, vz = p[c + 2]! - p[a + 2]!;
    use(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx, i);
  }
}

function normalsOf(mesh: Mesh): Int8Array {
  const sums = new Float32Array(mesh.positions.length), normals = new Int8Array(mesh.positions.length / 3 * 4);
  forAreas(mesh, (x, y, z, first) => {
    for (let k = first; k < first + 3; ++k) {
      const at = 3 * mesh.indices[k]!;
      sums[at]! += x;
      sums[at + 1]! += y;
      sums[at + 2]! += z;
    }
  });
  for (let i = 0; i < sums.length / 3; ++i) {
    const length = Math.hypot(sums[3 * i]!, sums[3 * i + 1]!, sums[3 * i + 2]!) || 1;
    for (let k = 0; k < 3; ++k) normals[4 * i + k] = Math.round(127 * sums[3 * i + k]! / length);
  }
  return normals;
}
