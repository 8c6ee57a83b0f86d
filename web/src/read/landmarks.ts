// Straightens a head by three landmarks: the bridge of the nose (nasion) and, for each ear, the point in front of its canal.
// The ears come to lie along x, the nose points to +y, and the plane of the three is level: the head coordinate system of
// MEG and EEG, as Neuromag has it.
import {turnOf, type Placement} from './place';

export type Point = readonly [number, number, number];
export const landmarks = ['nose', 'left', 'right'] as const;
export interface Straight {
  roll: number;      // degrees, rounded to 0.1
  pitch: number;
  front: Placement['front'];
  yaw: number;
  flipped: boolean;  // the left ear comes to lie at +x
}

const minus = (a: Point, b: Point): Point => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = (a: Point, b: Point): Point => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const degrees = (y: number, x: number): number => Math.round(Math.atan2(y, x) * 1800 / Math.PI) / 10 + 0;  // without -0

// `points`: nose, left and right ear, as the file of the scan has them. Turns them from how scale, up and mirror leave them.
// Null if no head has such points, or if their plane stands upright and does not say which way is up.
export function straighten(points: readonly Point[], base: Pick<Placement, 'scale' | 'up' | 'mirror'>): Straight | null {
  const m = turnOf({...base, roll: 0, pitch: 0, front: '+y', yaw: 0});
  const [nose, left, right] = points.map(([x, y, z]): Point =>
    [m[0]! * x + m[1]! * y + m[2]! * z, m[3]! * x + m[4]! * y + m[5]! * z, m[6]! * x + m[7]! * y + m[8]! * z]) as [Point, Point, Point];
  const ears = minus(right, left), apart = Math.hypot(...ears);
  const normal = cross(ears, minus(nose, left)), area = Math.hypot(...normal);
  if (apart < 40 || apart > 300 || area < 0.2 * apart ** 2 || Math.abs(normal[2]) < area / 2) return null;
  // Rows of the matrix yaw * pitch * roll, times their lengths: the x axis is sign * ears, y is cross(normal, ears), and z is
  // sign * normal, the side of the plane on which the ceiling is.
  const flipped = normal[2] < 0, sign = flipped ? -1 : 1;
  const turn = degrees(cross(normal, ears)[0], sign * ears[0] * area), quarter = Math.round(turn / 90);
  return {
    roll: degrees(sign * normal[1], sign * normal[2]), pitch: degrees(-sign * normal[0], Math.hypot(normal[1], normal[2])), flipped,
    front: (['-y', '-x', '+y', '+x', '-y'] as const)[quarter + 2]!, yaw: Math.round(10 * (turn - 90 * quarter)) / 10 + 0};
}
