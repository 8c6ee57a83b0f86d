// What happens to the draft: files on their way, jobs that prepare the print, the quiet check, the start.
import {api, Problem, randomKey, type FoundProblem} from '../../api/client';
import {followJob} from '../../api/events';
import {extensionOf, markOf, removeUpload, startUpload, type Transfer, type Upload} from '../../api/upload';
import type {Job, ListedJob, SettingsSchema} from '../../api/types';
import {announce, store} from '../../state';
import {
  attemptFor, changed, emptyDraft, emptyForm, hasPattern, hasScan, redone, restored, saved, scanSettings, separated,
  storedUnder, submission, undone, withDefaultProfile, withoutDefaults, withoutReference, withSetting, type Draft, type DraftState, type Form, type Pattern,
  type SentFile, type SentInput} from '../../state/draft';
import {mayKeep} from '../../state/person';
import {ended} from '../../api/types';
import type {Warning} from '../../state/jobs';
import {readScanFile} from '../../parts/reader';
import type {ReadScan} from '../../read/prepare';
import {pictureSize, svgSize} from '../../read/drawing';
import {t} from '../../text';

export const draft = (): DraftState => store.get().draft;
export function update(change: Partial<DraftState> | ((draft: DraftState) => Partial<DraftState>)): void {
  store.set((state) => ({draft: {...state.draft, ...(typeof change === 'function' ? change(state.draft) : change)}}));
}
export const edit = (change: Partial<Form>): void => update((now) => changed(now, change));
export const setSetting = (id: string, value: unknown): void => edit({settings: withSetting(draft().form.settings, id, value)});
export function setFault(id: string, text: string): void {
  const {[id]: _, ...others} = draft().faults;
  update({faults: text ? {...others, [id]: text} : others});
}
export function undo(): void {
  update(undone);
  announce(t('new.undone'));
}
export function redo(): void {
  update(redone);
  announce(t('new.redone'));
}

const problemOf = (error: unknown): Problem =>
  error instanceof Problem ? error : new Problem({type: 'about:blank', title: '', status: 0, what: String(error)});

// The settings that this service knows, and its profiles: read once.
let reading: Promise<SettingsSchema> | null = null;
let isNew: boolean | null = null;  // nothing has been done in this tab yet
export const readSchema = (): Promise<SettingsSchema> => reading ??= (async () => {
  isNew ??= sessionStorage.getItem(storedUnder) === null;
  try {
    const [schema, {profiles}] = await Promise.all([api.schema(), api.profiles()]);
    update({schema, profiles, unread: null});
    if (isNew) update(withDefaultProfile);
    return schema;
  } catch (error) {
    reading = null;
    update({unread: problemOf(error)});
    throw error;
  }
})();

// Files on their way. They go on while another view is shown.

const uploads: Record<SentInput, Upload | null> = {scan: null, pattern: null, icc: null};
const fileOf = (of: Draft, input: SentInput): SentFile | null => input === 'scan' ? of.scan : of.form[input];
const setTransfer = (input: SentInput, transfer: Transfer | null): void =>
  update((now) => ({transfers: {...now.transfers, [input]: transfer}}));

// Changes the record of a file that is being sent, also where undo could bring it back.
function setFile(input: SentInput, mark: string, change: Partial<SentFile>): void {
  update((now) => {
    if (input === 'scan') return now.scan?.mark === mark ? {scan: {...now.scan, ...change}} : {};
    const renew = (form: Form): Form =>
      form[input]?.mark === mark ? {...form, [input]: {...form[input], ...change}} : form;
    return {form: renew(now.form), past: now.past.map(renew), future: now.future.map(renew)};
  });
}

function send(input: SentInput, file: Blob, name: string, mark: string, id: string | null): void {
  uploads[input]?.pause();
  uploads[input] = startUpload({file, extension: extensionOf(name), input, id}, {
    started: (upload) => setFile(input, mark, {upload, whole: false}),
    progress: (transfer) => { if (fileOf(draft(), input)?.mark === mark) setTransfer(input, transfer); },
    done: (upload) => {
      setFile(input, mark, {upload, whole: true});
      setTransfer(input, null);
      announce(t(`new.${input}_sent`));
      if (input === 'scan') void inspect();
    },
  });
}
export const uploadOf = (input: SentInput): Upload | null => uploads[input];

// What has fully arrived stays: undo may bring it back.
function drop(input: SentInput): void {
  if (!fileOf(draft(), input)?.whole) uploads[input]?.abort();
  uploads[input] = null;
  setTransfer(input, null);
}

let scanFile: File | null = null;  // as long as the page lives

// Takes a scan. The same file as before resumes its upload; another one begins from nothing.
export async function takeScan(file: File): Promise<void> {
  const mark = await markOf(file);
  scanFile = file;
  const former = draft().scan;
  if (former?.mark === mark && (former.whole || uploads.scan)) return;
  const same = former?.mark === mark;
  if (!same) {
    drop('scan');
    if (former) removeUpload(former.upload);
    stopInspection();
    if (former || draft().from) dropReference();
    update({
      scan: {upload: '', whole: false, name: file.name, bytes: file.size, mark}, inspection: null, facts: null,
      form: {...draft().form, settings: withSetting(draft().form.settings, 'scan.left_side', undefined)}});
  }
  send('scan', file, file.name, mark, same ? former.upload || null : null);
}

// The reference belongs to the head of the scan that is replaced or removed.
function dropReference(): void {
  const {reference} = draft().form;
  update(withoutReference);
  if (reference) announce(t('new.reference_dropped', {reference}));
}

export function removeScan(): void {
  const {scan} = draft();
  dropReference();
  scanFile = null;
  drop('scan');
  if (scan?.whole) removeUpload(scan.upload);
  stopInspection();
  update({scan: null, facts: null, inspection: null});
}

// Patterns. Small files stay in the storage of the tab, so that a reload shows them again.

const keptFiles = new Map<string, Blob>();
const fileKey = (mark: string): string => `vacuform.pattern.${mark}`;
const mostKept = 1_000_000;  // bytes

function keepFile(mark: string, bytes: ArrayBuffer, type: string): void {
  keptFiles.set(mark, new Blob([bytes], {type}));
  if (!mayKeep() || bytes.byteLength > mostKept) return;
  try {
    const text = [...new Uint8Array(bytes)].map((byte) => String.fromCharCode(byte)).join('');
    sessionStorage.setItem(fileKey(mark), `${type},${btoa(text)}`);
  } catch {
    // the storage is full: the file is missing after a reload, the upload is not
  }
}

export function keptFile(mark: string): Blob | null {
  const known = keptFiles.get(mark);
  if (known) return known;
  const [type = '', text] = sessionStorage.getItem(fileKey(mark))?.split(',') ?? [];
  if (!text) return null;
  const blob = new Blob([Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0))], {type});
  keptFiles.set(mark, blob);
  return blob;
}

// Of the drawings that this page can show.
const drawingFormats: Record<string, [Pattern['kind'], string]> = {
  svg: ['svg', 'image/svg+xml'], png: ['picture', 'image/png'], jpg: ['picture', 'image/jpeg'], jpeg: ['picture', 'image/jpeg']};

export async function takePattern(file: Blob, name: string, layout = '', offHead = 0): Promise<void> {
  const mark = await markOf(file);
  const bytes = await file.arrayBuffer();
  const [kind, type] = drawingFormats[extensionOf(name)] ?? ['other', 'application/octet-stream'];
  const size = kind === 'svg' ? svgSize(new TextDecoder().decode(bytes)) : pictureSize(bytes);
  keepFile(mark, bytes, type);
  const former = draft().form.pattern;
  if (former?.mark === mark && (former.whole || uploads.pattern)) return;
  const resumed = former?.mark === mark ? former.upload || null : null;
  uploads.pattern?.pause();
  uploads.pattern = null;
  const pattern: Pattern = {
    upload: resumed ?? '', whole: false, name, bytes: file.size, mark, kind, ...size, layout, offHead};
  edit({pattern});
  resume('pattern');
}

export function removePattern(): void {
  drop('pattern');
  edit({pattern: null});
}

// ICC profiles are kept like patterns.
export async function takeIcc(file: File): Promise<void> {
  const mark = await markOf(file), former = draft().form.icc;
  if (former?.mark === mark && (former.whole || uploads.icc)) return;
  keepFile(mark, await file.arrayBuffer(), 'application/vnd.iccprofile');
  drop('icc');
  edit({icc: {upload: '', whole: false, name: file.name, bytes: file.size, mark}});
  resume('icc');
}
export function removeIcc(): void {
  drop('icc');
  edit({icc: null});
}

// Sends a file that has been chosen, that undo has brought back, or that a reload has interrupted, if its bytes are here and
// are not on their way.
function resume(input: 'pattern' | 'icc'): void {
  const file = draft().form[input];
  if (!file || file.whole || uploads[input]) return;
  const bytes = keptFile(file.mark);
  if (bytes) send(input, bytes, file.name, file.mark, file.upload || null);
}
function resumeFiles(): void {
  resume('pattern');
  resume('icc');
}

// Jobs that prepare the print

export interface SideJob {
  job: ListedJob | null;     // as it is now
  problem: Problem | null;   // that kept it from starting or ending
  findings: Findings | null; // of an inspection
}
export interface Findings {
  scan?: {trim_mm?: number};
  warnings: Warning[];
  problem: FoundProblem | null;
  fits: boolean;
}
const none: SideJob = {job: null, problem: null, findings: null};
export const inspection = {now: none, stop: (): void => {}};
export const layout = {now: none, stop: (): void => {}};
const listeners = new Set<() => void>();
export function onSideJob(listener: () => void): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}
function tell(which: typeof inspection, now: Partial<SideJob>): void {
  which.now = {...which.now, ...now};
  for (const listener of [...listeners]) listener();
}

function followSide(which: typeof inspection, id: string, end: (job: Job) => void): void {
  which.stop();
  which.stop = followJob(id, {
    job: (change) => {
      const {job} = which.now;
      tell(which, {job: {...(job ?? {}), ...change} as ListedJob});
      if (ended(change.state)) void api.job(id).then(end, (error: unknown) => tell(which, {problem: problemOf(error)}));
    },
    log: () => {},
    reached: () => {},
    failed: (problem) => tell(which, {problem}),
  });
}

const formOf = (fields: [string, string][]): FormData => {
  const form = new FormData();
  for (const [name, value] of fields) form.append(name, value);
  return form;
};

// Examines the scan with the settings as they are now.
export async function inspect(): Promise<void> {
  if (!hasScan(draft())) return;
  stopInspection();
  const scan = scanSettings(draft());
  try {
    const job = await api.create(formOf(submission(draft(), 'inspection', await readSchema())), randomKey());
    if (scanSettings(draft()) !== scan && !hasScan(draft())) return;
    update({inspection: {job: job.id, scan}});
    tell(inspection, {...none, job});
    followInspection(job.id);
  } catch (error) {
    const problem = problemOf(error);
    if (!lost(problem)) tell(inspection, {...none, problem});
  }
}
function followInspection(id: string): void {
  followSide(inspection, id, (job) => void (async () => {
    if (job.state !== 'succeeded') return tell(inspection, {job});
    const findings = await api.artifactJson<Findings>(id, 'findings.json');
    tell(inspection, {job, findings, problem: null});
    update({found: {codes: findings.warnings.map(({code}) => code), fits: findings.fits}});
    announce(t('new.inspected', {count: findings.warnings.length}));
  })().catch((error: unknown) => tell(inspection, {problem: problemOf(error)})));
}
// The mold of an inspection, as the page shows it.
export async function readMold(id: string, signal: AbortSignal): Promise<ReadScan> {
  const bytes = await (await api.artifact(id, 'mold.stl', signal)).blob();
  return await readScanFile(new File([bytes], 'mold.stl'), () => {}, signal);
}
export function stopInspection(): void {
  inspection.stop();
  tell(inspection, none);
  update({found: null});
}

// Has the service make a pattern of coils for the scan.
export async function makeLayout(): Promise<void> {
  layout.stop();
  tell(layout, none);
  try {
    const job = await api.create(formOf(submission(draft(), 'layout', await readSchema())), randomKey());
    update({layout: job.id});
    tell(layout, {...none, job});
    followLayout(job.id);
  } catch (error) {
    tell(layout, {...none, problem: problemOf(error)});
  }
}
function followLayout(id: string): void {
  followSide(layout, id, (job) => void (async () => {
    update({layout: ''});
    tell(layout, {job});
    if (job.state === 'succeeded') await takeLayout(id);
  })().catch((error: unknown) => tell(layout, {problem: problemOf(error)})));
}
async function takeLayout(id: string): Promise<void> {
  const picture = await (await api.artifact(id, 'pattern.svg')).blob();
  const {off_head: offHead} = await api.artifactJson<{off_head: number}>(id, 'layout.json');
  await takePattern(picture, 'pattern.svg', id, offHead);
  tell(layout, {});
}
export async function cancelLayout(): Promise<void> {
  const {layout: id} = draft();
  update({layout: ''});
  layout.stop();
  tell(layout, none);
  if (id) await api.cancel(id).catch(() => {});
}

// The quiet check: the server says what the job would be, soon after every change.

let checkTimer = 0;
let asked = new AbortController();
function checkSoon(): void {
  clearTimeout(checkTimer);
  asked.abort();
  if (!hasScan(draft()) || !hasPattern(draft())) {
    update({plan: null, problem: null, checking: false});
    return;
  }
  update({checking: true});
  checkTimer = window.setTimeout(() => void check(), 500);
}
async function check(): Promise<void> {
  const mine = asked = new AbortController();
  try {
    const plan = await api.validate(formOf(submission(draft(), 'print', await readSchema())), mine.signal);
    if (!mine.signal.aborted) update({plan, problem: null, checking: false});
  } catch (error) {
    if (mine.signal.aborted) return;
    const problem = problemOf(error);
    if (lost(problem)) return;
    update({plan: null, problem: problem.body, checking: false});
    if (problem.status === 0) checkTimer = window.setTimeout(() => void check(), 5000);
  }
}

// An upload that the server no longer has: it is sent again, or the person gives the file again after a reload.
function lost(problem: Problem): boolean {
  if (problem.status !== 404 && problem.status !== 410) return false;
  const {where = ''} = problem.body;
  const {scan, form} = draft();
  if (scan?.whole && where.includes(scan.upload)) {
    update({scan: {...scan, whole: false, upload: ''}});
    if (scanFile) send('scan', scanFile, scan.name, scan.mark, null);
    return true;
  }
  for (const input of ['pattern', 'icc'] as const) {
    const file = form[input];
    if (!file?.whole || !where.includes(file.upload)) continue;
    setFile(input, file.mark, {whole: false, upload: ''});
    resume(input);
    return true;
  }
  return false;
}

// Starts the job. The key is kept until the server has answered, so that a second attempt makes no second job.
export async function start(): Promise<Job> {
  const fields = submission(draft(), 'print', await readSchema());
  const attempt = attemptFor(draft(), fields, randomKey);
  update({attempt});
  keep();
  try {
    const job = await api.create(formOf(fields), attempt.key);
    clear();
    return job;
  } catch (error) {
    if (error instanceof Problem && error.status >= 400 && error.status < 500) update({attempt: null});
    if (error instanceof Problem) lost(error);
    throw error;
  }
}

// Forgets the draft and deletes its files on the server, of which a started job has copies: an owner may have a few only.
export function clear(): void {
  const {scan, form, past, future} = draft();
  const files = [scan, ...[form, ...past, ...future].flatMap(({pattern, icc}) => [pattern, icc])];
  reset();
  for (const id of new Set(files.map((file) => file?.upload))) if (id) removeUpload(id);
}

function reset(): void {
  for (const input of ['scan', 'pattern', 'icc'] as const) {
    uploads[input]?.pause();
    uploads[input] = null;
  }
  scanFile = null;
  layout.stop();
  tell(layout, none);
  stopInspection();
  const {tab, schema, profiles} = draft();
  store.set({draft: {...emptyDraft(tab), schema, profiles}});
  update(withDefaultProfile);
}

// The draft that another one replaced: the person can go back to it.
const keptBefore = 'vacuform.draft.before';
export const hasBefore = (): boolean => sessionStorage.getItem(keptBefore) !== null;
export function goBack(): void {
  const {tab, schema, profiles} = draft();
  const before = restored(sessionStorage.getItem(keptBefore), tab);
  sessionStorage.removeItem(keptBefore);
  reset();
  store.set({draft: {...before, schema, profiles}});
  resumeJobs();
}
function putAside(): void {
  const now = draft();
  if (now.scan || now.form.pattern) sessionStorage.setItem(keptBefore, saved(now));
}

// From another job

export async function startFrom(id: string): Promise<void> {
  const [job, schema] = await Promise.all([api.job(id), readSchema()]);
  const {scan, pattern = null, icc = null} = job.inputs;
  if (!scan) throw new Problem({type: 'not-found', title: '', status: 0, what: t('new.no_scan_in_job')});
  putAside();
  reset();
  const {layout: _, ...settings} = withoutDefaults(job.settings, schema);
  update({
    from: {job: id, kind: job.kind, scan, pattern, icc, settings},
    form: {...emptyForm, settings, reference: job.reference ?? ''},
    inspection: job.kind === 'inspection' ? {job: id, scan: ''} : null});
  update((now) => now.inspection ? {inspection: {job: id, scan: scanSettings(now)}} : {});
  resumeJobs();
  if (job.kind === 'layout') await takeLayout(id);
}

function resumeJobs(): void {
  const {inspection: examined, layout: made} = draft();
  if (examined && !inspection.now.job) {
    void api.job(examined.job).then((job) => {
      tell(inspection, {job});
      followInspection(job.id);
    }, () => update({inspection: null}));  // deleted
  }
  if (made && !layout.now.job) followLayout(made);
}

// Storage

let keptDraft: Draft | null = null;
function keep(): void {
  if (!mayKeep()) return;
  const now = draft();
  if (keptDraft && (['form', 'scan', 'facts', 'from', 'inspection', 'layout', 'accepted', 'attempt', 'dropped', 'tab'] as const)
        .every((name) => keptDraft?.[name] === now[name])) return;
  keptDraft = now;
  try {
    sessionStorage.setItem(storedUnder, saved(now));
  } catch {
    // the storage is full or forbidden: the draft lives as long as the page
  }
}

let began = false;
// Once a page: keeps the draft, checks it after every change, and goes on with what a reload interrupted.
export function begin(): void {
  if (began) return;
  began = true;
  ownTab();
  let before = draft();
  store.subscribe(({draft: now}) => {
    if (now === before) return;
    const was = before;
    before = now;
    keep();
    if (now.form !== was.form || now.scan !== was.scan || now.from !== was.from) {
      checkSoon();
      if (now.form !== was.form) resumeFiles();
    }
  });
  resumeFiles();
  resumeJobs();
  checkSoon();
}

// A copied tab has a copy of the draft. The one that was there first keeps it; the other gets its own.
function ownTab(): void {
  const channel = new BroadcastChannel('vacuform-draft');
  const me = randomKey();
  let since = Date.now();
  channel.onmessage = ({data}: MessageEvent<{ask?: string; held?: string; page: string; since: number}>) => {
    const {tab} = draft();
    if (data.page === me) return;
    if (data.ask === tab && since <= data.since) channel.postMessage({held: tab, page: me, since});
    if (data.held === tab && data.since <= since) {
      since = Date.now();
      update((now) => separated(now, randomKey()));
      announce(t('new.second_tab'));
    }
  };
  channel.postMessage({ask: draft().tab, page: me, since});
}

