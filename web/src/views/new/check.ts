// Section 4: what will be printed, said once more; what is missing or wrong; the start.
import {el, newId, replace, type Children} from '../../dom';
import {Problem} from '../../api/client';
import type {SettingsSchema} from '../../api/types';
import {shortId} from '../../parts/band';
import {openDialog} from '../../parts/confirm';
import {icon} from '../../parts/icon';
import {problemBox, problemLine} from '../../parts/problem';
import {setTitle} from '../../parts/progress';
import {choiceOf, labelOf, valueText} from '../../parts/settings-form';
import {toJob} from '../../route';
import {announce, type State} from '../../state';
import {
  accepting, doubtsOf, drawnSize, fieldOf, hasIcc, hasPattern, hasScan, idsOf, printsScan, sectionOf, settingOf, valueOf, type Doubt, type DraftState,
  type Section} from '../../state/draft';
import {bytes, t} from '../../text';
import {follow, live} from '../../view';
import {focusSetting} from './fields';
import {frameOf, frameText} from './machine';
import {sizeText} from './pattern';
import {draft, edit, setFault, start, update} from './work';

const texts = {
  reference: {most: 64, label: () => t('new.reference'), hint: () => t('new.reference_hint')},
  note: {most: 500, label: () => t('new.note'), hint: () => t('new.note_hint')}};
type TextName = keyof typeof texts;
const isText = (name: string): name is TextName => name in texts;

export interface CheckOptions {
  schema: SettingsSchema;
  go(section: Section): void;  // to the head of a section
}

// What keeps the job from starting, each with the way to it.
interface Fault {
  text: Children;
  go(): void;
}
function faultsOf(now: DraftState, {go}: CheckOptions): Fault[] {
  const to = (where: string) => (): void => {
    if (isText(where)) document.getElementById(`new-${where}`)?.focus();
    else if (!focusSetting(where)) go(sectionOf(where));
  };
  const faults: Fault[] = Object.entries(now.faults).map(([id, text]) => ({text: `${isText(id) ? texts[id].label() : labelOf(id)}: ${text}`, go: to(id)}));
  if (!hasScan(now)) faults.push({text: t(now.scan ? 'new.scan_not_sent' : 'new.scan_missing'), go: () => go('scan')});
  if (!hasPattern(now)) faults.push({text: t(now.form.pattern ? 'new.pattern_not_sent' : 'new.pattern_missing'), go: () => go('pattern')});
  if (!hasIcc(now)) faults.push({text: t('new.icc_not_sent'), go: () => go('machine')});
  if (now.problem && hasScan(now) && hasPattern(now)) {
    const {where = ''} = now.problem, taken = where === 'reference' && t('new.reference_taken');
    const setting = where.includes('.') && fieldOf(now.schema ?? {properties: {}}, where);
    const place = setting ? `${labelOf(where)}: ` : '';
    faults.push({text: taken || [place, problemLine(now.problem)], go: to(where)});
  }
  return faults;
}

interface Row {
  name: string;  // of its button: a stable id keeps the focus when the rows are built again
  label: string;
  value: Children;
  go(): void;
}
const rowOf = ({name, label, value, go}: Row): HTMLElement =>
  el('div', {class: 'check-row'}, el('dt', null, label), el('dd', null, value),
    el('dd', {class: 'change'}, el('button', {type: 'button', id: `change-${name}`, class: 'plain', onclick: go},
      t('new.change'), el('span', {class: 'hidden'}, ` ${label}`))));

function rows(now: DraftState, {schema, go}: CheckOptions): Children {
  const {form, scan, from, plan} = now;
  const {settings, pattern} = form;
  const missing = (text: string): HTMLElement => el('span', {class: 'missing'}, icon('warning'), text);
  const shown = (id: string): string => valueText(id, fieldOf(schema, id), valueOf(schema, settings, id));
  const setting = (id: string) => (): void => { if (!focusSetting(id)) go(sectionOf(id)); };
  const digest = plan?.inputs['scan']?.sha256 ?? (scan ? '' : from?.scan.sha256 ?? '');
  const size = pattern && drawnSize(pattern, now);
  const scale = Number(valueOf(schema, settings, 'pattern.scale'));
  const side = String(valueOf(schema, settings, 'scan.left_side') ?? '');
  const said = new Set(['pattern.inked_face', 'scan.left_side', 'sheet.width_mm', 'sheet.height_mm', 'machine.window', 'machine.window_width_mm',
    'machine.window_height_mm', 'sheet.material', 'sheet.thickness_mm']);
  const others = idsOf(schema).filter((id) => !id.startsWith('layout.') && !said.has(id) && settingOf(settings, id) !== undefined);
  const hash = digest ? ` · ${t('new.short_hash', {hash: digest.slice(0, 8)})}` : '';
  const list: (Row | false)[] = [
    {name: 'scan', label: t('new.row_scan'), go: () => go('scan'), value:
      scan ? [el('span', {class: 'file-name'}, scan.name), el('br'), el('span', {class: 'quiet'}, bytes(scan.bytes), hash)]
      : from ? [t('new.scan_of_job', {job: shortId(from.job)}), el('br'), el('span', {class: 'quiet'}, bytes(from.scan.bytes), hash)]
      : missing(t('new.scan_missing'))},
    fieldOf(schema, 'scan.left_side') !== undefined && {name: 'side', label: t('new.row_side'), go: () => go('scan'), value:
      side === 'unknown' ? missing(t('new.side_open')) : [icon('check'), ' ', choiceOf('scan.left_side', side)]},
    {name: 'pattern', label: t('new.row_pattern'), go: () => go('pattern'), value:
      printsScan(draft()) ? choiceOf('pattern.source', 'scan')
      : pattern ? [el('span', {class: 'file-name'}, pattern.layout ? t('new.pattern_made') : pattern.name), el('br'),
                 size ? t('new.size_on_head', {size: sizeText([size[0] * scale, size[1] * scale])})
                 : pattern.kind === 'other' ? t('new.size_unseen') : missing(t('new.no_size'))]
      : from?.pattern ? t('new.pattern_of_this_job', {job: shortId(from.job)})
      : missing(t('new.pattern_missing'))},
    {name: 'face', label: labelOf('pattern.inked_face'), go: setting('pattern.inked_face'), value: el('strong', null, shown('pattern.inked_face'))},
    {name: 'machine', label: t('new.row_machine'), go: () => go('machine'), value:
      [form.profile || t('new.no_profile'), el('br'), el('span', {class: 'quiet'}, frameText(frameOf(schema, settings)))]},
    {name: 'sheet', label: t('new.row_sheet'), go: setting('sheet.material'), value: `${shown('sheet.material')}, ${shown('sheet.thickness_mm')}`},
    (form.icc ?? from?.icc) != null && {name: 'icc', label: t('new.icc'), go: () => document.getElementById('icc-choose')?.focus(), value:
      form.icc ? el('span', {class: 'file-name'}, form.icc.name) : t('new.icc_of_this_job', {job: shortId(from?.job ?? '')})},
    {name: 'others', label: t('new.row_others'), go: () => void focusSetting(others[0] ?? 'print.dpi'), value:
      others.length === 0 ? t('new.all_defaults')
      : el('ul', {class: 'plain-list'}, others.map((id) => el('li', null, `${labelOf(id)}: `, el('strong', null, shown(id)))))}];
  return el('dl', {class: 'check-rows'}, list.map((row) => row && rowOf(row)));
}

// Asks once about what is likely to be a mistake.
async function askAbout(doubts: readonly Doubt[]): Promise<boolean> {
  const title = newId('doubts');
  return await openDialog({'aria-labelledby': title},
    el('h2', {id: title}, t('new.doubts', {count: doubts.length})),
    el('ul', {class: 'plain-list doubts'}, doubts.map((doubt) => el('li', {class: 'notice'}, icon('warning'), el('span', null, t(`new.doubt_${doubt}`))))),
    el('div', {class: 'row'},
      el('button', {type: 'submit', value: 'no', class: 'primary', autofocus: true}, t('new.back_to_scan')),
      el('button', {type: 'submit', value: 'yes'}, t('new.start_anyway')))) === 'yes';
}

function textField(name: TextName): HTMLElement {
  const {most, label, hint} = texts[name];
  const id = `new-${name}`;
  const fault = el('p', {class: 'fault', id: `${id}-fault`, role: 'alert', hidden: true});
  const props = {id, 'aria-describedby': `${id}-hint ${fault.id}`, autocomplete: 'off', spellcheck: 'false', onchange: () => {
    const value = input.value.trim();
    const length = [...value].length;
    const long = length > most;
    fault.hidden = !long;
    fault.textContent = long ? t('new.too_long', {count: length, most}) : '';
    input.toggleAttribute('aria-invalid', false);
    if (long) input.setAttribute('aria-invalid', 'true');
    setFault(name, fault.textContent);
    if (!long) edit({[name]: value});
  }};
  const input = name === 'note' ? el('textarea', {...props, rows: 3}) : el('input', {...props, type: 'text'});
  follow((state) => state.draft.form[name], (value) => { input.value = value; });
  return el('div', {class: 'field'},
    el('label', {for: id}, label()), el('p', {class: 'hint', id: `${id}-hint`}, hint()), fault, input);
}

// The reference went with the scan before this one.
const droppedNotice = (): HTMLElement => live(({draft: {dropped, form}}) => [dropped, form.reference] as const, ([dropped, reference]) =>
  dropped !== '' && reference === '' && el('p', {class: 'notice', role: 'status'}, icon('warning'),
    el('span', null, t('new.reference_dropped', {reference: dropped}))));

// Offered when the reference belongs to another head.
function rescanBox(): HTMLElement {
  const taken = ({draft: {problem, form}}: State): boolean => form.rescan || problem?.where === 'reference';
  return live((state) => [taken(state), state.draft.form.rescan] as const, ([offered, rescan]) => {
    if (!offered) return null;
    const box = el('input', {type: 'checkbox', id: 'new-rescan', checked: rescan, onchange: () => edit({rescan: box.checked})});
    return [!rescan && el('p', {class: 'notice', role: 'alert'}, icon('warning'), el('span', null, t('new.reference_taken'))),
            el('label', {class: 'choice'}, box, t('new.rescan'))];
  });
}

export function checkSection(options: CheckOptions): Children {
  const {schema, go} = options;
  const summary = el('div', null);
  const button = el('button', {type: 'button', class: 'primary start', id: 'start-job', onclick: () => void begin()}, icon('print'), t('new.start'));
  let busy = false;

  function showFaults(faults: readonly Fault[]): void {
    const title = newId('faults');
    const head = el('h3', {id: title, tabindex: -1}, icon('error'), ' ', t('problem.title'));
    replace(summary, el('div', {class: 'problem', role: 'alert', 'aria-labelledby': title}, head,
      el('ul', null, faults.map((fault) => el('li', null, el('button', {type: 'button', class: 'plain link', onclick: fault.go}, el('span', null, fault.text)))))));
    setTitle(`${t('new.error_title')}: ${t('shell.new')}`);
    head.scrollIntoView({block: 'center'});
    head.focus({preventScroll: true});
  }
  async function begin(): Promise<void> {
    if (busy) return;
    replace(summary, null);
    setTitle(t('shell.new'));
    const faults = faultsOf(draft(), options);
    if (faults.length > 0) return showFaults(faults);
    const doubts = doubtsOf(draft());
    if (doubts.length > 0) {
      if (!await askAbout(doubts)) return go('scan');
      update((now) => ({accepted: accepting(now, doubts)}));
    }
    busy = true;
    button.setAttribute('aria-disabled', 'true');
    replace(button, [icon('print'), t('new.starting')]);
    try {
      const job = await start();
      announce(t('new.started'));
      location.hash = toJob(job.id);
    } catch (error) {
      if (error instanceof Problem && error.body.where && (isText(error.body.where) || fieldOf(schema, error.body.where))) {
        update({problem: error.body, plan: null});
        showFaults(faultsOf(draft(), options));
      } else {
        replace(summary, problemBox(error, () => void begin()));
        summary.querySelector('h2')?.focus();
      }
    } finally {
      busy = false;
      button.removeAttribute('aria-disabled');
      replace(button, [icon('print'), t('new.start')]);
    }
  }
  return [
    summary,
    live(({draft: {form, scan, from, plan}}) => [form, scan, from, plan] as const, () => rows(draft(), options)),
    droppedNotice(), el('div', {class: 'two'}, el('div', null, textField('reference'), rescanBox()), textField('note')),
    el('div', {class: 'start-row'}, button,
      live(({draft: now}) => [now.checking, now.plan, now.problem, now.scan, now.form, now.from, now.faults, now.facts, now.found, now.accepted] as const, (): Children => {
        const now = draft();
        const open = faultsOf(now, options).length, doubts = doubtsOf(now).length;
        return el('p', {class: 'quiet', id: 'check-line'},
          now.checking ? t('new.checking') : open > 0 ? t('new.faults_open', {count: open})
          : !now.plan ? t('new.checking') : doubts > 0 ? [icon('warning'), ' ', t('new.ready_but', {count: doubts})] : [icon('check'), ' ', t('new.ready')]);
      }))];
}
