// The ink of a layer as its SVG has it (worker/printing/print_svg.cpp). Only what Vacuform writes there is understood.

export interface InkPath {
  d: string;
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
  const paths = [...ink.matchAll(/<path fill="[^"]*"([^>]*) d="([^"]*)"\/>/g)].map(([, more = '', d = '']): InkPath => ({
    d, evenOdd: more.includes('evenodd'), opacity: Number(/fill-opacity="([^"]*)"/.exec(more)?.[1] ?? 1)}));
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
