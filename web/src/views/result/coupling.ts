// The coupling coefficients of every two loops as a table of colours with numbers. A cell selects its two loops.
import {el, type Children} from '../../dom';
import {legend} from '../../parts/legend';
import {colourAt, css} from '../../scene/colour';
import {stepped, strongest, type Couplings} from '../../state/array';
import {number, t} from '../../text';

// From the strongest that is expected with one sign to that with the other. It is the same for all jobs, so that two compare.
const most = 0.05;
const colours = ['#2166ac', '#67a9cf', '#d1e5f0', '#f7f7f7', '#fddbc7', '#ef8a62', '#b2182b'];

const signed = (value: number, digits: number): string => number(value, digits).replace('-', '−').replace(/^−(0([.,]0*)?)$/, '$1');

// Black or white, whichever is read better on a colour.
function inkOn(colour: readonly number[]): string {
  const [r = 0, g = 0, b = 0] = colour.map((part) => part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b > 0.179 ? '#000' : '#fff';
}

export interface CouplingMap {
  element: HTMLElement;
  select(coils: readonly string[]): void;
}

export function couplingMap(couplings: Couplings, chosen: (pair: [string, string]) => void): CouplingMap {
  const {coils, k} = couplings, first = strongest(couplings);
  const key = legend({
    title: t('array.k'), unit: '', low: -most, high: most, marks: [-0.04, -0.02, 0, 0.02, 0.04], colours,
    below: t('result.below', {value: signed(-most, 2)}), above: t('result.above', {value: signed(most, 2)})});
  const reading = el('p', {class: 'coupling-reading'});
  // Of two loops: k, in thousandths for the cell, and in words.
  const texts = (a: number, b: number): {a: string; b: string; k: string; thousandths: string} => {
    const value = k[a]?.[b], known = typeof value === 'number';
    return {a: coils[a] ?? '', b: coils[b] ?? '', k: known ? signed(value, 4) : '–', thousandths: known ? signed(1000 * value, 0) : '–'};
  };
  const read = (a: number, b: number): void => {
    reading.textContent = t('array.pair', texts(a, b));
    key.mark(k[a]?.[b] ?? null);
  };
  const cells: (HTMLElement | null)[][] = coils.map((_, a) => coils.map((_, b) => {
    if (a === b) return null;
    const value = k[a]?.[b], text = texts(a, b);
    const cell = el('td', {role: 'gridcell', tabindex: a === first[0] && b === first[1] ? 0 : -1, 'aria-label': t('array.cell', text), 'aria-selected': 'false'},
                    text.thousandths);
    if (typeof value === 'number') {
      const colour = colourAt({colours}, (value + most) / (2 * most));
      cell.style.backgroundColor = css(colour);
      cell.style.color = inkOn(colour);
    }
    return cell;
  }));
  // One cell is reached with Tab, the others from it with the arrows.
  let stop = cells[first[0]]?.[first[1]];
  function goTo(a: number, b: number): HTMLElement | null | undefined {
    stop?.setAttribute('tabindex', '-1');
    stop = cells[a]?.[b];
    stop?.setAttribute('tabindex', '0');
    return stop;
  }
  function choose(a: number, b: number): void {
    goTo(a, b);
    chosen([coils[a] ?? '', coils[b] ?? '']);
  }
  function onKey(event: KeyboardEvent, a: number, b: number): void {
    const next = stepped([a, b], event.key, coils.length);
    if (next) goTo(...next)?.focus();
    else if (event.key === 'Enter' || event.key === ' ') choose(a, b);
    else return;
    event.preventDefault();
  }
  // The listeners are those of the table: there may be thousands of cells.
  const at = (event: Event, act: (a: number, b: number) => void): void => {
    const cell = event.target instanceof Element ? event.target.closest('td') : null, row = cell?.parentElement;
    if (cell && row instanceof HTMLTableRowElement && cells[row.sectionRowIndex]?.[cell.cellIndex - 1]) act(row.sectionRowIndex, cell.cellIndex - 1);
  };
  const rows = coils.map((id, a): Children => el('tr', null, el('th', {scope: 'row'}, id),
    ...(cells[a] ?? []).map((cell) => cell ?? el('td', {role: 'gridcell', class: 'same'}, el('span', {class: 'hidden'}, t('array.same'))))));
  const body = el('tbody', {
    onclick: (event) => at(event, choose), onfocusin: (event) => at(event, read), onpointerover: (event) => at(event, read),
    onkeydown: (event) => at(event, (a, b) => onKey(event, a, b))}, ...rows);
  let marked: HTMLElement[] = [];
  read(...first);
  return {
    element: el('section', {class: 'card coupling'},
      el('h3', null, t('array.coupling')), el('p', {class: 'small quiet'}, t('array.coupling_hint')),
      el('div', {class: 'coupling-head'}, reading, key.element),
      el('div', {class: 'wide', role: 'group', 'aria-label': t('array.coupling')},
        el('table', {role: 'grid', 'aria-label': t('array.coupling'), class: 'coupling-map'},
          el('thead', null, el('tr', null, el('td', null), ...coils.map((id) => el('th', {scope: 'col'}, el('span', null, id))))),
          body))),
    select([coil = '', other = '']) {
      const a = coils.indexOf(coil), b = coils.indexOf(other);
      for (const cell of marked) cell.setAttribute('aria-selected', 'false');
      marked = b < 0 ? [] : [cells[a]?.[b], cells[b]?.[a]].flatMap((cell) => cell ?? []);
      for (const cell of marked) cell.setAttribute('aria-selected', 'true');
      if (a >= 0 && b >= 0) read(a, b);
    },
  };
}
