// What the API sends, as api/openapi.yaml describes it.

export type JobKind = 'print' | 'inspection' | 'layout';
export type JobState = 'queued' | 'running' | 'succeeded' | 'failed' | 'cancelling' | 'cancelled';
export type Stage = 'scan' | 'forming' | 'flattening' | 'printing' | 'inspection';
export type Scope = 'submit' | 'read' | 'work' | 'admin';

export interface ProblemBody {
  type: string;
  title: string;
  status: number;
  detail?: string;
  what?: string;
  where?: string;
  fix?: string;
}

export interface ListedJob {
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
  queue_position?: number | null;
  seconds_expected?: number | null;
  problem: ProblemBody | null;
}

export interface Artifact {
  name: string;
  title: string;
  media_type: string;
  bytes: number;
  sha256: string;
  href: string;
}

export interface Input {
  bytes: number;
  sha256: string;
  extension: string;
  format?: string;
}

export type Settings = Record<string, Record<string, unknown>>;

export interface Job extends ListedJob {
  settings: Settings;
  inputs: Record<string, Input>;
  artifacts: Artifact[];
  links: Record<string, string>;
}

export interface JobPage {
  jobs: ListedJob[];
  next: string | null;
}

export interface LogLine {
  number: number;
  time: string;
  text: string;
}

export interface Plan {
  kind: JobKind;
  settings: Settings;
  inputs: Record<string, Input>;
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
  settings: Settings;
  changed: string;
}

export interface TokenInfo {
  id: string;
  owner: string;
  scopes: Scope[];
  created: string;
  expires: string | null;
  revoked: string | null;
}

export interface Worker {
  worker: string;
  last_seen: string;
  job: string | null;
  sandbox: string[] | null;  // null: not known
  lacks: string[] | null;
}

export interface Service {
  version: string;
  uptime_seconds: number;
  schema: number;
  jobs: Record<string, number>;
  queue: {length: number; oldest_seconds: number | null};
  workers: Worker[];
  disk: {total_bytes: number; free_bytes: number; kept_free_bytes: number};
  last_backup: string | null;
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
  items?: FieldSchema;
  maxItems?: number;
  oneOf?: FieldSchema[];
  'x-unit'?: string;
}
export interface SettingsSchema {
  properties: Record<string, {title?: string; description?: string; properties: Record<string, FieldSchema>}>;
}

export const ended = (state: JobState): boolean => state === 'succeeded' || state === 'failed' || state === 'cancelled';
