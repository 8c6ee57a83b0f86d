// The result of a print: how it is looked at, its coils, and a drawing that is being moved.
import type {Job} from '../api/types';

// ---- what is looked at; a link restores it ----

export const maps = ['print', 'shape', 'area', 'thickness', 'temperature', 'contact'] as const;
export type MapName = (typeof maps)[number];
export const modes = ['with', 'drawn', 'split', 'side'] as const;
export type Mode = (typeof modes)[number];

export interface ResultState {
  tab: 'part' | 'sheet';
  map: MapName;
  mode: Mode;
  cut: number;        // split: share of the width that is printed as drawn
  isolines: boolean;
  coil: string;       // the selected one, or empty
  camera: string;     // as the view writes it, or empty
}

export const initialResult: ResultState =
  {tab: 'part', map: 'print', mode: 'split', cut: 0.5, isolines: true, coil: '', camera: ''};

const oneOf = <T extends string>(all: readonly T[], value: string | null, other: T): T => all.find((one) => one === value) ?? other;

export function resultOf(query: string): ResultState {
  const given = new URLSearchParams(query), cut = Number(given.get('cut') ?? 50);
  return {
    tab: oneOf(['part', 'sheet'], given.get('tab'), 'part'),
    map: oneOf(maps, given.get('map'), 'print'),
    mode: oneOf(modes, given.get('mode'), 'split'),
    cut: cut >= 0 && cut <= 100 ? cut / 100 : 0.5,
    isolines: given.get('lines') !== 'off',
    coil: given.get('coil') ?? '',
    camera: given.get('view') ?? '',
  };
}

// What differs from the beginning.
export function queryOf(state: ResultState): string {
  const given = new URLSearchParams();
  if (state.tab !== 'part') given.set('tab', state.tab);
  if (state.map !== 'print') given.set('map', state.map);
  if (state.mode !== 'split') given.set('mode', state.mode);
  else if (state.cut !== 0.5) given.set('cut', String(Math.round(100 * state.cut)));
  if (!state.isolines) given.set('lines', 'off');
  if (state.coil) given.set('coil', state.coil);
  if (state.camera) given.set('view', state.camera);
  return given.toString();
}

// ---- report.json, as far as the result needs it (docs/reference/report.md) ----

interface Spread {
  mean: number;
  p95: number;
}
interface Pair {
  coils: [string, string];
  k: number;
}
interface CoilSummary {
  on_head: number;
  mean_circularity: number | null;
  mean_area_error: number | null;
  strongest_pair?: Pair | null;
}
interface Way {
  anisotropy: Spread;
  area_ratio: Spread;
  coils?: CoilSummary;
}
interface CoilSide {
  on_head: boolean;
  centre_mm: [number, number, number];
  diameter_mm: number;
  circularity?: number | null;
  shape_error: number;
  area_mm2: number;
  area_error: number;
  worst_stretch: number;
  inductance_nh: number;
}
interface PairSide {
  k: number | null;
}
export interface PrintReport {
  label?: string;
  scan?: {mirrored: boolean};
  thickness: {initial_mm: number; least_mm: number; least_ratio: number};
  flattening: {top_rest_mm: [number, number]};
  print: {inked_face: string; mirrored: boolean};
  figures: {with: Way; without: Way};
  coils?: {id: string; drawn_diameter_mm: number; with?: CoilSide | null; without?: CoilSide | null}[];
  pairs?: {coils: [string, string]; with?: PairSide | null}[];
}

// ---- the table of coils ----

export interface Coil {
  id: string;
  onHead: boolean;
  centre: [number, number, number];  // mm, on the formed sheet
  drawn: number;                     // diameter, mm
  diameter: number;
  round: number;                     // share out of round; of its drawn shape where it is not drawn as a circle
  roundWithout: number | null;
  area: number;                      // mm2
  areaError: number;
  stretch: number;                   // largest, as a share
  inductance: number;                // nH
  neighbours: {id: string; k: number}[];  // strongest first
  coupling: number;                  // the strongest, without its sign
}
export const columns = ['id', 'diameter', 'round', 'areaError', 'stretch', 'inductance', 'coupling'] as const;
export type Column = (typeof columns)[number];

export function coilsOf(report: PrintReport): Coil[] {
  const near = new Map<string, {id: string; k: number}[]>();
  for (const {coils: [a, b], with: made} of report.pairs ?? []) {
    if (typeof made?.k !== 'number') continue;
    near.set(a, [...near.get(a) ?? [], {id: b, k: made.k}]);
    near.set(b, [...near.get(b) ?? [], {id: a, k: made.k}]);
  }
  return (report.coils ?? []).flatMap(({id, drawn_diameter_mm: drawn, with: made, without}) => {
    if (!made) return [];
    const neighbours = (near.get(id) ?? []).sort((a, b) => Math.abs(b.k) - Math.abs(a.k));
    return [{
      id, drawn, neighbours, onHead: made.on_head, centre: made.centre_mm, diameter: made.diameter_mm,
      round: made.circularity ?? made.shape_error, roundWithout: without ? without.circularity ?? without.shape_error : null,
      area: made.area_mm2, areaError: made.area_error, stretch: made.worst_stretch - 1, inductance: made.inductance_nh,
      coupling: Math.abs(neighbours[0]?.k ?? 0),
    }];
  });
}

// The worst first, or the other way round. Coils that do not lie wholly on the head are not as drawn anyway: they come last.
export function sorted(coils: readonly Coil[], by: Column, down: boolean): Coil[] {
  const names = new Intl.Collator('en', {numeric: true});
  const size = (coil: Coil): number =>
    by === 'id' ? 0 : by === 'diameter' ? Math.abs(coil.diameter / coil.drawn - 1) : Math.abs(coil[by]);
  return [...coils].sort((a, b) =>
    Number(b.onHead) - Number(a.onHead) ||
    (down ? 1 : -1) * (by === 'id' ? names.compare(b.id, a.id) : size(b) - size(a)) || names.compare(a.id, b.id));
}

// ---- centre lines of the print ----

export type Line = [number, number][];  // (s, t) mm

// The centre lines of each element in print.svg, where x = s and y = -t. Only what Vacuform writes there is understood:
// M, L, C and Z with absolute numbers. A mirrored print is turned back.
export function centreLines(svg: string, mirrored: boolean): Map<string, Line[]> {
  const lines = new Map<string, Line[]>();
  for (const group of svg.split('<g id="').slice(1)) {
    const id = unescaped(group.slice(0, group.indexOf('"')));
    for (const [path] of group.matchAll(/<path[^>]*class="centreline"[^>]*>/g)) {
      const d = / d="([^"]*)"/.exec(path)?.[1] ?? '';
      lines.set(id, [...lines.get(id) ?? [], ...pathLines(d, mirrored ? -1 : 1)]);
    }
  }
  return lines;
}
const entities: Record<string, string> = {amp: '&', lt: '<', gt: '>', quot: '"', apos: "'", '#39': "'"};
const unescaped = (text: string): string => text.replace(/&(amp|lt|gt|quot|apos|#39);/g, (_, name: string) => entities[name] ?? '');

function pathLines(d: string, side: 1 | -1): Line[] {
  const lines: Line[] = [];
  let line: Line = [];
  for (const [, command, text = ''] of d.matchAll(/([MLCZ])([^MLCZ]*)/gi)) {
    const n = (text.match(/-?[\d.]+(?:e-?\d+)?/g) ?? []).map(Number);
    const at = (i: number): [number, number] => [side * (n[i] ?? 0), -(n[i + 1] ?? 0)];
    if (command === 'M') lines.push(line = [at(0)]);
    else if (command === 'L') for (let i = 0; i + 1 < n.length; i += 2) line.push(at(i));
    else if (command === 'C')
      for (let i = 0; i + 5 < n.length; i += 6) {
        const a = line.at(-1) ?? at(0), b = at(i), c = at(i + 2), e = at(i + 4);
        for (const f of [0.25, 0.5, 0.75, 1]) {
          const g = 1 - f, mix = (k: 0 | 1): number => g * g * g * a[k] + 3 * g * g * f * b[k] + 3 * g * f * f * c[k] + f * f * f * e[k];
          line.push([mix(0), mix(1)]);
        }
      }
    else if (line[0]) line.push(line[0]);
  }
  return lines;
}

export function encloses(lines: readonly Line[], [s, t]: readonly [number, number]): boolean {
  let inside = false;
  for (const line of lines)
    line.forEach(([x1, y1], i) => {
      const [x2, y2] = line[(i + 1) % line.length]!;
      if (y1 > t !== y2 > t && s < x1 + (t - y1) / (y2 - y1) * (x2 - x1)) inside = !inside;
    });
  return inside;
}

// ---- a drawing that is being moved ----

export interface Placement {
  x: number;       // pattern.offset_mm
  y: number;
  turn: number;    // pattern.rotate_deg
  scale: number;   // pattern.scale
}
export interface Moves {
  steps: readonly Placement[];  // the first is that of the job
  at: number;
}

export function placementOf(job: Pick<Job, 'settings'>): Placement {
  const pattern = job.settings['pattern'] ?? {}, [x = 0, y = 0] = (pattern['offset_mm'] ?? []) as number[];
  return {x, y, turn: Number(pattern['rotate_deg'] ?? 0), scale: Number(pattern['scale'] ?? 1)};
}
export const begun = (job: Pick<Job, 'settings'>): Moves => ({steps: [placementOf(job)], at: 0});
export const placed = (moves: Moves): Placement => moves.steps[moves.at]!;
const same = (a: Placement, b: Placement): boolean => a.x === b.x && a.y === b.y && a.turn === b.turn && a.scale === b.scale;
export const isMoved = (moves: Moves): boolean => !same(placed(moves), moves.steps[0]!);
// What was undone can no longer be redone.
export const move = (moves: Moves, to: Placement): Moves =>
  same(placed(moves), to) ? moves : {steps: [...moves.steps.slice(0, moves.at + 1), to], at: moves.at + 1};
export const undo = (moves: Moves): Moves => ({...moves, at: Math.max(0, moves.at - 1)});
export const redo = (moves: Moves): Moves => ({...moves, at: Math.min(moves.steps.length - 1, moves.at + 1)});

type Matrix = readonly [number, number, number, number, number, number, number, number, number];
const times = (a: Matrix, b: Matrix): Matrix =>
  [0, 3, 6].flatMap((r) => [0, 1, 2].map((c) => a[r]! * b[c]! + a[r + 1]! * b[c + 3]! + a[r + 2]! * b[c + 6]!)) as unknown as Matrix;
function onChart({x, y, turn, scale}: Placement): Matrix {
  const c = scale * Math.cos(turn * Math.PI / 180), s = scale * Math.sin(turn * Math.PI / 180);
  return [c, -s, x, s, c, y, 0, 0, 1];
}
function offChart({x, y, turn, scale}: Placement): Matrix {
  const c = Math.cos(turn * Math.PI / 180) / scale, s = Math.sin(turn * Math.PI / 180) / scale;
  return [c, s, -(c * x + s * y), -s, c, s * x - c * y, 0, 0, 1];
}

// From the pattern coordinates of the job to the picture of its drawing, so that it shows the drawing where `to` puts it.
// That picture has the drawing on the flat sheet at the place of the job, its origin at `top`. `size` and `origin`: where
// the sheet lies on the picture (scene/sheet.ts).
export function previewPlace(job: Placement, to: Placement, top: readonly [number, number], size: readonly [number, number],
                             origin: readonly [number, number]): Matrix {
  const picture: Matrix = [1 / size[0], 0, top[0] / size[0] + origin[0], 0, 1 / size[1], top[1] / size[1] + origin[1], 0, 0, 1];
  return times(times(picture, onChart(job)), times(offChart(to), onChart(job)));
}
