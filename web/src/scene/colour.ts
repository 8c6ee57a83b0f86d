// Colours of the heat maps as the report gives them, for the picture and for its legend alike. Without three: the legend
// needs them where there is no WebGL too.
import type {HeatMap} from '../state/result';

export type Rgb = readonly [number, number, number];  // 0 to 1, sRGB

const parts = (hex: string): Rgb =>
  [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255) as unknown as Rgb;

// The colour at `share` (0 to 1) of a map's range.
export function colourAt({colours}: Pick<HeatMap, 'colours'>, share: number): Rgb {
  const at = Math.min(1, Math.max(0, share)) * (colours.length - 1), low = Math.min(Math.floor(at), colours.length - 2);
  const a = parts(colours[low] ?? ''), b = parts(colours[low + 1] ?? ''), f = at - low;
  return [a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1]), a[2] + f * (b[2] - a[2])];
}

export const touches: Rgb = parts('#4d9de0'), touchesNot: Rgb = parts('#f2c14e'), noValue: Rgb = parts('#c9cdd1');
export const css = (colour: Rgb): string => `rgb(${colour.map((part) => Math.round(255 * part)).join(' ')})`;

// Where the legend has marks: the multiples of the step within the range.
export function marksOf({low, high, step}: Pick<HeatMap, 'low' | 'high' | 'step'>): number[] {
  const marks: number[] = [];
  for (let i = Math.ceil(low / step - 1e-6); i * step <= high + step * 1e-6; ++i) marks.push(Number((i * step).toPrecision(8)));
  return marks;
}
