// The ink of a layer as its SVG has it (worker/printing/print_svg.cpp). Only what Vacuform writes there is understood.

import type {Line} from './result';

export interface InkPath {
  d: string;
  fill: string;  // its colour in the file
  evenOdd: boolean;
  opacity: number;
}
// In millimetres from the centre of the sheet, y down, as seen from above: not mirrored.
export interface LayerInk {
  paths: InkPath[];
  numbers: {x: number; y: number; size: number; text: string}[];  // beside the gaps
}
export interface Page {
  box: [left: number, top: number, width: number, height: number];  // mm
  mirrored: boolean;
}

const parts = (svg: string): [before: string, ink: string, marks: string] => {
  const begin = svg.indexOf('<g id="pattern'), end = svg.lastIndexOf('<g id="marks');
  return begin < 0 || end < begin ? [svg, '', ''] : [svg.slice(0, begin), svg.slice(begin, end), svg.slice(end)];
};

export function pageOf(svg: string): Page {
  const box = /viewBox="([^"]*)"/.exec(svg)?.[1]?.split(/\s+/).map(Number) ?? [];
  const [left = 0, top = 0, width = 0, height = 0] = box;
  return {box: [left, top, width, height], mirrored: /^<g id="pattern[^>]*scale\(-1 1\)/.test(parts(svg)[1])};
}

export function inkOf(svg: string): LayerInk {
  const [, ink, marks] = parts(svg), {mirrored} = pageOf(svg);
  const paths = [...ink.matchAll(/<path fill="([^"]*)"([^>]*) d="([^"]*)"\/>/g)].map(([, fill = '', more = '', d = '']): InkPath => ({
    d, fill, evenOdd: more.includes('evenodd'), opacity: Number(/fill-opacity="([^"]*)"/.exec(more)?.[1] ?? 1)}));
  const list = /<g id="mark-gap-numbers">([\s\S]*?)<\/g>/.exec(marks)?.[1] ?? '';
  const numbers = [...list.matchAll(/translate\(([-\d.]+)[ ,]+([-\d.]+)\)[^>]*font-size="([\d.]+)"[^>]*>(\d+)</g)].map(
    ([, x, y, size, text = '']) => ({x: (mirrored ? -1 : 1) * Number(x), y: Number(y), size: Number(size), text}));
  return {paths, numbers};
}

// The marks of a page alone, without what belongs to one layer: its legend and the numbers of its gaps.
export function marksOnly(svg: string): string {
  const [before, , marks] = parts(svg);
  return before + marks.replace(/<g id="mark-(legend|gap-numbers)">[\s\S]*?<\/g>\n?/g, '');
}

const reach = 15;  // mm between two pieces of a loop: a gap for a capacitor, or the place under a bridge of another loop
const apart = (a: readonly number[], b: readonly number[]): number => Math.hypot(a[0]! - b[0]!, a[1]! - b[1]!);

// The pieces of a line that gaps and bridges interrupt, one after the other: each is followed by the one that begins or ends
// nearest to its end.
function chained(pieces: readonly Line[]): Line[] {
  const left = [...pieces].sort((a, b) => b.length - a.length), chains: Line[] = [];
  for (let line = left.shift(); line; line = left.shift()) {
    for (let turns = 0; turns < 2; line.reverse(), ++turns) {
      for (;;) {
        const end = line.at(-1)!;
        let next = -1, backwards = false, least = reach;
        left.forEach((piece, i) => {
          for (const back of [false, true]) {
            const far = apart(end, (back ? piece.at(-1) : piece[0])!);
            if (far < least) [next, backwards, least] = [i, back, far];
          }
        });
        const [piece] = next < 0 ? [] : left.splice(next, 1);
        if (!piece) break;
        line.push(...(backwards ? [...piece].reverse() : piece));
      }
    }
    chains.push(line);
  }
  return chains;
}

// The centre lines of several layers, by the names of their elements: every loop whole, whatever interrupts its ink.
export function wholeLines(layers: readonly ReadonlyMap<string, Line[]>[]): Map<string, Line[]> {
  const all = new Map<string, Line[]>();
  for (const layer of layers) for (const [id, lines] of layer) all.set(id, [...all.get(id) ?? [], ...lines.filter(({length}) => length > 0)]);
  const closed = (line: Line): boolean => line.length > 2 && apart(line[0]!, line.at(-1)!) < 1e-3;
  for (const [id, lines] of all)
    all.set(id, [...lines.filter(closed), ...chained(lines.filter((line) => !closed(line)).map((line) => [...line]))]);
  return all;
}
