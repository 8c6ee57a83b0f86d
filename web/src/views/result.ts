// A print that has succeeded: its figures, the formed sheet in 3D, its coils, and the flat print.
// Event "stale" {stale}: the drawing was moved, so the files of the job do not match what is shown.
import {el, type Children} from '../dom';
import type {Job} from '../api/types';
import {coilTable} from '../parts/coil-table';
import {store} from '../state';
import {couplingsOf} from '../state/array';
import {coilsOf, resultOf, selected, tabs as tabNames, type PrintReport} from '../state/result';
import {t} from '../text';
import {follow, onEnd, View} from '../view';
import {adjustView} from './result/adjust';
import {buildView, isBuilt} from './result/build';
import {couplingMap} from './result/coupling';
import {keyFigures} from './result/figures';
import {layersOfJob} from './result/layers';
import {partView, setResult, type Model, type Part} from './result/part';
import {printSheet, type PrintSheet} from './result/print-sheet';

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
    const {job, report, model} = this, coils = coilsOf(report), couplings = couplingsOf(report), layers = layersOfJob(job, report);
    const part = this.#part = partView(job, report, model, coils, layers, ends);
    // Selecting what is selected selects nothing.
    const select = (coil: string, other = ''): void => {
      const now = store.get().result, off = now.coil === coil && now.other === other;
      setResult(off ? {coil: '', other: ''} : {coil, other});
      const view = part.element.querySelector('.view3d-frame'), {top = 0, bottom = 0} = view?.getBoundingClientRect() ?? {};
      if (!off && (top + bottom < 0 || top + bottom > 2 * innerHeight)) view?.scrollIntoView({block: 'nearest'});  // less than half is seen
    };
    const table = coils.length > 0 ? coilTable(coils, ({id}) => select(id)) : null;
    const map = couplings && couplingMap(couplings, (pair) => select(...pair));
    let sheet: PrintSheet | null = null;
    const stale = (now: boolean): void => void this.dispatchEvent(new CustomEvent('stale', {detail: {stale: now}, bubbles: true}));
    const panels = {
      part: el('div', {id: 'panel-part', role: 'tabpanel', 'aria-labelledby': 'tab-part', class: 'stack'},
        part.element,
        adjustView(job, report, part, stale),
        table && el('section', {class: 'card'}, el('h3', null, t('result.coils')), table.element), map?.element),
      sheet: el('div', {id: 'panel-sheet', role: 'tabpanel', 'aria-labelledby': 'tab-sheet'}),
      build: el('div', {id: 'panel-build', role: 'tabpanel', 'aria-labelledby': 'tab-build'}),
    };
    const names = tabNames.filter((name) => name !== 'build' || isBuilt(report, layers));
    const tabs = names.map((name) => el('button', {
      type: 'button', role: 'tab', id: `tab-${name}`, 'aria-controls': `panel-${name}`, onclick: () => setResult({tab: name}),
      onkeydown: (event) => {
        if (event.key !== 'ArrowRight' && event.key !== 'ArrowLeft') return;
        const other = names[(names.indexOf(name) + (event.key === 'ArrowRight' ? 1 : names.length - 1)) % names.length] ?? 'part';
        setResult({tab: other});
        document.getElementById(`tab-${other}`)?.focus();
      }}, t(`result.tab_${name}`)));
    const apply = (): void => {
      const now = store.get().result, tab = names.includes(now.tab) ? now.tab : 'part';
      names.forEach((name, i) => {
        const chosen = name === tab;
        tabs[i]?.setAttribute('aria-selected', String(chosen));
        tabs[i]?.setAttribute('tabindex', chosen ? '0' : '-1');
        panels[name].hidden = !chosen;
      });
      if (tab === 'sheet' && !sheet) panels.sheet.append((sheet = printSheet(job, report, layers, (hidden) => setResult({hidden}))).element);
      if (tab === 'build' && !panels.build.hasChildNodes()) panels.build.append(buildView(job, report, layers, (place) => this.showPlace(...place)));
      sheet?.show(now.hidden);
      table?.select(selected(now));
      map?.select(selected(now));
    };
    apply();
    ends.push(store.subscribe(apply));
    return [
      keyFigures(report),
      el('div', {role: 'tablist', class: 'result-tabs', 'aria-label': t('result.tabs')}, ...tabs),
      ...names.map((name) => panels[name])];
  }
}
customElements.define('vf-result', ResultView);
