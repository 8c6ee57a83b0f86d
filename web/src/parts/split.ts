// A divider over a picture: a range field as wide as the picture, with a line through its thumb.
import {el} from '../dom';

export interface Split {
  element: HTMLElement;
  set(share: number): void;
}

const thumb = 44;  // px, as in the style

// `share`: of the width that lies left of the divider. `spoken` says in words what a share means.
export function split(options: {label: string; left: string; right: string; spoken: (share: number) => string;
                                change: (share: number) => void}): Split {
  const line = el('div', {class: 'split-line'});
  const left = el('span', {class: 'split-left'}, options.left), right = el('span', {class: 'split-right'}, options.right);
  const range = el('input', {type: 'range', min: 0, max: 100, step: 1, class: 'split-range', 'aria-label': options.label,
    oninput: () => {
      show(range.valueAsNumber / 100);
      options.change(lineShare(range.valueAsNumber / 100));
    }});
  const element = el('div', {class: 'split'}, line, left, right, range);
  // The thumb does not reach the ends; the line goes through its middle, and all the way at the ends.
  const lineShare = (value: number): number => {
    const width = element.clientWidth || 1;
    return value <= 0 ? 0 : value >= 1 ? 1 : (thumb / 2 + value * (width - thumb)) / width;
  };
  function show(value: number): void {
    line.style.left = `${100 * lineShare(value)}%`;
    range.setAttribute('aria-valuetext', options.spoken(value));
    left.hidden = value < 0.15;
    right.hidden = value > 0.85;
  }
  return {
    element,
    set(share) {
      const width = element.clientWidth || 1;
      range.value = String(Math.round(100 * (share <= 0 ? 0 : share >= 1 ? 1 : (share * width - thumb / 2) / (width - thumb))));
      show(range.valueAsNumber / 100);
    },
  };
}
