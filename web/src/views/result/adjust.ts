// Moves the drawing on the part: a preview at once, and a job that makes the print for it.
import {el, newId, replace} from '../../dom';
import {api, randomKey} from '../../api/client';
import type {Job} from '../../api/types';
import {icon} from '../../parts/icon';
import {numberField} from '../../parts/number-field';
import {problemBox} from '../../parts/problem';
import {toJob} from '../../route';
import {announce} from '../../state';
import {begun, isMoved, move, placed, placementOf, previewPlace, redo, undo, type Moves, type Placement, type PrintReport} from '../../state/result';
import {t} from '../../text';
import type {Part} from './part';

const fields = [
  {name: 'x', unit: 'mm', reach: 50, step: 0.5, min: -500, max: 500},
  {name: 'y', unit: 'mm', reach: 50, step: 0.5, min: -500, max: 500},
  {name: 'turn', unit: '°', reach: 180, step: 1, min: -360, max: 360},
  {name: 'scale', unit: '', reach: 0.5, step: 0.01, min: 0.01, max: 100},
] as const;

// `stale`: the drawing has moved, so the files no longer match what is shown.
export function adjustView(job: Job, report: PrintReport, part: Part, stale: (stale: boolean) => void): HTMLElement {
  const settings = job.settings['pattern'] ?? {};
  if (((settings['points'] ?? []) as unknown[]).length > 0) return el('p', {class: 'quiet'}, t('result.adjust_points'));
  const start = placementOf(job), byElements = (report.coils ?? []).length > 0;
  let moves: Moves = begun(job), key = '', sending = false;

  const rows = fields.map(({name, unit, reach, step, min, max}) => {
    const id = newId('adjust'), label = t(`result.adjust_${name}`);
    const set = (value: number, lasting: boolean): void => {
      const to: Placement = {...placed(moves), [name]: Number(value.toFixed(4))};
      if (lasting) change(move(moves, to));
      else show(to);
    };
    const field = numberField({id, label, unit, min, max, named: true, change: (value) => { if (value !== null) set(value, true); }});
    const slider = el('input', {type: 'range', 'aria-label': label, min: Math.max(min, start[name] - reach), max: Math.min(max, start[name] + reach), step,
      oninput: () => set(slider.valueAsNumber, false), onchange: () => set(slider.valueAsNumber, true)});
    const element = el('div', {class: 'field'}, el('label', {for: id}, label), field.element, slider);
    return {element, show(value: number) {
      field.show(value);
      slider.value = String(value);
    }};
  });
  const button = (name: 'undo' | 'redo' | 'reset', act: () => void): HTMLButtonElement =>
    el('button', {type: 'button', onclick: act}, icon(name), t(`result.${name}`));
  const back = button('undo', () => change(undo(moves))), again = button('redo', () => change(redo(moves)));
  const reset = button('reset', () => change(move(moves, start)));
  const apply = el('button', {type: 'button', class: 'primary', onclick: () => void send()}, t('result.apply'));
  const trouble = el('div');

  function show(to: Placement): void {
    fields.forEach(({name}, i) => rows[i]?.show(to[name]));
    const still = fields.every(({name}) => to[name] === start[name]);
    part.preview(still ? null : ({size, origin}) => previewPlace(start, to, report.flattening.top_rest_mm, size, origin));
  }
  function change(to: Moves): void {
    moves = to;
    key = '';
    show(placed(moves));
    const moved = isMoved(moves);
    back.disabled = moves.at === 0;
    again.disabled = moves.at === moves.steps.length - 1;
    reset.disabled = apply.disabled = !moved;
    stale(moved);
  }
  async function send(): Promise<void> {
    if (sending) return;
    sending = apply.disabled = true;
    // one key for one placement: a request that is sent twice makes one job
    key ||= randomKey();
    const {x, y, turn, scale} = placed(moves), form = new FormData();
    form.set('from', job.id);
    form.set('settings', JSON.stringify({pattern: {offset_mm: [x, y], rotate_deg: turn, scale}}));
    try {
      const made = await api.create(form, key);
      announce(t('result.applied'));
      location.hash = toJob(made.id);
    } catch (error) {
      replace(trouble, problemBox(error));
    } finally {
      sending = apply.disabled = false;
    }
  }
  const element = el('div', {class: 'adjust', onkeydown: (event) => {
    if (!event.ctrlKey || event.key.toLowerCase() !== 'z' || (event.target as HTMLInputElement).type === 'text') return;
    event.preventDefault();
    change(event.shiftKey ? redo(moves) : undo(moves));
  }},
    el('p', {class: 'small'}, t(byElements ? 'result.adjust_elements' : 'result.adjust_preview')),
    el('div', {class: 'adjust-fields'}, ...rows.map((row) => row.element)),
    el('div', {class: 'row'}, back, again, reset, apply), trouble);
  change(moves);
  return element;
}
