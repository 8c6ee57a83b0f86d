// Written by web/types.py from api/openapi.yaml. Change the description, then run web/types.py.

export type JobKind = 'print' | 'inspection' | 'layout';

export type JobState = 'queued' | 'running' | 'succeeded' | 'failed' | 'cancelling' | 'cancelled';

export type Stage = 'scan' | 'forming' | 'flattening' | 'printing' | 'inspection';

export type Scope = 'submit' | 'read' | 'work' | 'admin';

export type ArtifactName = 'print.png' | 'print.svg' | 'print.pdf' | 'print-dielectric.png' | 'print-dielectric.svg' |
  'print-dielectric.pdf' | 'print-bridges.png' | 'print-bridges.svg' | 'print-bridges.pdf' | 'print-resist.png' |
  'print-resist.svg' | 'print-resist.pdf' | 'print-picture.png' | 'print-picture.svg' | 'print-picture.pdf' |
  'print-reverse.png' | 'print-reverse.svg' | 'print-reverse.pdf' | 'print-reverse-dielectric.png' |
  'print-reverse-dielectric.svg' | 'print-reverse-dielectric.pdf' | 'print-reverse-bridges.png' |
  'print-reverse-bridges.svg' | 'print-reverse-bridges.pdf' | 'print-reverse-resist.png' | 'print-reverse-resist.svg' |
  'print-reverse-resist.pdf' | 'print-reverse-picture.png' | 'print-reverse-picture.svg' | 'print-reverse-picture.pdf' |
  'colours.png' | 'colours.svg' | 'colours.pdf' | 'preview-pattern.png' | 'preview-print.png' | 'preview-without.png' |
  'preview-with.png' | 'preview-views.png' | 'preview-lengths.png' | 'preview-shape.png' | 'preview-area.png' |
  'preview-thickness.png' | 'preview-temperature.png' | 'preview-gap.png' | 'preview-position.png' |
  'preview-colour.png' | 'preview-segments.png' | 'preview-original.png' | 'preview-align.png' | 'preview-findings.png'
  | 'formed.ply' | 'formed.obj' | 'formed.mtl' | 'formed.glb' | 'uv-map.obj' | 'mold.stl' | 'layers.dxf' | 'coils.csv' |
  'array.json' | 'array.nec' | 'array.ts' | 'array-marie.msh' | 'array-marie.json' | 'array.stl' | 'findings.json' |
  'pattern.svg' | 'layout.json' | 'report.json' | 'report.html';

export interface ProblemBody {
  type: string;
  title: string;
  status: number;
  detail?: string;
  what?: string;
  where?: string;
  fix?: string;
  proposals?: ({set: Record<string, Record<string, number | string>>; text: string})[];
}

export interface Input {
  bytes: number;
  sha256: string;
  extension: string;
  format?: string;
}

export interface Artifact {
  name: ArtifactName;
  title: string;
  media_type: string;
  bytes: number;
  sha256: string;
  href: string;
}

export interface Warning {
  stage: Stage;
  code: string;
  severity: 'note' | 'warning' | 'serious';
  what: string;
  place: string;
  figure: {value: number; unit: string; limit: number | null} | null;
  fix: string;
  proposals: ({set: Record<string, Record<string, number | string>>; text: string})[];
  marks: {place_mm: [number, number, number]; size_mm: number}[];
}

export interface Links {
  self: string;
  page: string;
  artifacts: string;
  zip: string;
  log: string;
  cancel: string;
}

export interface ListedJob extends Partial<Estimates> {
  id: string;
  kind: JobKind;
  state: JobState;
  stage: Stage | null;
  progress: number;
  stage_progress: number;
  attempt: number;
  priority: number;
  owner: string;
  reference: string;
  note: string;
  derived_from: string | null;
  version: number;
  created: string;
  started: string | null;
  ended: string | null;
  not_before: string | null;
  serious_warnings: number | null;
  problem: ProblemBody | null;
}

export interface Estimates {
  queue_position: number | null;
  seconds_expected: number | null;
}

export interface LogLine {
  number: number;
  time: string;
  text: string;
}

export interface ReferenceChange {
  time: string;
  owner: string;
  token: string;
  old: string;
  new: string;
  rescan: boolean;
}

export interface JobPage {
  jobs: ListedJob[];
  next: string | null;
}

export interface LogPage {
  lines: LogLine[];
  next: number;
  ended: boolean;
}

export interface Plan {
  kind: JobKind;
  reference: string;
  note: string;
  settings: Settings;
  inputs: Record<string, Input & {format: 'stl' | 'obj' | 'ply' | 'off' | 'glb' | 'svg' | 'dxf' | 'png' | 'jpeg' |
    'csv'}>;
}

export interface Session {
  owner: string;
  token: string;
  scopes: Scope[];
  expires: string | null;
  session_ends: string | null;
}

export interface Profile {
  name: string;
  changed: string;
  default: boolean;
  settings: Settings;
}

export interface TokenInfo {
  id: string;
  owner: string;
  scopes: Scope[];
  created: string;
  expires: string | null;
  revoked: string | null;
}

export interface Service {
  version: string;
  uptime_seconds: number;
  schema: number;
  jobs: {queued: number; running: number; succeeded: number; failed: number; cancelling: number; cancelled: number};
  queue: {length: number; oldest_seconds: number | null};
  workers: ({worker: string; last_seen: string; job: string | null; sandbox: ('namespaces' | 'landlock' | 'seccomp')[] |
    null; lacks: ('namespaces' | 'landlock' | 'seccomp')[] | null})[];
  disk: {total_bytes: number; free_bytes: number; kept_free_bytes: number};
  last_backup: string | null;
}

export type Settings = Record<string, Record<string, unknown>>;

export interface Job extends ListedJob {
  settings: Settings;
  inputs: Record<string, Input>;
  artifacts: Artifact[];
  reference_changes: ReferenceChange[];
  printed_reference: string | null;
  links: Links;
}

// The JSON Schema of the settings, as far as the form uses it.
export interface FieldSchema {
  type?: string;
  title?: string;
  description?: string;
  default?: unknown;
  enum?: string[];
  minimum?: number;
  maximum?: number;
  minItems?: number;
  maxItems?: number;
  items?: FieldSchema;
  oneOf?: FieldSchema[];
  'x-unit'?: string;
}
export interface SettingsSchema {
  properties: Record<string, {title?: string; description?: string; properties: Record<string, FieldSchema>}>;
}

export const ended = (state: JobState): boolean => state === 'succeeded' || state === 'failed' || state === 'cancelled';
