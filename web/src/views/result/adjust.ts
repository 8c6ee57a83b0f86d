// Moves the drawing on the part, by numbers and by pairs of points: a preview at once, and a job that makes the print.
import {el, newId, replace} from '../../dom';
import {api, randomKey} from '../../api/client';
import type {Job} from '../../api/types';
import {icon} from '../../parts/icon';
import {numberField} from '../../parts/number-field';
import {problemBox} from '../../parts/problem';
import {toJob} from '../../route';
import {announce} from '../../state';
import {initialMoves, isMoved, laid, lying, move, patternOf, placed, previewPlace, redo, rowOf, same, toChart, toDrawing, undo, withPoints, type Flat, type Moves,
        type Placement, type PrintReport, type Row, type Wanted} from '../../state/result';
import type {Spot} from '../../scene/sheet';
import {number, t} from '../../text';
import {setResult, type Look, type Part} from './part';

const fields = [
  {name: 'x', unit: 'mm', reach: 50, step: 0.5, min: -500, max: 500},
  {name: 'y', unit: 'mm', reach: 50, step: 0.5, min: -500, max: 500},
  {name: 'turn', unit: '°', reach: 180, step: 1, min: -360, max: 360},
  {name: 'scale', unit: '', reach: 0.5, step: 0.01, min: 0.01, max: 100},
] as const;

// `stale`: the drawing has moved, so the files no longer match what is shown.
export function adjustView(job: Job, report: PrintReport, part: Part, stale: (stale: boolean) => void): HTMLElement {
  let moves: Moves = initialMoves(job), key = '', sending = false;
  const start = placed(moves), top = report.flattening.top_rest_mm, byElements = (report.coils ?? []).length > 0;
  // How the job's drawing lies on the chart. Where points placed it, that is read off the formed sheet, which is possible
  // with one chart without pins. Otherwise there is no preview.
  const pins = (job.settings['flattening']?.['pins'] ?? []) as unknown[];
  const known = start.points.length === 0 || (job.settings['pattern']?.['placement'] !== 'segments' && pins.length === 0);
  let home: Placement | null = start.points.length === 0 ? start : null;
  let lies: Placement | null = null;        // where the drawing is to lie; null: nobody knows
  let pending: Spot | null = null;          // the first point of a pair that is being added
  const spots = new Map<Row, Look['pairs'][number]>();

  const rows = fields.map(({name, unit, reach, step, min, max}) => {
    const id = newId('adjust'), label = t(`result.adjust_${name}`);
    const set = (value: number, lasting: boolean): void => {
      const to: Wanted = {...placed(moves), [name]: Number(value.toFixed(4))};
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
  const trouble = el('div'), fault = el('p', {class: 'fault', role: 'alert'});
  const list = el('ol', {class: 'pairs'}), onTop = el('p', {class: 'small'}, t('result.pairs_on_top'));
  const add = el('button', {type: 'button', class: 'in-3d', onclick: () => void addPair()}, icon('add'), t('result.pair_add'));

  function show(to: Wanted): void {
    fields.forEach(({name}, i) => rows[i]?.show(to[name]));
    onTop.hidden = to.points.length === 0;
    const misses = to.points.map(() => el('span', {class: 'quiet'}));
    replace(list, to.points.map((row, i) => pairItem(row, i, misses[i]!)));
    part.look((sheet) => {
      home ??= lying(sheet.chart(), sheet.having('sheet', top)?.pattern ?? [0, 0], start.scale) ?? start;
      const from = home, pairs = to.points.map((row) => {
        const [u, v, ...mold] = row, pair = spots.get(row) ?? {from: sheet.having('pattern', [u, v]), to: sheet.nearest(mold, true)};
        spots.set(row, pair);
        return pair;
      });
      const targets = pairs.map((pair): Flat => toChart(from, pair.to?.pattern ?? [0, 0])), lie = lies = known ? laid(to, targets) : null;
      fault.textContent = known && !lie ? t('result.pairs_no_direction') : '';
      if (lie && to.points.length > 1)
        to.points.forEach(([u, v], i) => {
          const [x, y] = toChart(lie, [u, v]), [a, b] = targets[i]!;
          misses[i]!.textContent = t('result.pair_miss', {mm: number(Math.hypot(x - a, y - b), 1)});
        });
      return {
        place: lie && !same(to, start) ? previewPlace(from, lie, top, sheet.picture.size, sheet.picture.origin) : null,
        pairs: !element.open ? [] : pending ? [...pairs, {from: pending, to: null}] : pairs};
    });
  }
  function pairItem(row: Row, i: number, miss: HTMLElement): HTMLElement {
    const [u, v, ...mold] = row, mm = (...values: number[]): string => values.map((value) => number(value, 1)).join('; ');
    const name = el('span', {class: 'hidden'}, ` ${i + 1}`);
    return el('li', null, el('span', null, t('result.pair_row', {drawn: mm(u, v), mold: mm(...mold)}), ' ', miss), el('span', {class: 'row'},
      el('button', {type: 'button', class: 'in-3d', onclick: () => part.showPlace(mold)}, icon('view'), t('job.show'), name.cloneNode(true)),
      el('button', {type: 'button', onclick: () => {
        const now = placed(moves);
        change(move(moves, withPoints(now, now.points.filter((one) => one !== row), lies)));
        back.focus();
      }}, icon('delete'), t('result.pair_remove'), name)));
  }
  async function addPair(): Promise<void> {
    if (!part.sheet()) return announce(t('result.loading_3d'));
    add.disabled = true;
    setResult({mode: 'with'});  // the drawing where it lies on the chart
    let drawn: Flat | null = null, row: Row | null = null, wrong = '';
    while (!row) {
      const spot: Spot | null | undefined = await part.ask(wrong + t(drawn ? 'result.pair_to' : 'result.pair_from'));
      if (spot === undefined) break;
      wrong = spot?.pattern ? '' : `${t('result.pair_nothing')} `;
      if (!spot?.pattern) continue;
      if (drawn) row = rowOf(drawn, spot.point);
      else {
        drawn = lies && home ? toDrawing(lies, toChart(home, spot.pattern)) : spot.pattern;
        pending = spot;
        show(placed(moves));
      }
    }
    pending = null;
    add.disabled = false;
    const now = placed(moves);
    if (row) {
      change(move(moves, withPoints(now, [...now.points, row], lies)));
      announce(t('result.pair_added'));
    } else {
      show(now);
      add.focus();
    }
  }
  function change(to: Moves): void {
    moves = to;
    key = '';
    show(placed(moves));
    const moved = isMoved(moves);
    back.disabled = moves.at === 0;
    again.disabled = moves.at === moves.steps.length - 1;
    reset.disabled = !moved;
    apply.disabled = !moved || fault.textContent !== '';
    stale(moved);
  }
  async function send(): Promise<void> {
    if (sending) return;
    sending = apply.disabled = true;
    // one key for one placement: a request that is sent twice makes one job
    key ||= randomKey();
    const form = new FormData();
    form.set('from', job.id);
    form.set('settings', JSON.stringify({pattern: patternOf(placed(moves))}));
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
  const element = el('details', {class: 'card', ontoggle: () => show(placed(moves))}, el('summary', null, t('result.adjust')), el('div', {class: 'adjust', onkeydown: (event) => {
    if (!event.ctrlKey || event.key.toLowerCase() !== 'z' || (event.target as HTMLInputElement).type === 'text') return;
    event.preventDefault();
    change(event.shiftKey ? redo(moves) : undo(moves));
  }},
    el('p', {class: 'small'}, t(byElements ? 'result.adjust_elements' : 'result.adjust_preview')), onTop,
    el('div', {class: 'adjust-fields'}, ...rows.map((row) => row.element)),
    el('h3', null, t('result.pairs')), el('p', {class: 'small'}, t('result.pairs_how'), !known && ` ${t('result.pairs_no_preview')}`), list,
    el('p', {class: 'small not-in-3d'}, t('result.pairs_flat')), fault,
    el('div', {class: 'row'}, add, back, again, reset, apply), trouble));
  change(moves);
  return element;
}
