// Where a ray meets a mesh first. It is tried on every triangle, which takes some milliseconds for 200,000 of them: no index has
// to be built or loaded.
import type {Mesh} from '../read/bytes';
import type {Point} from './measure';

export interface Hit {
  face: number;                      // number of the triangle
  shares: [number, number, number];  // of its corners
  far: number;                       // in lengths of `direction`
}

// Along `direction` from `origin`. Möller and Trumbore 1997.
export function hit({positions: p, indices}: Mesh, origin: Point, [dx, dy, dz]: Point): Hit | null {
  let far = Infinity, face = -1, u = 0, v = 0;
  for (let i = 0; i < indices.length; i += 3) {
    const a = 3 * indices[i]!, b = 3 * indices[i + 1]!, c = 3 * indices[i + 2]!;
    const ax = p[a]!, ay = p[a + 1]!, az = p[a + 2]!;
    const ex = p[b]! - ax, ey = p[b + 1]! - ay, ez = p[b + 2]! - az, fx = p[c]! - ax, fy = p[c + 1]! - ay, fz = p[c + 2]! - az;
    const hx = dy * fz - dz * fy, hy = dz * fx - dx * fz, hz = dx * fy - dy * fx, det = ex * hx + ey * hy + ez * hz;
    if (det === 0) continue;
    const sx = origin[0] - ax, sy = origin[1] - ay, sz = origin[2] - az, s = (sx * hx + sy * hy + sz * hz) / det;
    if (s < 0 || s > 1) continue;
    const qx = sy * ez - sz * ey, qy = sz * ex - sx * ez, qz = sx * ey - sy * ex, t = (dx * qx + dy * qy + dz * qz) / det;
    if (t < 0 || s + t > 1) continue;
    const away = (fx * qx + fy * qy + fz * qz) / det;
    if (away > 0 && away < far) [far, face, u, v] = [away, i / 3, s, t];
  }
  return face < 0 ? null : {face, shares: [1 - u - v, u, v], far};
}
