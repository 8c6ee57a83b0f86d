// The choice of how loops that cross are parted (coils.build), each way with a picture and a sentence.
import {el, svg} from '../dom';
import {textIfKnown} from '../text';
import {choiceOf} from './words';

// As the layers of a print are shown: conductors of two faces, dielectric, bridges; on paper.
const colours = {first: '#1a1a1a', other: '#2659bf', dielectric: '#40a666', bridge: '#cc590d', bare: '#fff'};

const ring = (x: number, colour: string, more: Record<string, string | number> = {}): SVGElement =>
  svg('circle', {cx: x, cy: 40, r: 26, fill: 'none', stroke: colour, 'stroke-width': 5, ...more});

// Where the circles meet, and at which angle to the horizontal the right one runs there.
const crossings = [{y: 20.3, angle: -41}, {y: 59.7, angle: 41}];
const bar = (y: number, angle: number, length: number, width: number, fill: string): SVGElement =>
  svg('rect', {x: 70 - length / 2, y: y - width / 2, width: length, height: width, fill, transform: `rotate(${angle} 70 ${y})`});

const bridges = (): SVGElement[] => crossings.flatMap(({y, angle}) => [
  bar(y, angle, 20, 6, colours.bare),             // the interrupted loop
  bar(y, -angle, 16, 5, colours.first),           // the one that goes through
  bar(y, angle, 13, 11, colours.dielectric),
  bar(y, angle, 26, 4, colours.bridge)]);

const drawings: Record<string, () => SVGElement[]> = {
  single: () => [ring(53, colours.first), ring(87, colours.first)],
  two_faces: () => [ring(87, colours.other), ring(53, colours.first)],
  bridges: () => [ring(87, colours.first), ring(53, colours.first), ...bridges()],
};
export const hasPictures = (id: string): boolean => id === 'coils.build';

export interface PictureChoice {
  element: HTMLElement;
  target(): HTMLElement;  // what takes the focus
  show(value: string): void;
}

// `legend`: what names the group. `name`: of the radio buttons, its own for each form.
export function pictureChoice(options: {id: string; name: string; legend: HTMLElement; values: readonly string[]; describedBy: string;
                                        change: (value: string) => void}): PictureChoice {
  const inputs = options.values.map((value, i) => el('input', {type: 'radio', name: options.name, value, ...(i === 0 && {id: options.name}),
    'aria-labelledby': `${options.name}-${value}-name`, 'aria-describedby': `${options.name}-${value}`, onchange: () => options.change(value)}));
  const element = el('fieldset', {class: 'picture-choice', 'aria-describedby': options.describedBy}, options.legend,
    el('div', {class: 'pictures-of-choice'}, ...options.values.map((value, i) => el('label', {class: 'profile'},
      svg('svg', {class: 'choice-picture', viewBox: '18 6 104 68', 'aria-hidden': 'true', focusable: 'false'},
        svg('rect', {x: 18, y: 6, width: 104, height: 68, fill: colours.bare}), ...drawings[value]?.() ?? []),
      el('span', {class: 'choice'}, inputs[i], el('span', {id: `${options.name}-${value}-name`}, choiceOf(options.id, value))),
      el('span', {class: 'quiet small', id: `${options.name}-${value}`}, textIfKnown(`choice.${options.id}.${value}.hint`))))));
  return {
    element,
    target: () => inputs.find(({checked}) => checked) ?? inputs[0] ?? element,
    show(value) {
      for (const input of inputs) input.checked = input.value === value;
    },
  };
}
