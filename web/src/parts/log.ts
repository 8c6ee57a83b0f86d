// The log of a job, on demand. It follows the newest line unless the person has scrolled up.
import {el} from '../dom';
import type {LogLine} from '../api/types';
import {t} from '../text';

// `opened`: called when the person asks for the log for the first time.
export function logPart(opened: () => void): {element: HTMLElement; show(lines: readonly LogLine[]): void} {
  const clock = new Intl.DateTimeFormat('de', {timeStyle: 'medium'});  // 24 hours in every language
  const list = el('ol', {class: 'log', tabindex: 0, 'aria-label': t('job.log')});
  let lines: readonly LogLine[] = [];
  let shown = 0;
  function draw(): void {
    if (!element.open) return;
    const atEnd = list.scrollHeight - list.scrollTop - list.clientHeight < 40;
    if (shown > lines.length) shown = 0, list.replaceChildren();
    list.append(...lines.slice(shown).map((line) =>
      el('li', null, el('time', {datetime: line.time}, clock.format(new Date(line.time))), ' ', line.text)));
    shown = lines.length;
    if (atEnd) list.scrollTop = list.scrollHeight;
  }
  let asked = false;
  const element = el('details', {ontoggle: () => {
    if (element.open && !asked) {
      asked = true;
      opened();
    }
    draw();
  }}, el('summary', null, t('job.log')), list);
  return {element, show: (now) => { lines = now; draw(); }};
}
