// The result of a print: how it is looked at, its coils, and a drawing that is being moved.
import type {Job} from '../api/types';
import type {Circuits, Couplings} from './array';

// ---- what is looked at; a link restores it ----

// What the sheet shows: the print, where it touches the mold, or a heat map of the report by its id.
export type MapName = string;
export const modes = ['with', 'drawn', 'split', 'side'] as const;
export type Mode = (typeof modes)[number];

export const tabs = ['part', 'sheet', 'build'] as const;
export type Tab = (typeof tabs)[number];

export interface ResultState {
  tab: Tab;
  map: MapName;
  mode: Mode;
  cut: number;        // split: share of the width that is printed as drawn
  isolines: boolean;
  coil: string;       // the selected one, or empty
  other: string;      // the second one of a selected pair, or empty
  hidden: readonly string[];  // the layers of the print that are not shown, by their names
  camera: string;     // as the view writes it, or empty
}

export const initialResult: ResultState =
  {tab: 'part', map: 'print', mode: 'split', cut: 0.5, isolines: true, coil: '', other: '', hidden: [], camera: ''};

const oneOf = <T extends string>(all: readonly T[], value: string | null, other: T): T => all.find((one) => one === value) ?? other;

export function resultOf(query: string): ResultState {
  const given = new URLSearchParams(query), cut = Number(given.get('cut') ?? 50), coil = given.get('coil') ?? '';
  return {
    tab: oneOf(tabs, given.get('tab'), 'part'),
    map: given.get('map') ?? 'print',
    mode: oneOf(modes, given.get('mode'), 'split'),
    cut: cut >= 0 && cut <= 100 ? cut / 100 : 0.5,
    isolines: given.get('lines') !== 'off',
    coil,
    other: coil && given.get('and') || '',
    hidden: (given.get('hide') ?? '').split('_').filter((name) => /^print(-[a-z]+)*$/.test(name)).sort(),
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
  if (state.other) given.set('and', state.other);
  if (state.hidden.length > 0) given.set('hide', state.hidden.join('_'));
  if (state.camera) given.set('view', state.camera);
  return given.toString();
}

export const selected = ({coil, other}: Pick<ResultState, 'coil' | 'other'>): string[] => [coil, other].filter(Boolean);

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
  shape: Spread;
  area: Spread;
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
export interface HeatMap {
  id: string;         // of preview-ID.png and of the attribute _ID of formed.glb
  title: string;
  unit: string;
  low: number;        // the range of the colours
  high: number;
  step: number;       // between isolines and between the marks of the legend
  limit: number | null;  // the tolerance
  over_ink: boolean;  // whether the ink may be shown with it
  colours: string[];  // evenly over the range
}
export interface PrintReport {
  maps: HeatMap[];
  label?: string;
  scan?: {mirrored: boolean};
  thickness: {initial_mm: number; least_mm: number; least_ratio: number};
  flattening: {top_rest_mm: [number, number]};
  print: {inked_face: string; mirrored: boolean};
  figures: {with: Way; without: Way};
  coils?: {id: string; drawn_diameter_mm: number; with?: CoilSide | null; without?: CoilSide | null}[];
  pairs?: {coils: [string, string]; with?: PairSide | null}[];
  couplings?: Couplings | null;
  circuits?: Circuits | null;
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

export interface Compared {
  count: number;     // of coils that lie wholly on the head with both prints
  same: boolean;     // these are all coils on the head with the print that was made
  round: [made: number, drawn: number] | null;     // mean shares out of round, of those drawn as circles
  area: [made: number, drawn: number];             // mean shares of |...|
}
// What can be compared between the print that was made and the drawing printed as it is: the same coils.
export function compared(report: PrintReport): Compared | null {
  const made = (report.coils ?? []).filter((coil) => coil.with?.on_head), both = made.flatMap(({with: a, without: b}) => a && b?.on_head ? [[a, b] as const] : []);
  if (both.length === 0) return null;
  const mean = (pairs: readonly (readonly [number, number])[]): [number, number] =>
    [0, 1].map((k) => pairs.reduce((sum, pair) => sum + Math.abs(pair[k as 0 | 1]), 0) / pairs.length) as [number, number];
  const circles = both.flatMap(([a, b]) => typeof a.circularity === 'number' && typeof b.circularity === 'number' ? [[a.circularity, b.circularity] as const] : []);
  return {count: both.length, same: both.length === made.length, round: circles.length > 0 ? mean(circles) : null,
          area: mean(both.map(([a, b]) => [a.area_error, b.area_error] as const))};
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
// M, L, C and Z with absolute numbers. The coordinates of a mirrored print are those before it is mirrored.
export function centreLines(svg: string): Map<string, Line[]> {
  const lines = new Map<string, Line[]>();
  for (const group of svg.split('<g id="').slice(1)) {
    const id = unescaped(group.slice(0, group.indexOf('"')));
    for (const [path] of group.matchAll(/<path[^>]*class="centreline"[^>]*>/g)) {
      const d = / d="([^"]*)"/.exec(path)?.[1] ?? '';
      lines.set(id, [...lines.get(id) ?? [], ...pathLines(d)]);
    }
  }
  return lines;
}
const entities: Record<string, string> = {amp: '&', lt: '<', gt: '>', quot: '"', apos: "'", '#39': "'"};
const unescaped = (text: string): string => text.replace(/&(amp|lt|gt|quot|apos|#39);/g, (_, name: string) => entities[name] ?? '');

function pathLines(d: string): Line[] {
  const lines: Line[] = [];
  let line: Line = [];
  for (const [, command, text = ''] of d.matchAll(/([MLCZ])([^MLCZ]*)/gi)) {
    const n = (text.match(/-?[\d.]+(?:e-?\d+)?/g) ?? []).map(Number);
    const at = (i: number): [number, number] => [n[i] ?? 0, -(n[i + 1] ?? 0)];
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

export type Flat = readonly [number, number];
export type Row = readonly [u: number, v: number, x: number, y: number, z: number];  // of pattern.points

// Where a drawing lies on the chart, as worker/placement/alignment.hpp has it: turned, scaled, then shifted.
export interface Placement {
  x: number;       // mm
  y: number;
  turn: number;    // degrees, counter-clockwise
  scale: number;
}
// The same four as settings (pattern.offset_mm, rotate_deg, scale), which come on top of the points.
export interface Wanted extends Placement {
  points: readonly Row[];  // pattern.points
}
export interface Moves {
  steps: readonly Wanted[];  // the first is that of the job
  at: number;
}

export function wantedOf(job: Pick<Job, 'settings'>): Wanted {
  const pattern = job.settings['pattern'] ?? {}, [x = 0, y = 0] = (pattern['offset_mm'] ?? []) as number[];
  return {x, y, turn: Number(pattern['rotate_deg'] ?? 0), scale: Number(pattern['scale'] ?? 1), points: (pattern['points'] ?? []) as Row[]};
}
export const patternOf = ({x, y, turn, scale, points}: Wanted): Record<string, unknown> => ({offset_mm: [x, y], rotate_deg: turn, scale, points});
export const initialMoves = (job: Pick<Job, 'settings'>): Moves => ({steps: [wantedOf(job)], at: 0});
export const placed = (moves: Moves): Wanted => moves.steps[moves.at]!;
export const same = (a: Wanted, b: Wanted): boolean => JSON.stringify(patternOf(a)) === JSON.stringify(patternOf(b));
export const isMoved = (moves: Moves): boolean => !same(placed(moves), moves.steps[0]!);
// What was undone can no longer be redone.
export const move = (moves: Moves, to: Wanted): Moves =>
  same(placed(moves), to) ? moves : {steps: [...moves.steps.slice(0, moves.at + 1), to], at: moves.at + 1};
export const undo = (moves: Moves): Moves => ({...moves, at: Math.max(0, moves.at - 1)});
export const redo = (moves: Moves): Moves => ({...moves, at: Math.min(moves.steps.length - 1, moves.at + 1)});

// As complex numbers.
const plus = (a: Flat, b: Flat, times = 1): [number, number] => [a[0] + times * b[0], a[1] + times * b[1]];
const times = (a: Flat, b: Flat): [number, number] => [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
const turned = (degrees: number, scale: number): [number, number] => [scale * Math.cos(degrees * Math.PI / 180), scale * Math.sin(degrees * Math.PI / 180)];
export const toChart = ({x, y, turn, scale}: Placement, drawn: Flat): [number, number] => plus(times(turned(turn, scale), drawn), [x, y]);
export const toDrawing = ({x, y, turn, scale}: Placement, chart: Flat): [number, number] => times(turned(-turn, 1 / scale), plus(chart, [x, y], -1));

// Where the server lays a drawing; `targets`: the points of the mold on the chart. One point shifts the drawing. Of two,
// the first is met and the other one gives the direction; three and more are met by least squares. Points do not scale.
// null: they give no direction.
export function laid({x, y, turn, scale, points}: Wanted, targets: readonly Flat[]): Placement | null {
  if (points.length === 0) return {x, y, turn, scale};
  const drawn = points.map(([u, v]): Flat => [u, v]);
  const [from, to] = [drawn, targets].map((all) => all.length === 2 ? all[0]! : all.reduce((sum, one) => plus(sum, one, 1 / all.length), [0, 0] as Flat)) as [Flat, Flat];
  const sum = drawn.reduce((all, point, i) => {
    const [u, v] = plus(point, from, -1);
    return plus(all, times([u, -v], plus(targets[i]!, to, -1)));
  }, [0, 0] as Flat);
  if (points.length > 1 && Math.hypot(...sum) < 1e-6) return null;
  const lies = {x: 0, y: 0, turn: turn + Math.atan2(sum[1], sum[0]) * 180 / Math.PI, scale}, shift = plus(plus(to, toChart(lies, from), -1), [x, y]);
  return {...lies, x: shift[0], y: shift[1]};
}

// How the drawing of a job lies on the chart, which is turned to the sheet by least squares (worker/flattening/flatten.cpp).
// `origin`: the point of the drawing at the chart's origin.
export function lying({drawn, sheet}: {drawn: readonly Flat[]; sheet: readonly Flat[]}, origin: Flat, scale: number): Placement | null {
  const point = ([u, v]: Flat): Row => [u, v, 0, 0, 0], plain = {x: 0, y: 0, turn: 0, scale};
  return laid({...plain, turn: laid({...plain, points: drawn.map(point)}, sheet)?.turn ?? 0, points: [point(origin)]}, [[0, 0]]);
}

// Hundredths are enough; never -0.
const rounded = (value: number): number => Math.round(100 * value) / 100 + 0;
export const rowOf = (drawn: Flat, mold: readonly [number, number, number]): Row => [...drawn, ...mold].map(rounded) as unknown as Row;

// With other points, which alone say where the drawing lies: offset and rotation on top of them begin at 0. A single
// point keeps the rotation that the drawing has, and without points it stays where it lies (null: nobody knows).
export function withPoints(now: Wanted, points: readonly Row[], lies: Placement | null): Wanted {
  if (!lies) return {...now, points};
  const [x, y] = points.length > 0 ? [0, 0] : [lies.x, lies.y], turn = points.length > 1 ? 0 : (lies.turn + 540) % 360 - 180;
  return {x: rounded(x), y: rounded(y), turn: rounded(turn), scale: now.scale, points};
}

// From the pattern coordinates of the job to the picture of its drawing, so that it shows the drawing where `to` puts it:
// the rows of a 3 x 3 matrix. That picture has the drawing on the flat sheet at the place of the job, its origin at `top`.
// `size` and `origin`: where the sheet lies on the picture (scene/sheet.ts).
export function previewPlace(job: Placement, to: Placement, top: Flat, size: Flat, origin: Flat): readonly number[] {
  const [o, a, b] = ([[0, 0], [1, 0], [0, 1]] as const).map((point) => {
    const [s, t] = plus(toChart(job, toDrawing(to, toChart(job, point))), top);
    return [s / size[0] + origin[0], t / size[1] + origin[1]];
  }) as [number[], number[], number[]];
  return [...[0, 1].flatMap((k) => [a[k]! - o[k]!, b[k]! - o[k]!, o[k]!]), 0, 0, 1];
}
