// A print that has succeeded: its figures, the formed sheet in 3D, its coils, and the flat print.
// Event "stale" {stale}: the drawing was moved, so the files of the job do not match what is shown.
import {el, type Children} from '../dom';
import type {Job} from '../api/types';
import {coilTable} from '../parts/coil-table';
import {store} from '../state';
import {coilsOf, resultOf, type PrintReport} from '../state/result';
import {t} from '../text';
import {follow, onEnd, View} from '../view';
import {adjustView} from './result/adjust';
import {keyFigures} from './result/figures';
import {partView, setResult, type Model, type Part} from './result/part';
import {printSheet} from './result/print-sheet';

export class ResultView extends View {
  #part: Part | null = null;

  constructor(readonly job: Job, readonly report: PrintReport, readonly model: Model) {
    super();
  }
  // Shows a place of the mold, in mm.
  showPlace(x: number, y: number, z: number): void {
    setResult({tab: 'part'});
    this.#part?.showPlace([x, y, z]);
  }

  protected build(): Children {
    const {job} = this;
    const ends: (() => void)[] = [];
    onEnd(() => {
      this.#part = null;
      for (const end of ends.splice(0).reverse()) end();
    });
    // Also when a link to another view of this job is opened.
    follow((state) => state.route, (route) => {
      if (route.view === 'job' && route.id === job.id) setResult(resultOf(route.query));
    });
    return el('div', {class: 'result'}, this.#content(ends));
  }

  #content(ends: (() => void)[]): Children {
    const {job, report, model} = this, coils = coilsOf(report);
    const part = this.#part = partView(job, report, model, coils, ends);
    const table = coils.length > 0 ? coilTable(coils, ({id}) => {
      const coil = store.get().result.coil === id ? '' : id;
      setResult({coil});
      const view = part.element.querySelector('.view3d-frame'), {top = 0, bottom = 0} = view?.getBoundingClientRect() ?? {};
      if (coil && (top + bottom < 0 || top + bottom > 2 * innerHeight)) view?.scrollIntoView({block: 'nearest'});  // less than half is seen
    }) : null;
    const stale = (now: boolean): void => void this.dispatchEvent(new CustomEvent('stale', {detail: {stale: now}, bubbles: true}));
    const panels = {
      part: el('div', {id: 'panel-part', role: 'tabpanel', 'aria-labelledby': 'tab-part', class: 'stack'},
        part.element,
        adjustView(job, report, part, stale),
        table && el('section', {class: 'card'}, el('h3', null, t('result.coils')), table.element)),
      sheet: el('div', {id: 'panel-sheet', role: 'tabpanel', 'aria-labelledby': 'tab-sheet'}),
    };
    const names = ['part', 'sheet'] as const;
    const tabs = names.map((name) => el('button', {
      type: 'button', role: 'tab', id: `tab-${name}`, 'aria-controls': `panel-${name}`, onclick: () => setResult({tab: name}),
      onkeydown: (event) => {
        if (event.key !== 'ArrowRight' && event.key !== 'ArrowLeft') return;
        const other = names[1 - names.indexOf(name)] ?? 'part';
        setResult({tab: other});
        document.getElementById(`tab-${other}`)?.focus();
      }}, t(`result.tab_${name}`)));
    const apply = (): void => {
      const {tab, coil} = store.get().result;
      names.forEach((name, i) => {
        const chosen = name === tab;
        tabs[i]?.setAttribute('aria-selected', String(chosen));
        tabs[i]?.setAttribute('tabindex', chosen ? '0' : '-1');
        panels[name].hidden = !chosen;
      });
      if (tab === 'sheet' && !panels.sheet.hasChildNodes()) panels.sheet.append(printSheet(job, report));
      table?.select(coil);
    };
    apply();
    ends.push(store.subscribe(apply));
    return [
      keyFigures(report),
      el('div', {role: 'tablist', class: 'result-tabs', 'aria-label': t('result.tabs')}, ...tabs),
      panels.part, panels.sheet];
  }
}
customElements.define('vf-result', ResultView);
