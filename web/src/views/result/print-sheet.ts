// The flat print as a picture. What must be true when it is printed stands beside the downloads, see job.ts.
import {el, jumpTo} from '../../dom';
import type {Job} from '../../api/types';
import {icon} from '../../parts/icon';
import {later, svgPicture} from '../../parts/later';
import type {PrintReport} from '../../state/result';
import {t} from '../../text';

export function printSheet(job: Job, report: PrintReport): HTMLElement {
  const sheet = job.settings['sheet'] ?? {}, alt = t(report.print.mirrored ? 'result.sheet_alt_mirrored' : 'result.sheet_alt');
  return el('figure', {class: 'card result-sheet'},
    el('div', {class: 'sheet-picture'}, later(() => svgPicture(job.id, 'print.svg', alt), (image) => image)),
    el('figcaption', null,
      el('p', {class: 'small quiet'}, t('result.sheet_caption', {width: Number(sheet['width_mm']), height: Number(sheet['height_mm'])})),
      el('button', {type: 'button', onclick: () => jumpTo('printing')}, icon('down'), t('job.before_print'))));
}
