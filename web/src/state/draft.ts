// The print that is being prepared: pure functions over one value. It outlives a reload of the page in the storage of the tab,
// without any byte of a scan.
import type {Transfer} from '../api/upload';
import type {Problem} from '../api/client';
import type {FieldSchema, Input, JobKind, Plan, ProblemBody, Profile, Settings, SettingsSchema} from '../api/types';

// What this page may send as files.
export type SentInput = 'scan' | 'pattern' | 'icc';

// A file that this page sends to the server, or has sent.
export interface SentFile {
  upload: string;   // its id; empty before the server has given one
  whole: boolean;   // the server has all of it
  name: string;     // stays in this tab
  bytes: number;
  mark: string;     // tells whether a chosen file is the same
}

export interface Pattern extends SentFile {
  kind: 'svg' | 'picture' | 'other';  // other: only the service reads it
  width: number | null;   // mm, as the file says
  height: number | null;
  aspect: number | null;
  px?: [number, number];  // and in pixels, where pattern.dpi decides
  dpi?: number;           // of the program that wrote the file
  program?: string;
  layout: string;         // the job that made it; empty for a drawing of the person
  offHead?: number;       // coils of that layout that do not lie wholly on the head
}

// What undo goes back and forth over.
export interface Form {
  settings: Settings;     // what differs from the defaults
  profile: string;        // chosen last; empty for none
  reference: string;
  rescan: boolean;        // the scan is another one of the patient who has the reference, as the person confirms
  note: string;
  pattern: Pattern | null;
  icc: SentFile | null;   // the ICC profile of the printer
}

// The job that this print starts from.
export interface Origin {
  job: string;
  kind: JobKind;
  scan: Input;
  pattern: Input | null;
  icc: Input | null;
  settings: Settings;     // what differs from the defaults
}

// What the page found out about the chosen scan.
export interface ScanFacts {
  plausible: boolean;     // its size is one of a head
  mirrored: boolean;      // it may be a mirror image
  upGuessed: boolean;     // nothing in the file says which axis points up
  wide: boolean;          // it does not fit through the window of the clamp frame
}

export interface Draft {
  tab: string;
  form: Form;
  scan: SentFile | null;
  facts: ScanFacts | null;
  from: Origin | null;
  inspection: {job: string; scan: string} | null;  // and the settings of the scan that it was made with
  layout: string;                                  // a running job that makes a pattern
  accepted: string[];                              // doubts that the person has answered
  attempt: {key: string; content: string} | null;  // the start that may have reached the server
  dropped: string;                                 // the reference that went with the scan before this one
}

export interface DraftState extends Draft {
  past: Form[];
  future: Form[];
  faults: Record<string, string>;          // settings whose text cannot be used, by group.key
  transfers: Record<SentInput, Transfer | null>;
  plan: Plan | null;                       // the server's answer to what the form says now
  problem: ProblemBody | null;             // what it finds wrong instead
  checking: boolean;
  found: {codes: string[]; fits: boolean} | null;  // by the inspection of the scan
  schema: SettingsSchema | null;           // null before the server has sent it
  profiles: Profile[] | null;
  unread: Problem | null;                  // why it could not
}

export const emptyForm: Form = {settings: {}, profile: '', reference: '', rescan: false, note: '', pattern: null, icc: null};

export function emptyDraft(tab: string): DraftState {
  return {
    tab, form: emptyForm, scan: null, facts: null, from: null, inspection: null, layout: '', accepted: [], attempt: null, dropped: '',
    past: [], future: [], faults: {}, transfers: {scan: null, pattern: null, icc: null}, plan: null, problem: null, checking: false, found: null,
    schema: null, profiles: null, unread: null};
}

const deepest = 100;  // steps of undo

export function changed(draft: DraftState, change: Partial<Form>): Partial<DraftState> {
  const form = {...draft.form, ...change};
  if (form.reference !== draft.form.reference && !change.rescan) form.rescan = false;
  return JSON.stringify(form) === JSON.stringify(draft.form)
    ? {} : {form, past: [...draft.past, draft.form].slice(-deepest), future: []};
}

// With another scan, the head may be another one: what names the former head goes, also from what undo would bring back.
export function withoutReference(draft: DraftState): Partial<DraftState> {
  const bare = (form: Form): Form => ({...form, reference: '', rescan: false, note: ''});
  return {form: bare(draft.form), past: draft.past.map(bare), future: draft.future.map(bare), dropped: draft.form.reference || draft.dropped};
}

export function undone(draft: DraftState): Partial<DraftState> {
  const form = draft.past.at(-1);
  return form ? {form, past: draft.past.slice(0, -1), future: [draft.form, ...draft.future], faults: {}} : {};
}

export function redone(draft: DraftState): Partial<DraftState> {
  const form = draft.future[0];
  return form ? {form, past: [...draft.past, draft.form], future: draft.future.slice(1), faults: {}} : {};
}

// Settings

export const sameValue = (a: unknown, b: unknown): boolean => JSON.stringify(a) === JSON.stringify(b);
export const settingOf = (settings: Settings, id: string): unknown => {
  const [group = '', key = ''] = id.split('.');
  return settings[group]?.[key];
};
export const fieldOf = (schema: SettingsSchema, id: string): FieldSchema | undefined => {
  const [group = '', key = ''] = id.split('.');
  return schema.properties[group]?.properties[key];
};
export const valueOf = (schema: SettingsSchema, settings: Settings, id: string): unknown =>
  settingOf(settings, id) ?? fieldOf(schema, id)?.default;
export const idsOf = (schema: SettingsSchema): string[] =>
  Object.entries(schema.properties).flatMap(([group, {properties}]) => Object.keys(properties).map((key) => `${group}.${key}`));

// Without a value, the default.
export function withSetting(settings: Settings, id: string, value: unknown): Settings {
  const [group = '', key = ''] = id.split('.');
  const {[key]: _, ...rest} = settings[group] ?? {};
  const members = value === undefined ? rest : {...rest, [key]: value};
  const {[group]: __, ...others} = settings;
  return Object.keys(members).length > 0 ? {...others, [group]: members} : others;
}

export function withSettings(settings: Settings, changes: Settings, schema: SettingsSchema | null): Settings {
  for (const [group, members] of Object.entries(changes))
    for (const [key, value] of Object.entries(members)) {
      const id = `${group}.${key}`;
      if (schema && !fieldOf(schema, id)) continue;  // of another version of the service
      const isDefault = schema && sameValue(fieldOf(schema, id)?.default, value);
      settings = withSetting(settings, id, isDefault ? undefined : value);
    }
  return settings;
}

export const withoutDefaults = (settings: Settings, schema: SettingsSchema): Settings => withSettings({}, settings, schema);

// Another profile: what the former one set goes back to the default, then the new one counts.
export function withProfile(settings: Settings, former: Settings, next: Settings, schema: SettingsSchema): Settings {
  for (const [group, members] of Object.entries(former))
    for (const key of Object.keys(members)) settings = withSetting(settings, `${group}.${key}`, undefined);
  return withSettings(settings, next, schema);
}

// A new print begins with the default profile.
export function withDefaultProfile(draft: DraftState): Partial<DraftState> {
  const {schema, profiles, form} = draft, profile = profiles?.find((one) => one.default);
  if (!schema || !profile || draft.from || JSON.stringify(form) !== JSON.stringify(emptyForm)) return {};
  return {form: {...emptyForm, profile: profile.name, settings: withSettings({}, profile.settings, schema)}};
}

// Whether all that a profile says is in the settings.
export const follows = (settings: Settings, profile: Settings, schema: SettingsSchema): boolean =>
  Object.entries(profile).every(([group, members]) => Object.entries(members).every(
    ([key, value]) => sameValue(valueOf(schema, settings, `${group}.${key}`), value)));

function without(settings: Settings, group: string): Settings {
  const {[group]: _, ...rest} = settings;
  return rest;
}

// Submission

export const hasScan = (draft: Draft): boolean => draft.scan ? draft.scan.whole : draft.from !== null;
export const printsScan = (draft: Draft): boolean => settingOf(draft.form.settings, 'pattern.source') === 'scan';
export const hasPattern = (draft: Draft): boolean =>
  printsScan(draft) || (draft.form.pattern ? draft.form.pattern.whole : draft.from?.pattern != null);
export const hasIcc = (draft: Draft): boolean => draft.form.icc === null || draft.form.icc.whole;  // or needs none

// The fields of the form that makes this job, as the API names them. From another job every setting is sent, so that one which
// went back to its default counts too.
export function submission(draft: Draft, kind: JobKind, schema: SettingsSchema): [string, string][] {
  let {settings} = draft.form;
  if (draft.from)
    for (const id of idsOf(schema)) if (settingOf(settings, id) === undefined) settings = withSetting(settings, id, fieldOf(schema, id)?.default);
  if (kind !== 'layout') settings = without(settings, 'layout');  // a print refuses them
  const fields: [string, string][] = [['kind', kind], ['settings', JSON.stringify(settings)]];
  if (draft.from) fields.push(['from', draft.from.job]);
  if (draft.scan) fields.push(['scan_upload', draft.scan.upload]);
  if (kind === 'print' && draft.form.pattern && !printsScan(draft)) fields.push(['pattern_upload', draft.form.pattern.upload]);
  if (kind === 'print' && draft.form.icc?.whole) fields.push(['icc_upload', draft.form.icc.upload]);
  // A scan that is only examined has no reference yet: it may be the wrong file.
  if (kind === 'print' && draft.form.reference) fields.push(['reference', draft.form.reference]);
  if (kind === 'print' && draft.form.reference && draft.form.rescan) fields.push(['rescan', 'true']);
  if (kind === 'print' && draft.form.note) fields.push(['note', draft.form.note]);
  return fields;
}

// The key of this start: the same as long as the same is started, so that it makes one job however often it is sent.
export function attemptFor(draft: Draft, fields: [string, string][], newKey: () => string): {key: string; content: string} {
  const content = JSON.stringify(fields);
  return draft.attempt?.content === content ? draft.attempt : {key: newKey(), content};
}

// What the scan's findings depend on.
export function scanSettings(draft: Draft): string {
  const {scan, sheet, machine} = draft.form.settings;
  const {left_side: _, ...placed} = scan ?? {};
  const {width_mm, height_mm} = sheet ?? {};
  const frame = Object.entries(machine ?? {}).filter(([key]) => /window|plug|drape_height/.test(key)).sort();
  return JSON.stringify([draft.scan?.upload ?? draft.from?.job, Object.entries(placed).sort(), width_mm, height_mm, frame]);
}

// The state of the four sections

export type Section = 'scan' | 'pattern' | 'machine' | 'check';
export const sections: Section[] = ['scan', 'pattern', 'machine', 'check'];
export type Status = 'done' | 'open' | 'working' | 'defaults' | 'ready' | 'look' | 'problem';

export function sectionOf(where: string): Section {
  const [group = ''] = where.split('.');
  if (group === 'scan' || group === 'scan_upload') return 'scan';
  if (group === 'pattern' || group === 'pattern_upload' || group === 'layout') return 'pattern';
  return group === 'reference' || group === 'rescan' || group === 'note' ? 'check' : 'machine';
}

export function statusOf(draft: DraftState, section: Section): Status {
  // Nothing is done while a person has to look at it.
  const look = doubtsOf(draft).some((doubt) => section === 'check' || placeOf[doubt] === section);
  if (section === 'check')
    return draft.problem && hasScan(draft) && hasPattern(draft) ? 'problem'
      : !draft.plan || Object.keys(draft.faults).length > 0 ? 'open' : look ? 'look' : 'ready';
  if (Object.keys(draft.faults).some((id) => sectionOf(id) === section)) return 'problem';
  if (draft.problem?.where && sectionOf(draft.problem.where) === section && hasScan(draft) && hasPattern(draft)) return 'problem';
  switch (section) {
    case 'scan':
      if (draft.transfers.scan?.state === 'failed') return 'problem';
      return !hasScan(draft) ? draft.scan ? 'working' : 'open' : look ? 'look' : 'done';
    case 'pattern':
      if (draft.transfers.pattern?.state === 'failed') return 'problem';
      return !hasPattern(draft) ? draft.form.pattern || draft.layout ? 'working' : 'open' : look ? 'look' : 'done';
    case 'machine': {
      if (draft.transfers.icc?.state === 'failed') return 'problem';
      if (!hasIcc(draft)) return 'working';
      const {sheet, machine} = draft.form.settings;
      return draft.form.profile || draft.from || sheet || machine ? 'done' : 'defaults';
    }
  }
}

// What a person has to look at once before the job starts.
export type Doubt = 'mirror' | 'size' | 'up' | 'side' | 'fit' | 'large' | 'coils';
const placeOf: Record<Doubt, Section> = {mirror: 'scan', size: 'scan', up: 'scan', side: 'scan', fit: 'scan', large: 'pattern', coils: 'pattern'};
export function doubtsOf(draft: DraftState): Doubt[] {
  const doubts: Doubt[] = [], {facts, found, form: {pattern, settings}} = draft, schema = draft.schema ?? {properties: {}};
  const has = (...codes: string[]): boolean => found?.codes.some((code) => codes.includes(code)) ?? false;
  // The answer to the question about the left ear is given by a picture of the upright head.
  const sideOpen = fieldOf(schema, 'scan.left_side') !== undefined && valueOf(schema, settings, 'scan.left_side') === 'unknown';
  if (facts?.mirrored || has('inside-out', 'mirrored-or-turned')) doubts.push('mirror');
  if (facts?.plausible === false || has('units-guessed')) doubts.push('size');
  if (facts?.upGuessed && sideOpen || has('up-guessed') && (valueOf(schema, settings, 'scan.up') ?? 'auto') === 'auto') doubts.push('up');
  if (sideOpen) doubts.push('side');
  if (facts?.wide || found?.fits === false) doubts.push('fit');
  if (pattern && !printsScan(draft) && larger(draft, schema)) doubts.push('large');
  if (pattern?.offHead) doubts.push('coils');
  return doubts.filter((doubt) => !draft.accepted.includes(subject(draft, doubt)));
}
// Whether the drawing is larger than the window, however it is turned.
function larger(draft: DraftState, schema: SettingsSchema): boolean {
  const size = draft.form.pattern && drawnSize(draft.form.pattern, draft), at = (id: string): number => Number(valueOf(schema, draft.form.settings, id));
  if (!size) return false;
  const window = [at('machine.window_width_mm'), at(valueOf(schema, draft.form.settings, 'machine.window') === 'circle' ? 'machine.window_width_mm' : 'machine.window_height_mm')];
  const scale = Number(valueOf(schema, draft.form.settings, 'pattern.scale') ?? 1), drawn = size.map((mm) => scale * (Number.isNaN(mm) ? 0 : mm));
  return Math.max(...drawn) > Math.max(...window) || Math.min(...drawn) > Math.min(...window);
}

// The size of the drawing in mm, with the width or the pixels an inch that the person gives.
export function drawnSize(pattern: Pattern, {schema, form}: DraftState): [number, number] | null {
  const given = schema && valueOf(schema, form.settings, 'pattern.width_mm');
  if (typeof given === 'number') return [given, pattern.aspect ? given / pattern.aspect : NaN];
  const dpi = schema && valueOf(schema, form.settings, 'pattern.dpi');
  if (typeof dpi === 'number' && pattern.px) return [pattern.px[0] * 25.4 / dpi, pattern.px[1] * 25.4 / dpi];
  return pattern.width && pattern.height ? [pattern.width, pattern.height] : null;
}

export function accepting(draft: Draft, doubts: readonly Doubt[]): string[] {
  return [...draft.accepted, ...doubts.map((doubt) => subject(draft, doubt))];
}
// What a person has accepted: the doubt about this scan, or this drawing.
const subject = (draft: Draft, doubt: Doubt): string =>
  `${doubt} ${placeOf[doubt] === 'pattern' ? draft.form.pattern?.mark ?? '' : draft.scan?.mark ?? draft.from?.scan.sha256 ?? ''}`;

// The job whose result no longer shows what the form says, or null: its downloads are out of date.
export function staleJob(draft: DraftState): string | null {
  const {from, form, scan} = draft;
  if (!from || from.kind !== 'print') return null;
  return scan || form.pattern || form.icc || !sameSettings(form.settings, from.settings) ? from.job : null;
}
const sameSettings = (a: Settings, b: Settings): boolean => {
  const text = (settings: Settings): string => JSON.stringify(Object.entries(settings).flatMap(
    ([group, members]) => Object.entries(members).map(([key, value]) => `${group}.${key}=${JSON.stringify(value)}`)).sort());
  return text(a) === text(b);
};

// Storage

const format = 1;

export function saved(draft: Draft): string {
  const {tab, form, scan, facts, from, inspection, layout, accepted, attempt, dropped} = draft;
  return JSON.stringify({format, tab, form, scan, facts, from, inspection, layout, accepted, attempt, dropped});
}

export function restored(text: string | null, tab: string): DraftState {
  const empty = emptyDraft(tab);
  try {
    const kept = JSON.parse(text ?? '') as Draft & {format: number};
    if (kept.format !== format) return empty;
    const {format: _, ...draft} = kept;
    return {...empty, ...draft, form: {...emptyForm, ...draft.form}};
  } catch {
    return empty;
  }
}

// For a second tab with a copy of the storage: its own draft, with files that only one tab may go on sending left out.
export function separated(draft: DraftState, tab: string): DraftState {
  const {pattern, icc} = draft.form;
  return {
    ...draft, tab, attempt: null, layout: '', scan: draft.scan?.whole ? draft.scan : null,
    form: {...draft.form, pattern: pattern?.whole ? pattern : null, icc: icc?.whole ? icc : null}};
}

export const storedUnder = 'vacuform.draft';
