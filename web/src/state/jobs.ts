// Jobs: the list, the one that is shown, and what can be said of them without asking the server.
import type {JobQuery} from '../api/client';
import type {Job, JobKind, ListedJob, LogLine, Settings, SettingsSchema, Stage} from '../api/types';
import {fieldOf, sameValue, settingOf} from './draft';

export interface JobList {
  query: string;  // of the address that it answers
  jobs: readonly ListedJob[];
  next: string | null;
}

export interface JobsState {
  list: JobList | null;
  listProblem: unknown;  // why there is no list, or null
  chosen: readonly string[];  // ids of the jobs to compare, at most two
  job: Job | null;
  jobProblem: unknown;
  log: readonly LogLine[];
}

export const initialJobs: JobsState =
  {list: null, listProblem: null, chosen: [], job: null, jobProblem: null, log: []};

// ---- the list ----

const pageSize = 25;
const filters = ['state', 'kind', 'owner', 'text', 'from', 'to'] as const;
export type FilterName = (typeof filters)[number];
export const activeStates = 'queued,running,cancelling';

// A day of the address ("2026-11-23") as the moment at which it begins here, or `days` later.
function dayBegins(day: string | null, days = 0): string {
  const [year, month, date] = /^(\d{4})-(\d\d)-(\d\d)$/.exec(day ?? '')?.slice(1).map(Number) ?? [];
  if (year === undefined || month === undefined || date === undefined) return '';
  const begins = new Date(year, month - 1, date + days);
  return Number.isNaN(begins.getTime()) ? '' : begins.toISOString();
}

// What the server is asked for by the query of an address. The last cursor is that of the page; those before it lead
// back to newer pages.
export function listQuery(query: string): JobQuery {
  const given = new URLSearchParams(query);
  return {
    limit: pageSize,
    cursor: given.getAll('cursor').pop() ?? '',
    state: given.get('state') ?? '',
    kind: given.get('kind') ?? '',
    owner: given.get('owner') ?? '',
    text: given.get('text')?.trim() ?? '',
    created_after: dayBegins(given.get('from')),
    created_before: dayBegins(given.get('to'), 1),
  };
}

export const filterOf = (query: string, name: FilterName): string => new URLSearchParams(query).get(name) ?? '';
export const isFiltered = (query: string): boolean => filters.some((name) => filterOf(query, name) !== '');

// Another filter begins at the first page.
export function withFilter(query: string, name: FilterName, value: string): string {
  const given = new URLSearchParams(query);
  given.delete('cursor');
  if (value.trim()) given.set(name, value.trim());
  else given.delete(name);
  return given.toString();
}

export function olderPage(query: string, cursor: string): string {
  const given = new URLSearchParams(query);
  given.append('cursor', cursor);
  return given.toString();
}

// The page before, or null on the first.
export function newerPage(query: string): string | null {
  const given = new URLSearchParams(query);
  const cursors = given.getAll('cursor');
  if (cursors.length === 0) return null;
  given.delete('cursor');
  for (const cursor of cursors.slice(0, -1)) given.append('cursor', cursor);
  return given.toString();
}

// Choosing a third job takes the place of the first.
export const choose = (chosen: readonly string[], id: string, on: boolean): readonly string[] =>
  on ? [...chosen.filter((one) => one !== id), id].slice(-2) : chosen.filter((one) => one !== id);

// ---- one job ----

export const stagesOf = (kind: JobKind): readonly Stage[] =>
  kind === 'inspection' ? ['scan', 'inspection']
  : kind === 'layout' ? ['scan', 'forming', 'flattening', 'printing']
  : ['scan', 'forming', 'flattening', 'printing', 'inspection'];

// Seconds until a running job is done, from past jobs like it; null where nothing is known.
export function secondsLeft(job: Pick<ListedJob, 'state' | 'progress' | 'seconds_expected'>): number | null {
  if (job.state !== 'running' || !job.seconds_expected) return null;
  return job.seconds_expected * (1 - job.progress);
}

// Which quarter of the whole is done: spoken when it changes.
export const quarter = (progress: number): number => Math.floor(progress * 4 + 1e-9);

export interface Setting {
  id: string;  // group.key
  value: unknown;
  changed: boolean;  // from its default
}

// All settings of a job, those that differ from their defaults first.
export function settingsOf(settings: Settings, schema: SettingsSchema): Setting[] {
  const all = idsIn(settings).map((id): Setting => {
    const value = settingOf(settings, id), field = fieldOf(schema, id);
    return {id, value, changed: field !== undefined && !sameValue(value, field.default)};
  });
  return [...all.filter((one) => one.changed), ...all.filter((one) => !one.changed)];
}

const idsIn = (settings: Settings): string[] =>
  Object.entries(settings).flatMap(([group, members]) => Object.keys(members).map((key) => `${group}.${key}`));

// Ids of the settings in which two jobs differ.
export const differences = (a: Settings, b: Settings): string[] =>
  [...new Set([...idsIn(a), ...idsIn(b)])].filter((id) => !sameValue(settingOf(a, id), settingOf(b, id)));

// ---- what a worker found ----

export type Severity = 'note' | 'warning' | 'serious';

export interface Warning {
  stage: string;
  code: string;
  severity: Severity;
  what: string;
  place: string;
  figure: {value: number; unit: string; limit: number} | null;
  fix: string;
  marks: readonly {place_mm: readonly number[]; size_mm: number}[];
}

const order: readonly Severity[] = ['serious', 'warning', 'note'];

export const bySeverity = (warnings: readonly Warning[]): Warning[] =>
  [...warnings].sort((a, b) => order.indexOf(a.severity) - order.indexOf(b.severity));

// The parts of report.json and findings.json that the pages use.
export interface Report {
  label?: string;
  scan: {format: string; triangles_read: number; unit: string; unit_guessed: boolean; up: string; up_guessed: boolean;
         front: string; front_from_format: boolean; front_assumed: boolean; mirrored: boolean; holes_closed: number; holes_capped: number;
         rebuilt: boolean; size_mm: readonly number[]; trim_mm: number | null};
  mold: {size_mm: readonly number[]; undercut_count: number};
  print?: {inked_face: string; mirrored: boolean; ruler_mm?: number | null};
  warnings: readonly Warning[];
  problem?: {code: string; what: string; where: string; fix: string; place_mm?: readonly number[] | null} | null;  // findings.json
  [section: string]: unknown;
}

// How a mold stands in the machine that is placed and cut already, for scene/scan.ts. `low`, `high`: its box, mm.
export function standingOf({low, high}: Record<'low' | 'high', readonly [number, number, number]>, {sheet = {}, machine = {}}: Settings) {
  const pair = (a: unknown, b: unknown): [number, number] => [Number(a), Number(b)], round = machine['window'] === 'circle';
  const shift: [number, number, number] = [0, 0, 0], width = machine['window_width_mm'];
  return {
    placed: {turn: [1, 0, 0, 0, 1, 0, 0, 0, 1], shift, size: shift.map((_, k) => high[k]! - low[k]!) as typeof shift, height: high[2], top: pair(0, 0),
             half: pair(Math.max(-low[0], high[0]), Math.max(-low[1], high[1]))},
    plug: low[2], outline: false,
    frame: {sheet: pair(sheet['width_mm'], sheet['height_mm']), window: pair(width, round ? width : machine['window_height_mm']), round,
            height: Number(machine['drape_height_mm'])},
  };
}

// The number at a path such as "figures.with.coils.mean_circularity"; null where the report has none.
export function figureAt(report: unknown, path: string): number | null {
  let value: unknown = report;
  for (const name of path.split('.'))
    value = typeof value === 'object' && value !== null ? (value as Record<string, unknown>)[name] : undefined;
  return typeof value === 'number' ? value : null;
}
