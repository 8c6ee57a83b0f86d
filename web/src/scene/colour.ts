// Colours of the heat maps, for the picture and for its legend alike. Without three: the legend needs them where there is
// no WebGL too.
import type {MapName} from '../state/result';

export type HeatName = 'shape' | 'area' | 'thickness' | 'temperature' | 'air' | 'position' | 'colour';
export const isHeat = (map: MapName): map is HeatName => map !== 'print' && map !== 'contact';

export type Rgb = readonly [number, number, number];  // 0 to 1, sRGB

// cividis in ten steps (Nunez, Anderton, Renslow 2018, doi 10.1371/journal.pone.0199239), and the half of a diverging
// scale (PuOr of ColorBrewer) above its centre: distortion is always given above 1.
const scales = {
  cividis: ['00204d', '00336f', '39486b', '575c6d', '707173', '8a8779', 'a69d75', 'c4b56c', 'e4cf5b', 'ffea46'],
  diverging: ['f7f7f7', 'fee0b6', 'fdb863', 'e08214', 'b35806', '7f3b08'],
};
const parts = (hex: string): Rgb =>
  [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255) as unknown as Rgb;

// The colour at `share` (0 to 1) of a map's range.
export function colourAt(map: HeatName, share: number): Rgb {
  const stops = scales[map === 'shape' || map === 'area' ? 'diverging' : 'cividis'];
  if (map === 'air') share = 1 - share;  // bright where the sheet touches, so that the ink is seen
  const at = Math.min(1, Math.max(0, share)) * (stops.length - 1), low = Math.min(Math.floor(at), stops.length - 2);
  const a = parts(stops[low] ?? ''), b = parts(stops[low + 1] ?? ''), f = at - low;
  return [a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1]), a[2] + f * (b[2] - a[2])];
}

export const touches: Rgb = parts('4d9de0'), touchesNot: Rgb = parts('f2c14e'), noValue: Rgb = parts('c9cdd1');
export const css = (colour: Rgb): string => `rgb(${colour.map((part) => Math.round(255 * part)).join(' ')})`;

export interface Range {
  low: number;
  high: number;
  step: number;   // between isolines and between the marks of the legend
  limit?: number; // the tolerance
}

export interface Tolerances {
  thickness: number;        // sheet.thickness_mm
  thinLimit: number;        // forming.thin_limit
  distortionLimit: number;  // pattern.distortion_limit
  window: readonly [number, number];  // degrees Celsius in which the plastic forms
}
// Ranges come from settings and plastic alone, so that two jobs with the same settings have the same colours.
export function rangeOf(map: HeatName, from: Tolerances): Range {
  switch (map) {
    case 'shape':
    case 'area': return {low: 1, high: 2, step: 0.1, limit: from.distortionLimit};
    case 'thickness': {
      const low = from.thickness * from.thinLimit;
      return {low, high: from.thickness, step: roundStep((from.thickness - low) / 10)};
    }
    case 'temperature': {
      const [low, high] = from.window;
      return {low, high, step: 5};
    }
    case 'position': return {low: 0, high: 1, step: 0.1};
    case 'air':
    case 'colour': return {low: 0, high: 5, step: 1};
  }
}

// 1, 2 or 5 times a power of ten, at least `least`.
export function roundStep(least: number): number {
  const power = 10 ** Math.floor(Math.log10(least));
  return power * ([1, 2, 5].find((factor) => factor * power >= least * 0.999) ?? 10);
}

// Where the legend has marks: the multiples of the step within the range.
export function marksOf({low, high, step}: Range): number[] {
  const marks: number[] = [];
  for (let i = Math.ceil(low / step - 1e-6); i * step <= high + step * 1e-6; ++i) marks.push(Number((i * step).toPrecision(8)));
  return marks;
}
