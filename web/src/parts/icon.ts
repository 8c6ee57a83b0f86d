// Icons of 24 x 24 units, drawn with strokes in the colour of the text.
import {svg} from '../dom';

const paths = {
  add: 'M12 5v14M5 12h14',
  back: 'M15 5l-7 7 7 7',
  cancel: 'M6 6l12 12M18 6L6 18',
  check: 'M4 12.5l5 5L20 6.5',
  compare: 'M12 3v18M4 6h5v12H4zM15 6h5v12h-5z',
  copy: 'M9 9h11v11H9zM5 15H4V4h11v1',
  delete: 'M4 7h16M9 7V4h6v3M6 7l1 13h10l1-13M10 11v5M14 11v5',
  down: 'M6 9l6 6 6-6',
  download: 'M12 4v11M7 11l5 5 5-5M5 20h14',
  error: 'M12 3.5a8.5 8.5 0 100 17 8.5 8.5 0 000-17zM12 7.5v5.5M12 16v.5',
  filter: 'M4 6h16M7 12h10M10 18h4',
  head: 'M12 3c-4 0-6.5 3-6.5 7 0 2.5 1 4 2 5.5.6 1 .5 2.5 1 4.5h7c.5-2 .4-3.5 1-4.5 1-1.500 2-3 2-5.500 0-4-2.500-7-6.500-7zM5.500 11h-1M19.500 11h-1',
  help: 'M12 3.5a8.5 8.5 0 100 17 8.5 8.5 0 000-17zM9.500 9.500a2.500 2.500 0 115 0c0 1.800-2.500 2-2.500 4M12 16.500v.5',
  info: 'M12 3.5a8.5 8.5 0 100 17 8.5 8.5 0 000-17zM12 11v5.500M12 7.500v.5',
  minus: 'M5 12h14',
  more: 'M5 12h.1M12 12h.1M19 12h.1',
  pause: 'M8 5v14M16 5v14',
  pattern: 'M8.500 5.500a4.500 4.500 0 100 9 4.500 4.500 0 000-9zM15.500 9.500a4.500 4.500 0 100 9 4.500 4.500 0 000-9z',
  print: 'M7 9V4h10v5M7 17H4V9h16v8h-3M7 14h10v6H7z',
  redo: 'M20 9H9a5 5 0 000 10h5M20 9l-4-4M20 9l-4 4',
  reset: 'M5 12a7 7 0 107-7c-2.500 0-4.500 1-6 3M5 4v4h4',
  resume: 'M8 5l11 7-11 7z',
  scan: 'M4 8V4h4M16 4h4v4M20 16v4h-4M8 20H4v-4M7 12h10',
  search: 'M10.500 4.500a6 6 0 100 12 6 6 0 000-12zM15 15l5 5',
  settings: 'M4 7h9M17 7h3M15 5v4M4 17h3M11 17h9M9 15v4',
  sort: 'M8 5v14M5 8l3-3 3 3M16 19V5M13 16l3 3 3-3',
  sun: 'M12 8a4 4 0 100 8 4 4 0 000-8zM12 2.500v2M12 19.500v2M2.500 12h2M19.500 12h2M5.300 5.300l1.400 1.400M17.300 17.300l1.400 1.400M5.300 18.700l1.400-1.400M17.300 6.700l1.400-1.400',
  undo: 'M4 9h11a5 5 0 010 10h-5M4 9l4-4M4 9l4 4',
  upload: 'M12 16V5M7 9l5-5 5 5M5 20h14',
  user: 'M12 4a4 4 0 100 8 4 4 0 000-8zM4.500 20c1-4 4-5.500 7.500-5.500s6.500 1.500 7.500 5.500',
  view: 'M2.500 12c2-4 5.500-6.500 9.500-6.500s7.500 2.500 9.500 6.500c-2 4-5.500 6.500-9.500 6.500s-7.500-2.500-9.500-6.500zM12 9a3 3 0 100 6 3 3 0 000-6z',
  warning: 'M12 4L2.500 20h19zM12 10v5M12 17.500v.3',
} as const;

export type IconName = keyof typeof paths;

// Hidden from screen readers: the text beside it, or the label of its button, says what it means.
export function icon(name: IconName): SVGElement {
  return svg('svg', {class: 'icon', viewBox: '0 0 24 24', 'aria-hidden': 'true', focusable: 'false'},
             svg('path', {d: paths[name]}));
}
