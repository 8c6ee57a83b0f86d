// The colours of a map with their values. Values outside of the range have an arrow; a marker shows the value that is read.
import {el} from '../dom';
import {number} from '../text';

export interface LegendOptions {
  title: string;
  unit: string;
  found?: string;              // the values that there are
  low: number;
  high: number;
  marks: readonly number[];
  colours: readonly string[];  // evenly over the range
  below: string;               // what lies below the range: for screen readers and as a tip; empty: nothing can
  above: string;
  limit?: number | undefined;  // the tolerance, and what it is called
  limitText?: string;
}

export interface Legend {
  element: HTMLElement;
  mark(value: number | null): void;
}

export function legend(options: LegendOptions): Legend {
  const {low, high, unit, marks, colours} = options;
  const share = (value: number): number => Math.min(1, Math.max(0, (value - low) / (high - low)));
  const digits = Math.max(0, ...marks.map((mark) => (String(mark).split('.')[1] ?? '').length));
  const bar = el('div', {class: 'legend-bar'});
  bar.style.background = `linear-gradient(to right, ${colours.join(', ')})`;
  const end = (side: 'below' | 'above', colour: string | undefined): HTMLElement | false => {
    if (!options[side]) return false;
    const arrow = el('span', {class: `legend-${side}`, role: 'img', 'aria-label': options[side], title: options[side]});
    arrow.style.setProperty('--end', colour ?? '');
    return arrow;
  };
  const at = (element: HTMLElement, value: number): HTMLElement => {
    element.style.left = `${100 * share(value)}%`;
    return element;
  };
  const marker = el('span', {class: 'legend-marker', hidden: true});
  // Where there are many, the style leaves out every second number.
  const scale = el('div', {class: 'legend-scale'}, ...marks.map((mark) => at(el('span', null, number(mark, digits)), mark)));
  const within = options.limit !== undefined && options.limit > low && options.limit < high;
  const element = el('figure', {class: 'legend'},
    el('figcaption', null, options.title, unit && ` (${unit})`, options.found && `: ${options.found}`),
    el('div', {class: 'legend-row'},
      end('below', colours[0]),
      el('div', {class: 'legend-body'}, bar, within && at(el('span', {class: 'legend-limit'}), options.limit ?? low), marker, scale),
      end('above', colours.at(-1))),
    within && el('p', {class: 'small quiet'}, el('span', {class: 'legend-limit-key', 'aria-hidden': 'true'}), options.limitText ?? ''));
  return {
    element,
    mark(value) {
      marker.hidden = value === null;
      if (value !== null) at(marker, value);
    },
  };
}

// A map of two or three kinds of places.
export const kindsLegend = (title: string, kinds: readonly {text: string; colour: string; hatched?: boolean}[]): HTMLElement =>
  el('figure', {class: 'legend'}, el('figcaption', null, title), el('ul', {class: 'legend-kinds'}, ...kinds.map((kind) => {
    const swatch = el('span', {class: kind.hatched ? 'swatch hatched' : 'swatch'});
    swatch.style.backgroundColor = kind.colour;
    return el('li', null, swatch, kind.text);
  })));
