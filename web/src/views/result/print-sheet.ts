// The flat print, and what must be true when it is printed.
import {el, replace} from '../../dom';
import {api} from '../../api/client';
import type {Job} from '../../api/types';
import {problemBox} from '../../parts/problem';
import {rulerOf, type PrintReport} from '../../state/result';
import {number, t} from '../../text';

export function printSheet(job: Job, report: PrintReport, ends: (() => void)[]): HTMLElement {
  const {inked_face: face, mirrored} = report.print, sheet = job.settings['sheet'] ?? {};
  const inner = face === 'inner';
  const host = el('div', {class: 'sheet-picture'}, el('p', {class: 'quiet'}, t('shell.loading')));
  // The print itself. As a picture of a blob, nothing in it can run or load.
  async function load(): Promise<void> {
    try {
      const svg = await (await api.artifact(job.id, 'print.svg')).text(), mm = rulerOf(svg);
      const url = URL.createObjectURL(new Blob([svg], {type: 'image/svg+xml'}));
      ruler.textContent = mm === null ? t('result.rule_no_ruler') : t('result.rule_ruler', {mm: number(mm)});
      ends.push(() => URL.revokeObjectURL(url));
      replace(host, el('img', {src: url, alt: t(mirrored ? 'result.sheet_alt_mirrored' : 'result.sheet_alt')}));
    } catch (error) {
      replace(host, problemBox(error, () => void load()));
    }
  }
  const rule = (what: string): HTMLElement => el('li', null, what), ruler = rule(t('shell.loading'));
  void load();
  return el('div', {class: 'result-sheet'},
    el('figure', {class: 'card'}, host,
      el('figcaption', {class: 'small quiet'}, t('result.sheet_caption', {width: Number(sheet['width_mm']), height: Number(sheet['height_mm'])}))),
    el('section', {class: 'card'}, el('h3', null, t('result.must_be_true')),
      el('ol', {class: 'steps'},
        rule(t('result.rule_scale')),
        ruler,
        rule(t(inner ? 'result.rule_inner' : 'result.rule_outer')),
        rule(t(mirrored ? 'result.rule_mirrored' : 'result.rule_not_mirrored')),
        rule(t('result.rule_label', {label: report.label ?? ''})))));
}
