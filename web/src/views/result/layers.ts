// The layers of a print in several steps: which are shown, on the part and on the flat sheet.
import {el, svg, type Children} from '../../dom';
import {api} from '../../api/client';
import type {Job} from '../../api/types';
import {farthestFirst, fillOf, layersOf, tintOf, withLayer, type Layer} from '../../state/array';
import {inkOf, type LayerInk} from '../../state/ink';
import type {PrintReport, ResultState} from '../../state/result';
import {store} from '../../state';
import {t} from '../../text';

export interface Layers {
  all: readonly Layer[];  // in the order of printing; empty for a print of one layer
  text(name: string): Promise<string>;  // the SVG of one, asked for once
  inks(): Promise<ReadonlyMap<string, LayerInk>>;  // of all
}

export function layersOfJob(job: Job, report: PrintReport): Layers {
  const all = layersOf(job.artifacts, report.print.inked_face), texts = new Map<string, Promise<string>>();
  let inks: Promise<ReadonlyMap<string, LayerInk>> | null = null;
  const text = (name: string): Promise<string> => {
    const asked = texts.get(name) ?? api.artifact(job.id, `${name}.svg`).then((answer) => answer.text());
    texts.set(name, asked);
    asked.catch(() => texts.delete(name));  // asked for again the next time
    return asked;
  };
  return {
    all, text,
    inks() {
      inks ??= Promise.all(all.map(async ({name}) => [name, inkOf(await text(name))] as const)).then((found) => new Map(found));
      inks.catch(() => { inks = null; });
      return inks;
    },
  };
}

// "Step 2: dielectric ink, outer face"
export const layerWords = ({number, step, face}: Layer): string =>
  t('array.layer', {number, ink: t(`array.ink_${step}`), face: t(`array.face_${face}`)});

const swatch = (layer: Layer): SVGElement => {
  const {colour, opacity} = tintOf(layer);
  return svg('svg', {class: 'layer-swatch', viewBox: '0 0 28 20', 'aria-hidden': 'true', focusable: 'false'},
    svg('rect', {width: 28, height: 20, fill: '#fff'}), svg('rect', {x: 4, y: 4, width: 20, height: 12, fill: colour, 'fill-opacity': opacity}));
};

export interface LayerList {
  element: HTMLElement;
  show(hidden: readonly string[]): void;
}

// Checkboxes, one for each layer. `change` gets the names of the hidden ones.
export function layerList({all}: Layers, hint: string, change: (hidden: string[]) => void): LayerList {
  const boxes = all.map((layer) => el('input', {type: 'checkbox', value: layer.name, onchange: (event) =>
    change(withLayer(store.get().result.hidden, layer.name, (event.currentTarget as HTMLInputElement).checked))}));
  const element = el('fieldset', {class: 'layers'}, el('legend', null, t('array.layers')),
    all.map((layer, i): Children => el('label', {class: 'choice'}, boxes[i], swatch(layer), layerWords(layer))),
    el('p', {class: 'small quiet'}, hint));
  return {
    element,
    show(hidden) {
      for (const box of boxes) box.checked = !hidden.includes(box.value);
    },
  };
}

// Whether all layers are shown: then the part has the picture of the print as it is.
export const allShown = ({all}: Layers, {hidden}: Pick<ResultState, 'hidden'>): boolean => !all.some(({name}) => hidden.includes(name));

// Draws the ink that is shown, in millimetres of the sheet, t up.
export function paintInk(context: CanvasRenderingContext2D, {all}: Layers, inks: ReadonlyMap<string, LayerInk>, hidden: readonly string[]): void {
  context.scale(1, -1);
  for (const layer of farthestFirst(all, 'outer')) {
    if (hidden.includes(layer.name)) continue;
    const {opacity} = tintOf(layer);
    for (const path of inks.get(layer.name)?.paths ?? []) {
      context.fillStyle = fillOf(layer, path.fill);
      context.globalAlpha = opacity * path.opacity;
      context.fill(new Path2D(path.d), path.evenOdd ? 'evenodd' : 'nonzero');
    }
  }
  context.globalAlpha = 1;
}
