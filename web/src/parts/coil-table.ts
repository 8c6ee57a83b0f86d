// The coils with their figures: the worst first, sortable, one of them selected. On a phone each row is a card.
import {el, replace} from '../dom';
import {columns, sorted, type Coil, type Column} from '../state/result';
import {number, percent, t} from '../text';
import {icon} from './icon';

export interface CoilTable {
  element: HTMLElement;
  select(ids: readonly string[]): void;
}

export function coilTable(coils: readonly Coil[], chosen: (coil: Coil) => void): CoilTable {
  let by: Column = 'round', down = true, selected: readonly string[] = [];
  const body = el('tbody');
  const heads = columns.map((column) => el('th', {scope: 'col', class: column === 'id' ? '' : 'number'},
    el('button', {type: 'button', class: 'plain', onclick: () => {
      down = by === column ? !down : column !== 'id';
      by = column;
      fill();
    }}, t(`result.coil_${column}`), icon('sort'))));
  const sort = el('select', {onchange: () => {
    by = columns[sort.selectedIndex] ?? by;
    down = by !== 'id';
    fill();
  }}, columns.map((column) => el('option', null, t(`result.coil_${column}`))));
  const signed = (share: number): string => {
    const size = percent(Math.abs(share), 1);
    return size === percent(0, 1) ? size : `${share < 0 ? '−' : '+'}${size}`;
  };
  const row = (coil: Coil): HTMLElement =>
    el('tr', {'aria-selected': String(selected.includes(coil.id)), onclick: () => chosen(coil)},
      el('th', {scope: 'row'}, el('button', {type: 'button', id: `row-${coil.id}`, class: 'plain', 'aria-pressed': String(selected.includes(coil.id))}, coil.id),
        !coil.onHead && el('span', {class: 'state'}, t('result.off_head'))),
      el('td', {class: 'number'}, t('result.diameter_of', {made: number(coil.diameter, 1), drawn: number(coil.drawn, 1)})),
      el('td', {class: 'number'}, percent(coil.round, 1), coil.roundWithout !== null &&
        el('span', {class: 'quiet'}, ' ', t('result.instead_of', {value: percent(coil.roundWithout, 1)}))),
      el('td', {class: 'number'}, signed(coil.areaError), el('span', {class: 'quiet'}, ` ${number(coil.area, 0)} mm²`)),
      el('td', {class: 'number'}, signed(coil.stretch)),
      el('td', {class: 'number'}, number(coil.inductance, 1)),
      el('td', {class: 'number neighbours'}, ...(coil.neighbours.length === 0 ? ['–'] : coil.neighbours.map(({id, k}) =>
        el('span', null, el('span', {class: 'quiet'}, id), ` ${number(k, 3).replace('-', '−')}`)))));
  function fill(): void {
    heads.forEach((head, i) => {
      if (columns[i] === by) head.setAttribute('aria-sort', down ? 'descending' : 'ascending');
      else head.removeAttribute('aria-sort');
    });
    sort.selectedIndex = columns.indexOf(by);
    replace(body, sorted(coils, by, down).map(row));
    for (const {cells} of body.rows) columns.forEach((column, i) => cells[i]?.setAttribute('data-name', t(`result.coil_${column}`)));
  }
  fill();
  const box = el('div', {class: 'wide', tabindex: 0, role: 'region', 'aria-label': t('result.coils')},
    el('table', {class: 'coil-table', 'aria-label': t('result.coils')}, el('thead', null, el('tr', null, ...heads)), body));
  return {
    element: el('div', null, el('p', {class: 'small quiet'}, t('result.coils_caption')),
      el('label', {class: 'coil-sort'}, t('result.coil_sort'), sort), box),
    select(ids) {
      if (ids.join() === selected.join()) return;
      selected = ids;
      fill();
      const chosenRow = body.querySelector<HTMLElement>('[aria-selected="true"]');
      if (!chosenRow) return;
      const top = chosenRow.offsetTop - box.scrollTop;
      if (top < 60 || top + chosenRow.offsetHeight > box.clientHeight) box.scrollTop = chosenRow.offsetTop - box.clientHeight / 2;
    },
  };
}
