// The flat print as a picture. What must be true when it is printed stands beside the downloads, see job.ts.
import {el, jumpTo, svg, type Children} from '../../dom';
import type {Job} from '../../api/types';
import {icon} from '../../parts/icon';
import {later, pictureOf} from '../../parts/later';
import {farthestFirst, fillOf, tintOf, type Layer} from '../../state/array';
import {marksOnly, pageOf, type LayerInk, type Page} from '../../state/ink';
import type {PrintReport} from '../../state/result';
import {t} from '../../text';
import {layerList, type Layers} from './layers';

export interface PrintSheet {
  element: HTMLElement;
  show(hidden: readonly string[]): void;
}

function inkGroup(layer: Layer, {paths, numbers}: LayerInk, mirrored: boolean): SVGElement {
  const {colour, opacity} = tintOf(layer);
  return svg('g', {'data-layer': layer.name, fill: colour},
    svg('g', mirrored ? {transform: 'scale(-1 1)'} : {}, ...paths.map((path) => svg('path', {
      d: path.d, fill: fillOf(layer, path.fill), 'fill-opacity': opacity * path.opacity, ...(path.evenOdd && {'fill-rule': 'evenodd'})}))),
    ...numbers.map(({x, y, size, text}) => svg('text', {x: mirrored ? -x : x, y, 'font-size': size, 'text-anchor': 'middle'}, text)));
}

// All layers on one page, each where it lies on the sheet: those of the other face are seen through it. `change`: of the hidden ones.
export function printSheet(job: Job, report: PrintReport, layers: Layers, change: (hidden: string[]) => void): PrintSheet {
  const sheet = job.settings['sheet'] ?? {}, size = {width: Number(sheet['width_mm']), height: Number(sheet['height_mm'])};
  const alt = t(report.print.mirrored ? 'result.sheet_alt_mirrored' : 'result.sheet_alt');
  const list = layers.all.length > 0 ? layerList(layers, t('array.layers_sheet'), change) : null;
  let hidden: readonly string[] = [];
  const groups: SVGElement[] = [];
  const apply = (): void => {
    for (const group of groups) group.style.display = hidden.includes(group.dataset['layer'] ?? '') ? 'none' : '';
  };
  function stacked(inks: ReadonlyMap<string, LayerInk>, {box, mirrored}: Page): SVGElement {
    // a mirrored page is seen from the inner face
    groups.splice(0, groups.length, ...farthestFirst(layers.all, mirrored ? 'inner' : 'outer').map((layer) =>
      inkGroup(layer, inks.get(layer.name) ?? {paths: [], numbers: []}, mirrored)));
    apply();
    return svg('svg', {class: 'sheet-layers', viewBox: box.join(' '), role: 'img', 'aria-label': t('array.sheet_alt')}, ...groups);
  }
  const load = async (): Promise<Children> => {
    const text = await layers.text('print');
    if (!list) return pictureOf(text, alt);
    return [pictureOf(marksOnly(text), ''), stacked(await layers.inks(), pageOf(text))];
  };
  const element = el('div', {class: 'sheet-view'},
    el('figure', {class: 'card result-sheet'},
      el('div', {class: list ? 'sheet-picture in-layers' : 'sheet-picture'}, later(load, (picture) => picture)),
      el('figcaption', null,
        el('p', {class: 'small quiet'}, t(list ? 'array.sheet_caption' : 'result.sheet_caption', size)),
        el('button', {type: 'button', onclick: () => jumpTo('printing')}, icon('down'), t('job.before_print')))),
    list && el('section', {class: 'card'}, list.element));
  return {
    element,
    show(now) {
      hidden = now;
      list?.show(now);
      apply();
    },
  };
}
