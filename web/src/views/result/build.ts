// How the array is made: the steps of printing in their order, and what to solder. Made to be printed and ticked off.
import {el, replace, type Children} from '../../dom';
import {artifactPath} from '../../api/client';
import type {Job} from '../../api/types';
import {band} from '../../parts/band';
import {icon} from '../../parts/icon';
import {gapsOf, type Gap, type Layer} from '../../state/array';
import type {PrintReport} from '../../state/result';
import {number, t, withUnit} from '../../text';
import {layerWords, type Layers} from './layers';

type Place = readonly [number, number, number];

const file = (job: Job, name: string): HTMLElement => el('a', {href: artifactPath(job.id, name), download: true}, name);

function layerStep(job: Job, layer: Layer): HTMLElement {
  // print.pdf has a page for each step
  const alone = layer.name === 'print' ? 'print.svg' : `${layer.name}.pdf`;
  return el('li', null, el('strong', null, layerWords(layer)),
    el('p', null, t(layer.face === 'inner' ? 'array.page_mirrored' : 'array.page', {number: layer.number}), ' ', file(job, 'print.pdf'), '. ',
      t('array.alone'), ' ', file(job, alone), '. '),
    el('p', null, t('array.dry')));
}

function checklist(job: Job, layers: readonly Layer[], gaps: readonly Gap[]): HTMLElement {
  const ports = gaps.filter(({port}) => port).length, printed = gaps.filter((gap) => gap.printed).length;
  const tails = gaps.filter(({tail}) => tail > 0).length;
  const turn = (layer: Layer, i: number): Children =>
    layer.reverse && !layers[i - 1]?.reverse && el('li', null, el('strong', null, t('array.turn')), el('p', null, t('array.turn_how')));
  return el('ol', {class: 'build-steps'},
    layers.map((layer, i): Children => [turn(layer, i), layerStep(job, layer)]),
    el('li', null, el('strong', null, t('array.form')), el('p', null, t('array.form_how'))),
    gaps.length > 0 && el('li', null, el('strong', null, t('array.solder')),
      el('p', null, t('array.solder_count', {capacitors: gaps.length - ports - printed, ports}))),
    tails > 0 && el('li', null, el('strong', null, t('array.cables')), el('p', null, t('array.cables_how', {tails}))));
}

const pf = (value: number, digits?: number): string => value > 0 ? number(value, digits) : '–';
const value = (gap: Gap): string => gap.printed ? `${pf(gap.value, 2)} ± ${number(gap.value * gap.tolerance, 2)}` : pf(gap.value);
const part = ({port, printed, tail}: Gap): string => tail > 0 ? t('array.port_tail', {length: withUnit(tail, 'mm', 0)}) : t(port ? 'array.port' : printed ? 'array.printed' : 'array.capacitor');

function gapTable(gaps: readonly Gap[], show: (gap: Gap) => void): {element: HTMLElement; select(number: number): void} {
  const rows = new Map<number, HTMLTableRowElement>();
  const body = el('tbody', null, ...gaps.map((gap) => {
    const row = el('tr', {'aria-selected': 'false', onclick: () => show(gap)},
      el('td', {class: 'tick'}, el('span', {class: 'tick-box'})),
      el('th', {scope: 'row', class: 'number'}, String(gap.number)), el('td', null, gap.loop), el('td', null, t(`array.face_${gap.face}`)),
      el('td', null, part(gap)),
      el('td', {class: 'number'}, el('strong', null, value(gap))), el('td', {class: 'number quiet'}, pf(gap.wanted, 2)),
      ...gap.place.map((mm) => el('td', {class: 'number'}, number(mm, 1).replace('-', '−'))),
      el('td', {class: 'no-paper'}, el('button', {type: 'button', class: 'plain icon-only', 'aria-label': t('array.show_gap', {number: gap.number}),
        title: t('array.show_gap', {number: gap.number})}, icon('view'))));
    rows.set(gap.number, row);
    return row;
  }));
  const head = (text: string, figures = false): HTMLElement => el('th', {scope: 'col', class: figures ? 'number' : ''}, text);
  return {
    element: el('table', {class: 'gap-table', 'aria-label': t('array.solder_table')}, el('thead', null, el('tr', null,
      head(t('array.done')), head(t('array.number'), true), head(t('array.loop')), head(t('array.face')), head(t('array.part')),
      head(t('array.value'), true), head(t('array.computed'), true),
      ...['x', 'y', 'z'].map((axis) => head(`${axis}, mm`, true)),
      el('th', {scope: 'col', class: 'no-paper'}, el('span', {class: 'hidden'}, t('array.show'))))), body),
    select(chosen) {
      for (const [gap, row] of rows) row.setAttribute('aria-selected', String(gap === chosen));
    },
  };
}

// On paper stands a copy of the list with the name of the job, and nothing else of the page.
function onPaper(...content: Node[]): void {
  const sheet = el('div', {class: 'on-paper'}, ...content.map((node) => node.cloneNode(true)));
  document.body.append(sheet);
  document.body.classList.add('list-on-paper');
  addEventListener('afterprint', () => {
    sheet.remove();
    document.body.classList.remove('list-on-paper');
  }, {once: true});
  print();
}

export const isBuilt = (report: PrintReport, layers: Layers): boolean => layers.all.length > 0 || gapsOf(report).length > 0;

// `showPlace`: on the part.
export function buildView(job: Job, report: PrintReport, layers: Layers, showPlace: (place: Place) => void): HTMLElement {
  const gaps = gapsOf(report), mhz = report.circuits?.electrical?.frequency_mhz ?? 0;
  const table = gaps.length > 0 ? gapTable(gaps, (gap) => {
    table?.select(gap.number);
    showPlace(gap.place);
  }) : null;
  const one: Layer = {name: 'print', number: 1, step: 'conductor', face: report.print.inked_face === 'inner' ? 'inner' : 'outer', reverse: false};
  const list = el('div', {class: 'build stack'});
  replace(list, [
    el('section', {class: 'card'}, el('h3', null, t('array.steps')), el('p', {class: 'small quiet'}, t('array.steps_hint')),
      checklist(job, layers.all.length > 0 ? layers.all : [one], gaps)),
    table && el('section', {class: 'card'}, el('h3', null, t('array.solder_table')),
      el('p', {class: 'small quiet'}, t('array.solder_hint', {frequency: withUnit(mhz, 'MHz')})),
      el('div', {class: 'wide', tabindex: 0, role: 'group', 'aria-label': t('array.solder_table')}, table.element)),
  ]);
  return el('div', {class: 'stack'},
    el('p', {class: 'row'}, el('button', {type: 'button', class: 'primary', onclick: () =>
      onPaper(el('h2', null, t('array.list')), band(job, report), list)}, icon('print'), t('array.print_list')),
      table && file(job, 'coils.csv')),
    list);
}
