// How the settings of the group scan place a scan in the machine: the same turns in the same order as the server's.
import type {Axis} from './facts';

export type Matrix3 = readonly number[];  // by rows

export interface Placement {
  scale: number;  // mm of a unit
  up: Axis;
  mirror: boolean;
  roll: number;   // degrees
  pitch: number;
  front: '+x' | '-x' | '+y' | '-y';
  yaw: number;
}

const uprights: Record<Axis, Matrix3> = {
  '+z': [1, 0, 0, 0, 1, 0, 0, 0, 1], '-z': [1, 0, 0, 0, -1, 0, 0, 0, -1],
  '+y': [1, 0, 0, 0, 0, -1, 0, 1, 0], '-y': [1, 0, 0, 0, 0, 1, 0, -1, 0],
  '+x': [0, 0, -1, 0, 1, 0, 1, 0, 0], '-x': [0, 0, 1, 0, 1, 0, -1, 0, 0]};
const quarters: Record<Placement['front'], number> = {'+y': 0, '+x': 90, '-y': 180, '-x': -90};

const times = (a: Matrix3, b: Matrix3): Matrix3 => a.map((_, i) => {
  const row = i - i % 3, column = i % 3;
  return a[row]! * b[column]! + a[row + 1]! * b[column + 3]! + a[row + 2]! * b[column + 6]!;
});
function about(axis: 0 | 1 | 2, degrees: number): Matrix3 {
  const quarter = degrees % 90 === 0, angle = degrees * Math.PI / 180;
  const c = quarter ? Math.round(Math.cos(angle)) : Math.cos(angle), s = quarter ? Math.round(Math.sin(angle)) : Math.sin(angle);
  return axis === 0 ? [1, 0, 0, 0, c, -s, 0, s, c] : axis === 1 ? [c, 0, s, 0, 1, 0, -s, 0, c] : [c, -s, 0, s, c, 0, 0, 0, 1];
}

// Up, mirrored in x = 0, roll about x, pitch about y, the front to +y, yaw about z; in mm.
export function turnOf(p: Placement): Matrix3 {
  const turns: Matrix3[] = [uprights[p.up], [p.mirror ? -1 : 1, 0, 0, 0, 1, 0, 0, 0, 1], about(0, p.roll), about(1, p.pitch),
                            about(2, quarters[p.front]), about(2, p.yaw)];
  return turns.reduce((done, turn) => times(turn, done)).map((value) => value * p.scale);
}

// Where +z of the file, which glTF defines as the front of an asset, points in the upright scan, before the front is turned.
// Undefined if it points less than 45 degrees from the vertical.
export function frontOfGltf(p: Pick<Placement, 'up' | 'mirror' | 'roll' | 'pitch'>): Placement['front'] | undefined {
  const m = turnOf({...p, scale: 1, front: '+y', yaw: 0}), [x, y, z] = [m[2]!, m[5]!, m[8]!];
  if (Math.abs(z) > Math.hypot(x, y)) return undefined;
  return Math.abs(x) > Math.abs(y) ? (x > 0 ? '+x' : '-x') : y > 0 ? '+y' : '-y';
}

// The same turn with a yaw of at most 45 degrees either way, as the service wants it where the front is named.
export function quartered(front: Placement['front'], yaw: number): Pick<Placement, 'front' | 'yaw'> {
  const whole = quarters[front] + yaw, quarter = Math.round(whole / 90);
  return {front: (['+y', '+x', '-y', '-x'] as const)[((quarter % 4) + 4) % 4]!, yaw: Math.round(1000 * (whole - 90 * quarter)) / 1000 + 0};
}

// The tilt that turns a placed scan about the axis nearest to the picture's horizontal one, and the sign with which the side
// in front goes down. One looks from `azimuth`: 0 degrees from the front, 90 from -x.
export function tilting(azimuth: number, front: Placement['front'], yaw: number): ['roll' | 'pitch', number] {
  const angle = (azimuth - quarters[front] - yaw) * Math.PI / 180, c = Math.cos(angle), s = Math.sin(angle);
  return Math.abs(c) >= Math.abs(s) ? ['roll', -Math.sign(c)] : ['pitch', -Math.sign(s)];
}

export interface Placed {
  turn: Matrix3;
  shift: [number, number, number];  // added after the turn
  size: [number, number, number];   // of the whole scan, turned, in mm
  height: number;                   // of the cut scan above the platform
  top: [number, number];            // where it is highest, x and y
  half: [number, number];           // how far the cut scan reaches from the machine's axis, along x and y
}

// -180 to 180 degrees.
export const wrapped = (degrees: number): number => Math.round((((degrees + 180) % 360 + 360) % 360 - 180) * 1000) / 1000 + 0;

// Stands the scan on the platform: cut `trim` mm above its lowest point, the middle of what is left over the origin.
export function place(positions: Float32Array, placement: Placement, trim: number, plug = 0): Placed {
  const turn = turnOf(placement), low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  const at = (i: number, k: number): number =>
    turn[3 * k]! * positions[i]! + turn[3 * k + 1]! * positions[i + 1]! + turn[3 * k + 2]! * positions[i + 2]!;
  for (let i = 0; i < positions.length; i += 3)
    for (let k = 0; k < 3; ++k) {
      const value = at(i, k);
      if (value < low[k]!) low[k] = value;
      if (value > high[k]!) high[k] = value;
    }
  const cut = Math.min(low[2]! + trim, high[2]!);
  let top = 0;
  while (at(top, 2) < high[2]!) top += 3;
  const outer = farthest(positions, at, cut), [x, y] = enclosing(outer);
  const half = [0, 1].map((k) => Math.max(0, ...outer.filter((_, i) => i % 2 === k).map((value) => Math.abs(value - (k ? y : x)))));
  return {turn, shift: [-x, -y, plug - cut], size: low.map((value, k) => high[k]! - value) as Placed['size'],
          height: high[2]! - cut + plug, top: [at(top, 0) - x, at(top, 1) - y], half: half as Placed['half']};
}

// The points above the cut that are farthest in 128 directions, seen from above: xy pairs.
function farthest(positions: Float32Array, at: (i: number, k: number) => number, cut: number): number[] {
  const directions = 128, best = new Float64Array(directions).fill(-Infinity), found = new Int32Array(directions).fill(-1);
  const cosines = Array.from(best, (_, d) => Math.cos(2 * Math.PI * d / directions));
  const sines = Array.from(best, (_, d) => Math.sin(2 * Math.PI * d / directions));
  const step = 3 * Math.max(1, Math.floor(positions.length / 3 / 30_000));  // enough for a millimetre
  for (let i = 0; i + 2 < positions.length; i += step) {
    if (at(i, 2) < cut) continue;
    const x = at(i, 0), y = at(i, 1);
    for (let d = 0; d < directions; ++d) {
      const value = x * cosines[d]! + y * sines[d]!;
      if (value > best[d]!) {
        best[d] = value;
        found[d] = i;
      }
    }
  }
  return [...new Set(found)].filter((i) => i >= 0).flatMap((i) => [at(i, 0), at(i, 1)]);
}

// The centre of nearly the smallest circle around points: Badoiu and Clarkson 2003, "Smaller core-sets for balls". Within 0.1 %.
function enclosing(points: number[]): [number, number] {
  let x = points[0] ?? 0, y = points[1] ?? 0;
  for (let round = 1; round <= 1000; ++round) {
    let far = 0, radius = 0;
    for (let i = 0; i < points.length; i += 2) {
      const distance = Math.hypot(points[i]! - x, points[i + 1]! - y);
      if (distance > radius) {
        radius = distance;
        far = i;
      }
    }
    x += ((points[far] ?? x) - x) / (round + 1);
    y += ((points[far + 1] ?? y) - y) / (round + 1);
  }
  return [x, y];
}
