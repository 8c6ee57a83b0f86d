// One page from a scan to a started job. What the person has done so far is in the draft, which outlives a reload.
import {el, replace, type Children} from '../dom';
import {shortId} from '../parts/band';
import {confirm} from '../parts/confirm';
import {icon, type IconName} from '../parts/icon';
import {problemBox} from '../parts/problem';
import {setTitle} from '../parts/progress';
import {warningsList} from '../parts/warnings-list';
import {foundProblem, Problem} from '../api/client';
import type {Settings, SettingsSchema} from '../api/types';
import {toJob, toNew} from '../route';
import {store} from '../state';
import {drawnSize, hasScan, sameValue, scanSettings, sections, statusOf, withSettings, type ScanFacts, type Section, type Status} from '../state/draft';
import {bytes, percent, t} from '../text';
import {follow, live, onEnd, View} from '../view';
import {checkSection} from './new/check';
import {followDraft} from './new/fields';
import {machineSection} from './new/machine';
import type {ReadScan} from '../read/prepare';
import type {Drawing} from './new/scan';
import './new/scan';
import {loadDrawing, patternSection} from './new/pattern';
import {transferLine} from './new/transfer';
import {
  begin, clear, draft, edit, goBack, hasBefore, inspect, inspection, onSideJob, readMold, readSchema, redo, removeScan, startFrom, takeScan, undo,
  update} from './new/work';
import type {SettingsForm} from '../parts/settings-form';

const icons: Record<Section, IconName> = {scan: 'head', pattern: 'pattern', machine: 'settings', check: 'print'};
const statusIcons: Record<Status, IconName | null> = {done: 'check', open: null, working: 'upload', defaults: null, ready: 'check', look: 'warning', problem: 'error'};

const statusBadge = (section: Section): HTMLElement => live((state) => statusOf(state.draft, section), (status) => {
  const name = statusIcons[status];
  return el('span', {class: `step-status is-${status}`}, name && icon(name), t(`new.status_${status}`));
});

export function goTo(section: Section): void {
  const head = document.getElementById(`new-${section}`);
  head?.scrollIntoView({block: 'start'});
  head?.focus({preventScroll: true});
}

// What the section of the scan is to this page: the element of new/scan.ts.
interface ScanSection extends HTMLElement {
  settings: Settings;
  inspected: {trim_mm?: number} | null;
  mold: ReadScan | null;
  readonly suspicions: ScanFacts | null;
  drawing: Drawing | null;
  show(place: readonly number[]): void;
}

function scanFigures(): Children {
  const {scan, from, transfers} = draft();
  if (!scan) return from && el('p', {class: 'notice good'}, icon('check'),
    t('new.scan_again', {extension: from.scan.extension.toUpperCase(), bytes: bytes(from.scan.bytes), hash: from.scan.sha256.slice(0, 8)}));
  if (!scan.whole && !transfers.scan)  // after a reload
    return el('p', {class: 'notice plain', role: 'status'}, icon('upload'), el('span', null, t('new.choose_again', {name: scan.name, bytes: bytes(scan.bytes)})));
  return scan.whole && el('p', {class: 'row scan-sent'}, el('span', null, icon('check'), ' ', t('new.scan_there', {name: scan.name, bytes: bytes(scan.bytes)})),
    el('button', {type: 'button', id: 'scan-remove', class: 'plain', onclick: removeScan}, icon('delete'), t('new.remove_scan')));
}

// What the service finds in the scan, before anything is printed.
function findings(show: (place: readonly number[]) => void): HTMLElement {
  const host = el('section', {class: 'findings', 'aria-labelledby': 'findings-title'});
  const again = (): HTMLElement => el('button', {type: 'button', id: 'inspect-again', onclick: () => void inspect()}, icon('reset'), t('new.inspect_again'));
  const update = (): void => {
    const now = draft();
    const {job, problem, findings: found} = inspection.now;
    host.hidden = !hasScan(now);
    const old = now.inspection !== null && now.inspection.scan !== scanSettings(now);
    replace(host, [
      el('h3', {id: 'findings-title'}, t('new.findings')),
      problem ? problemBox(problem, () => void inspect())
      : !job ? el('p', null, again())
      : job.state === 'failed' && job.problem ? problemBox(new Problem(job.problem), () => void inspect())
      : found ? [
          old && el('p', {class: 'notice plain', role: 'status'}, icon('info'), el('span', null, t('new.findings_old')), again()),
          found.problem && problemBox(foundProblem(found.problem)),
          found.warnings.length > 0 || found.problem
            ? warningsList(found.warnings, show) : el('p', {class: 'notice good'}, icon('check'), t('new.no_findings')),
          el('p', null, el('a', {href: toJob(job.id)}, t('new.inspection_job')))]
      : job.state === 'cancelled' ? el('p', {class: 'row'}, t('new.inspection_cancelled'), again())
      : el('p', {class: 'quiet', role: 'status'}, t('new.inspecting'), ' ', percent(job.progress))]);
  };
  follow((state) => [state.draft.scan, state.draft.from, state.draft.inspection, state.draft.form.settings] as const, update);
  onEnd(onSideJob(update));
  return host;
}

function scanSection(schema: SettingsSchema): Children {
  const section = document.createElement('vf-scan-section') as ScanSection;
  // The same file again, after a reload: what was set for it stays.
  let again = false;
  section.addEventListener('file', (event) => {
    const {file} = (event as CustomEvent<{file: File}>).detail;
    const {scan, form} = draft();
    again = scan !== null && scan.name === file.name && scan.bytes === file.size;
    if (again) queueMicrotask(() => {
      again = false;
      section.settings = form.settings;
    });
    void takeScan(file).then(() => update({facts: section.suspicions}));
  });
  section.addEventListener('facts', (event) => update({facts: (event as CustomEvent<ScanFacts>).detail}));
  section.addEventListener('change', (event) => {
    const {settings} = (event as CustomEvent<{settings?: Settings} | undefined>).detail ?? {};  // fields inside have this event too
    if (settings && !again) edit({settings: withSettings(draft().form.settings, settings, schema)});
  });
  const ending = new AbortController();
  onEnd(() => ending.abort());
  const inspected = (): void => {
    const {job, findings: found} = inspection.now;
    section.inspected = found?.scan ?? null;
    if (section.suspicions) return;  // the browser has the scan itself
    const valid = job && found && draft().inspection?.scan === scanSettings(draft()) ? job.id : '';
    if (valid !== moldOf) void showMold(moldOf = valid);
  };
  let moldOf = '';  // the inspection whose mold is shown
  const showMold = async (id: string): Promise<void> => {
    const mold = id ? await readMold(id, ending.signal).catch(() => null) : null;  // a scan that makes no mold
    if (id === moldOf && !ending.signal.aborted) section.mold = mold;
  };
  follow(({draft: now}) => [now.inspection, now.form.settings] as const, inspected);
  onEnd(onSideJob(inspected));
  let shown: Settings | null = null;
  follow(({draft: now}) => [now.form.settings, hasScan(now)] as const, ([{scan, sheet = {}, machine = {}, pattern = {}}, there]) => {
    const settings = {...(scan || there) && {scan: scan ?? {}}, sheet, machine, pattern};  // without a scan there is nothing to set
    if (sameValue(settings, shown)) return;
    section.settings = shown = settings;
  });
  follow(({draft: now}) => [now.form.pattern, now.form.settings['pattern']?.['width_mm'], now.form.settings['pattern']?.['dpi']] as const, async ([pattern]) => {
    const picture = new Image(), size = pattern && drawnSize(pattern, draft());
    const loaded = size && await loadDrawing(pattern, picture);
    if (pattern?.mark !== draft().form.pattern?.mark) return;  // another one by now
    section.drawing = loaded ? {picture, size: [size[0], size[1] || size[0] * picture.naturalHeight / picture.naturalWidth]} : null;
  });
  return [
    live(({draft: now}) => [now.scan, now.from, now.transfers.scan === null] as const, scanFigures),
    transferLine('scan'), section, findings((place) => section.show(place))];
}

function originNotice(): HTMLElement {
  return live((state) => state.draft.from, (from): Children => [
    from && el('p', {class: 'notice plain', role: 'status'}, icon('copy'), el('span', null,
      t('new.from_job'), ' ', el('a', {href: toJob(from.job)}, shortId(from.job)), '. ',
      t(from.pattern ? 'new.from_all' : from.kind === 'layout' ? 'new.from_layout' : 'new.from_scan'))),
    hasBefore() && el('p', {class: 'notice plain', role: 'status'}, icon('undo'), el('span', null, t('new.before')),
      el('button', {type: 'button', onclick: () => { goBack(); location.hash = toNew(); }}, t('new.go_back')))]);
}

function toolbar(): HTMLElement {
  const undoButton = el('button', {type: 'button', class: 'plain', id: 'new-undo', onclick: undo, 'aria-keyshortcuts': 'Control+Z'}, icon('undo'), t('new.undo'));
  const redoButton = el('button', {type: 'button', class: 'plain', id: 'new-redo', onclick: redo, 'aria-keyshortcuts': 'Control+Shift+Z'}, icon('redo'), t('new.redo'));
  follow((state) => [state.draft.past.length > 0, state.draft.future.length > 0] as const, ([back, forth]) => {
    for (const [button, may] of [[undoButton, back], [redoButton, forth]] as const) button.disabled = !may;
  });
  const clearButton = el('button', {type: 'button', class: 'plain', id: 'new-clear', onclick: () => void confirm({
    title: t('new.clear_title'), text: t('new.clear_text'), action: t('new.clear'), icon: 'delete'}).then((yes) => {
    if (!yes) return;
    clear();
    location.hash = toNew();
  })}, icon('delete'), t('new.clear'));
  return el('div', {class: 'row tools'}, undoButton, redoButton, clearButton);
}

function undoByKeys(): void {
  const keys = (event: KeyboardEvent): void => {
    const at = event.target;
    const typing = at instanceof HTMLTextAreaElement || (at instanceof HTMLInputElement && /^(text|search)$/.test(at.type));
    if (typing || event.altKey || !(event.ctrlKey || event.metaKey)) return;
    const key = event.key.toLowerCase();
    if (key !== 'z' && key !== 'y') return;
    event.preventDefault();
    const now = draft();
    if (key === 'y' || event.shiftKey) {
      if (now.future.length > 0) redo();
    } else if (now.past.length > 0) undo();
  };
  document.addEventListener('keydown', keys);
  onEnd(() => document.removeEventListener('keydown', keys));
}

function step(section: Section, at: number, content: Children): HTMLElement {
  return el('section', {class: 'card new-step', 'aria-labelledby': `new-${section}`},
    el('div', {class: 'step-head'},
      el('h2', {id: `new-${section}`, tabindex: -1}, el('span', {class: 'step-number', 'aria-hidden': 'true'}, String(at + 1)), t(`new.section_${section}`)),
      statusBadge(section)),
    content);
}

class NewPrint extends View {
  protected build(): Children {
    setTitle(t('shell.new'));
    const failed = el('div', null), parts = el('div', {class: 'stack'});
    begin();
    follow((state) => state.route, (route) => {
      const from = route.view === 'new' ? new URLSearchParams(route.query).get('from') : null;
      if (!from || from === store.get().draft.from?.job) return;
      const open = async (): Promise<void> => {
        parts.inert = true;  // what a person typed now would be lost when the other job arrives
        replace(failed, await startFrom(from).then(() => null, (error: unknown) => problemBox(error, () => void open())));
        parts.inert = false;
      };
      void open();
    });
    undoByKeys();
    let openAll = (): SettingsForm | null => null;
    const body = live((state) => [state.draft.schema, state.draft.unread] as const, ([schema, unread]): Children => {
      if (!schema) return unread ? problemBox(unread, () => void readSchema()) : el('p', {class: 'quiet', role: 'status'}, t('shell.loading'));
      const content: Record<Section, Children> = {
        scan: scanSection(schema), pattern: patternSection(schema),
        machine: machineSection(schema, (open) => { openAll = open; }), check: checkSection({schema, go: goTo})};
      followDraft(() => openAll());
      return sections.map((section, at) => step(section, at, content[section]));
    });
    parts.append(body);
    readSchema().catch(() => {});  // shown above
    return [
      el('div', {class: 'spread new-head'}, el('h1', null, t('shell.new')), toolbar()),
      failed, originNotice(),
      el('div', {class: 'new-print'},
        el('nav', {class: 'new-steps', 'aria-label': t('new.sections')}, el('ol', null, sections.map((section) =>
          el('li', null, el('button', {type: 'button', class: 'plain', onclick: () => goTo(section)},
            icon(icons[section]), el('span', null, t(`new.section_${section}`)), statusBadge(section)))))),
        parts)];
  }
}
customElements.define('vf-new-print', NewPrint);
