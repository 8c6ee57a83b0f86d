// The key figures of a print, large and in plain words.
import {el, type Child} from '../../dom';
import {compared, type PrintReport} from '../../state/result';
import {number, percent, t, withUnit} from '../../text';

const figure = (name: string, value: string, ...more: Child[]): HTMLElement =>
  el('div', {class: 'card key-figure'}, el('dt', null, name), el('dd', null, el('span', {class: 'figure'}, value),
    el('span', {class: 'small quiet'}, ...more)));

export function keyFigures(report: PrintReport): HTMLElement {
  const {with: made, without, } = report.figures, coils = made.coils, both = compared(report);
  const round = coils?.mean_circularity, area = coils?.mean_area_error, pair = coils?.strongest_pair;
  // The same coils are compared; where not all of them count, the figures say which.
  const against = (pair: [number, number] | null | undefined): Child => pair && both
    ? both.same ? t('result.without', {value: percent(pair[1], 1)})
      : t('result.without_of', {count: both.count, made: percent(pair[0], 1), drawn: percent(pair[1], 1)})
    : t('result.not_compared');
  const {least_mm: least, least_ratio: ratio} = report.thickness;
  return el('dl', {class: 'key-figures', 'aria-label': t('result.key_figures')},
    typeof round === 'number'
      ? figure(t('result.out_of_round'), percent(round, 1),
          t('result.mean_of', {count: coils?.on_head ?? 0}), ' ', against(both?.round))
      : figure(t('result.shape_error'), percent(made.shape.mean - 1, 1),
          t('result.without', {value: percent(without.shape.mean - 1, 1)})),
    typeof area === 'number'
      ? figure(t('result.area_off'), percent(area, 1),
          t('result.mean_of', {count: coils?.on_head ?? 0}), ' ', against(both?.area))
      : figure(t('result.area_off'), percent(made.area.mean - 1, 1),
          t('result.without', {value: percent(without.area.mean - 1, 1)})),
    figure(t('result.thinnest'), withUnit(least, 'mm', 2), t('result.thinnest_of', {share: percent(ratio), flat: withUnit(report.thickness.initial_mm, 'mm')})),
    pair && figure(t('result.strongest'), number(Math.abs(pair.k), 3), t('result.strongest_of', {a: pair.coils[0], b: pair.coils[1]})));
}
