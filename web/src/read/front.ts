// The head as one sees it from the front, drawn without WebGL: +x is on the left of the picture, -x on the right, up is up.
// One looks along -y, without perspective.
import type {ShownMesh} from './cluster';
import type {Matrix3} from './place';

export interface FrontPicture {
  width: number;                     // pixels
  height: number;
  pixels: Uint8ClampedArray;         // RGBA by rows from the upper left; nothing is drawn beside the head
}

const skin = [237, 232, 222], light = [-0.45, 0.65, 0.6];  // to the right in the picture, up, towards the viewer
const lightLength = Math.hypot(...light), pale = 105;      // alpha of what is cut away

// `turn`: of the mesh into the machine, as in Placed. `cut`: mm above the lowest point of the turned mesh; below it the
// picture is translucent. The longer side has `side` pixels.
export function frontPicture(mesh: ShownMesh, turn: Matrix3, cut: number, side: number): FrontPicture {
  const {positions, normals, indices} = mesh, count = positions.length / 3;
  const across = new Float32Array(count), up = new Float32Array(count), near = new Float32Array(count);
  let low = Infinity, high = -Infinity, left = Infinity, right = -Infinity;
  for (let i = 0; i < count; ++i) {
    const x = positions[3 * i]!, y = positions[3 * i + 1]!, z = positions[3 * i + 2]!;
    across[i] = -(turn[0]! * x + turn[1]! * y + turn[2]! * z);
    near[i] = turn[3]! * x + turn[4]! * y + turn[5]! * z;
    up[i] = turn[6]! * x + turn[7]! * y + turn[8]! * z;
    low = Math.min(low, up[i]!);
    high = Math.max(high, up[i]!);
    left = Math.min(left, across[i]!);
    right = Math.max(right, across[i]!);
  }
  const scale = (side - 2) / Math.max(right - left, high - low, 1e-9);
  const width = Math.max(1, Math.round((right - left) * scale) + 2), height = Math.max(1, Math.round((high - low) * scale) + 2);
  const pixels = new Uint8ClampedArray(4 * width * height), depth = new Float32Array(width * height).fill(-Infinity);
  for (let i = 0; i < count; ++i) {
    across[i] = (across[i]! - left) * scale + 0.5;
    up[i] = (high - up[i]!) * scale + 0.5;  // down, in pixels
  }
  const floor = (high - low - cut) * scale + 0.5;
  // how the light falls on each corner: the normals are turned, and face the viewer on both sides of the surface
  const bright = new Float32Array(count), size = Math.hypot(turn[0]!, turn[1]!, turn[2]!) || 1;
  for (let i = 0; i < count; ++i) {
    const x = normals[4 * i]! / 127, y = normals[4 * i + 1]! / 127, z = normals[4 * i + 2]! / 127;
    const r = -(turn[0]! * x + turn[1]! * y + turn[2]! * z) / size, n = (turn[3]! * x + turn[4]! * y + turn[5]! * z) / size,
      u = (turn[6]! * x + turn[7]! * y + turn[8]! * z) / size, sign = n < 0 ? -1 : 1;
    const key = Math.max(0, sign * (r * light[0]! + u * light[1]! + n * light[2]!) / lightLength), rim = 1 - Math.abs(n);
    bright[i] = (0.36 + 0.18 * Math.abs(n) + 0.48 * key) * (1 - 0.45 * rim ** 3);
  }
  for (let k = 0; k < indices.length; k += 3) {
    const a = indices[k]!, b = indices[k + 1]!, c = indices[k + 2]!;
    const ax = across[a]!, ay = up[a]!, bx = across[b]!, by = up[b]!, cx = across[c]!, cy = up[c]!;
    const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
    if (area === 0) continue;
    const y0 = Math.max(0, Math.ceil(Math.min(ay, by, cy) - 0.5)), y1 = Math.min(height - 1, Math.floor(Math.max(ay, by, cy) - 0.5));
    const x0 = Math.max(0, Math.ceil(Math.min(ax, bx, cx) - 0.5)), x1 = Math.min(width - 1, Math.floor(Math.max(ax, bx, cx) - 0.5));
    for (let y = y0; y <= y1; ++y)
      for (let x = x0; x <= x1; ++x) {
        const px = x + 0.5, py = y + 0.5;
        const v = ((px - ax) * (cy - ay) - (cx - ax) * (py - ay)) / area, w = ((bx - ax) * (py - ay) - (px - ax) * (by - ay)) / area, u = 1 - v - w;
        if (u < 0 || v < 0 || w < 0) continue;
        const far = u * near[a]! + v * near[b]! + w * near[c]!, at = y * width + x;
        if (far <= depth[at]!) continue;
        depth[at] = far;
        const shade = u * bright[a]! + v * bright[b]! + w * bright[c]!;
        for (let i = 0; i < 3; ++i) pixels[4 * at + i] = skin[i]! * shade;
        pixels[4 * at + 3] = py > floor ? pale : 255;
      }
  }
  return {width, height, pixels};
}
