// An array of loops: the layers that are printed one after the other, the coupling of every two loops, what to solder.
import type {Artifact} from '../api/types';
import type {PrintReport} from './result';

// ---- layers ----

export const steps = ['conductor', 'dielectric', 'bridges', 'resist', 'picture'] as const;
export type Step = (typeof steps)[number];
export type Face = 'outer' | 'inner';

export interface Layer {
  name: string;      // of its files, without the ending
  number: number;    // of the step of printing, from 1
  step: Step;
  face: Face;        // of the sheet; the inner one touches the mold, and what is printed on it is mirrored
  reverse: boolean;  // on the other face than print.svg
}

// In the order of printing. None for a print of one layer.
export function layersOf(artifacts: readonly Pick<Artifact, 'name'>[], inked: string): Layer[] {
  const first: Face = inked === 'inner' ? 'inner' : 'outer', other: Face = first === 'inner' ? 'outer' : 'inner';
  const names = new Set<string>(artifacts.map(({name}) => name));
  const all = [false, true].flatMap((reverse) => steps.map((step) => ({
    name: `print${reverse ? '-reverse' : ''}${step === 'conductor' ? '' : `-${step}`}`, step, face: reverse ? other : first, reverse})));
  const made = all.filter(({name}) => names.has(`${name}.svg`));
  return made.length > 1 ? made.map((layer, i) => ({...layer, number: i + 1})) : [];
}

// Of a layer that conducts: it has the lines of loops.
export const conducts = ({step}: Pick<Layer, 'step'>): boolean => step === 'conductor' || step === 'bridges';

// On white, as the formed part in formed.glb has them. A picture has the colours of its shapes, and this one in lists.
export function tintOf({step, reverse}: Pick<Layer, 'step' | 'reverse'>): {colour: string; opacity: number} {
  if (step === 'dielectric') return {colour: '#40a666', opacity: 0.75};
  if (step === 'bridges') return {colour: '#cc590d', opacity: 1};
  if (step === 'resist') return {colour: '#804dbf', opacity: 0.45};
  if (step === 'picture') return {colour: '#d43a8c', opacity: 1};
  return {colour: reverse ? '#2659bf' : '#1a1a1a', opacity: 1};
}

export const fillOf = (layer: Pick<Layer, 'step' | 'reverse'>, own: string): string => layer.step === 'picture' ? own : tintOf(layer).colour;

// In the order of painting: first what lies farthest from an eye on that side of the sheet. Of the face that it looks at, what
// was printed last lies on top.
export function farthestFirst(layers: readonly Layer[], from: Face): Layer[] {
  const depth = ({face, step}: Layer): number => face === from ? -steps.indexOf(step) : 1 + steps.indexOf(step);
  return [...layers].sort((a, b) => depth(b) - depth(a));
}

export const withLayer = (hidden: readonly string[], name: string, shown: boolean): string[] =>
  [...hidden.filter((one) => one !== name), ...(shown ? [] : [name])].sort();

// ---- coupling ----

// report.json: of the loops that lie wholly on the head.
export interface Couplings {
  coils: string[];
  k: (number | null)[][];
}
export const couplingsOf = ({couplings}: Pick<PrintReport, 'couplings'>): Couplings | null =>
  couplings && couplings.coils.length > 1 ? couplings : null;

export function strongest({k}: Couplings): [row: number, column: number] {
  let found: [number, number] = [1, 0];
  const size = ([a, b]: [number, number]): number => Math.abs(k[a]?.[b] ?? 0);
  k.forEach((row, a) => row.forEach((_, b) => { if (b < a && size([a, b]) > size(found)) found = [a, b]; }));
  return found;
}

// Where an arrow key leads in the table of `count` loops: never to the diagonal, where a loop meets itself. null: it stays.
export function stepped([row, column]: readonly [number, number], key: string, count: number): [number, number] | null {
  const ways: Record<string, readonly [number, number]> = {ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1]};
  const within = (value: number): boolean => value >= 0 && value < count;
  if (key === 'Home') return [row, row === 0 ? 1 : 0];
  if (key === 'End') return [row, row === count - 1 ? count - 2 : count - 1];
  const way = ways[key];
  if (!way) return null;
  let [a, b] = [row + way[0], column + way[1]];
  if (a === b) [a, b] = [a + way[0], b + way[1]];
  return within(a) && within(b) ? [a, b] : null;
}

// ---- what to solder ----

interface GapFigures {
  number: number;
  port: boolean;
  drawn: boolean;
  wanted_pf: number;
  standard_pf: number | null;  // 0: none is wanted
  plate: {pf: number; tolerance: number} | null;  // of a printed capacitor
  place_mm: [number, number, number];
}
// report.json, circuits
export interface Circuits {
  coils: {id: string; face: Face; tail?: {length_mm: number; ohm: number; inductance_nh: number} | null}[];
  electrical: {frequency_mhz: number; loops: {id: string; gaps: GapFigures[]}[]} | null;
}

export interface Gap {
  number: number;   // printed beside it
  loop: string;
  face: Face;
  port: boolean;
  printed: boolean;
  value: number;    // pF, of the row of standard values or as printed; 0: none
  tolerance: number;  // of a printed value, as a share
  wanted: number;   // pF
  place: [number, number, number];  // mm, on the mold
  tail: number;     // mm from a port to its pads beside the head; 0: none
}

export function gapsOf({circuits}: Pick<PrintReport, 'circuits'>): Gap[] {
  const faces = new Map(circuits?.coils.map(({id, face}) => [id, face]));
  const tails = new Map(circuits?.coils.map(({id, tail}) => [id, tail?.length_mm ?? 0]));
  return (circuits?.electrical?.loops ?? []).flatMap(({id, gaps}) => gaps.map((gap): Gap => ({
    number: gap.number, loop: id, face: faces.get(id) ?? 'outer', port: gap.port, printed: gap.plate !== null,
    value: gap.plate?.pf ?? gap.standard_pf ?? 0, tolerance: gap.plate?.tolerance ?? 0, wanted: gap.wanted_pf, place: gap.place_mm,
    tail: gap.port ? tails.get(id) ?? 0 : 0}))).sort((a, b) => a.number - b.number);
}
