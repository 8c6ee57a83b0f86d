// What a scan says of itself before it is sent: size, likely unit, likely up axis, whether its triangles face inwards.
import type {ScanMesh} from './bytes';
import {forAreas} from './cluster';

export const axes = ['+x', '-x', '+y', '-y', '+z', '-z'] as const;
export type Axis = (typeof axes)[number];
export const units = ['mm', 'cm', 'm', 'in', 'um', 'ft'] as const;
export type Unit = (typeof units)[number];
const millimetres: Record<Unit, number> = {mm: 1, cm: 10, m: 1000, in: 25.4, um: 0.001, ft: 304.8};

export interface ScanFacts {
  format: string;
  triangles: number;
  low: [number, number, number];   // the box, in the unit of the file
  high: [number, number, number];
  insideOut: boolean;              // its triangles face inwards: reversed, or a mirror image
  up: {axis: Axis; told: boolean}; // told: by the format or by the opening of the scan; otherwise a guess
  zFront: boolean;                 // the format says that +z of the file is the front
}

const vector = (axis: Axis): number[] => ['x', 'y', 'z'].map((name) => axis[1] !== name ? 0 : axis[0] === '+' ? 1 : -1);

export function factsOf(mesh: ScanMesh): ScanFacts {
  const low: ScanFacts['low'] = [Infinity, Infinity, Infinity], high: ScanFacts['high'] = [-Infinity, -Infinity, -Infinity];
  const {positions: p, indices} = mesh;
  for (const index of indices)
    for (let k = 0; k < 3; ++k) {
      const value = p[3 * index + k]!;
      if (value < low[k]!) low[k] = value;
      if (value > high[k]!) high[k] = value;
    }
  const middle = low.map((value, k) => (value + high[k]!) / 2);
  let volume = 0, area = 0;
  const sum = [0, 0, 0];
  forAreas(mesh, (x, y, z, first) => {
    const a = 3 * indices[first]!;
    volume += x * (p[a]! - middle[0]!) + y * (p[a + 1]! - middle[1]!) + z * (p[a + 2]! - middle[2]!);
    area += Math.hypot(x, y, z);
    sum[0]! += x;
    sum[1]! += y;
    sum[2]! += z;
  });
  const inwards = volume < 0;
  return {format: mesh.format, triangles: indices.length / 3, low, high, insideOut: inwards, zFront: mesh.yUp,
          up: mesh.yUp ? {axis: '+y', told: true} : upOf(mesh, low, high, inwards ? sum.map((value) => -value) : sum, area)};
}

// The side opposite to the opening of an open scan (the sum of all areas points away from it); otherwise opposite to the
// largest flat side, if no other one is half as large; otherwise +z.
function upOf(mesh: ScanMesh, low: number[], high: number[], sum: number[], area: number): ScanFacts['up'] {
  const along = (axis: Axis): number => vector(axis).reduce((total, value, k) => total + value * sum[k]!, 0);
  const most = axes.reduce((best, axis) => along(axis) > along(best) ? axis : best);
  const size = low.map((value, k) => high[k]! - value), k = 'xyz'.indexOf(most[1]!);
  const below = 2 * size[(k + 1) % 3]! * size[(k + 2) % 3]!;  // areas are doubled
  if (Math.hypot(...sum) > 0.015 * area && along(most) > 0.12 * below) return {axis: most, told: true};

  const band = 0.004 * Math.hypot(...size), flat = axes.map(() => 0);
  forAreas(mesh, (x, y, z, first) => {
    const n = [x, y, z], length = Math.hypot(x, y, z), at = 3 * mesh.indices[first]!;
    axes.forEach((axis, i) => {
      const direction = vector(axis), c = 'xyz'.indexOf(axis[1]!), sign = direction[c]!;
      if (Math.abs(n[c]!) < 0.99 * length) return;
      const bottom = sign > 0 ? low[c]! : high[c]!;
      if (Math.abs(mesh.positions[at + c]! - bottom) < band) flat[i]! += length;
    });
  });
  const [first = 0, second = 0] = [...flat].sort((a, b) => b - a);
  if (first > 0.02 * area && second < first / 2) return {axis: axes[flat.indexOf(first)]!, told: true};
  return {axis: '+z', told: false};
}

export const longest = (facts: ScanFacts): number => Math.max(...facts.low.map((value, k) => facts.high[k]! - value));

// What is plausible for a head: the server takes the same limits.
export const plausible = (mm: number): boolean => mm >= 80 && mm <= 400;

export interface SizeGuess {
  unit: Unit;
  mm: [number, number, number];
  like: 'adult' | 'newborn' | 'small' | 'large';  // compared with a head; an adult's is 190 mm long, a newborn's 115 mm
}
export function sizesOf(facts: ScanFacts): SizeGuess[] {
  return units.map((unit) => {
    const mm = facts.low.map((value, k) => (facts.high[k]! - value) * millimetres[unit]) as SizeGuess['mm'];
    const side = Math.max(...mm);
    return {unit, mm, like: side < 80 ? 'small' : side > 400 ? 'large' : side < 150 ? 'newborn' : 'adult'};
  });
}
// The only unit in which the size is plausible for a head. Feet are never guessed: a scan in metres is far more common.
export function unitOf(facts: ScanFacts): Unit | undefined {
  const fitting = units.filter((unit) => unit !== 'ft' && plausible(longest(facts) * millimetres[unit]));
  return fitting.length === 1 ? fitting[0] : undefined;
}
export const inMillimetres = (unit: Unit): number => millimetres[unit];
