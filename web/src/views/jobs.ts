// All jobs that this person may see. The address holds filters and page, so a link restores them.
import {el, type Children} from '../dom';
import {api, Problem} from '../api/client';
import type {JobKind, ListedJob} from '../api/types';
import {ended} from '../api/types';
import {nameOf} from '../parts/band';
import {confirm} from '../parts/confirm';
import {icon} from '../parts/icon';
import {jobRow, type JobRow} from '../parts/job-row';
import {problemBox} from '../parts/problem';
import {setTitle} from '../parts/progress';
import {toCompare, toNew} from '../route';
import {announce, setJobs, store} from '../state';
import {
  activeStates, choose, filterOf, isFiltered, listQuery, newerPage, olderPage, withFilter, type FilterName} from '../state/jobs';
import {t} from '../text';
import {follow, live, onEnd, View} from '../view';
import {sampleButton} from './help/sample';

const often = 3000, rarely = 15_000, typing = 400;  // ms
const kinds: readonly JobKind[] = ['print', 'inspection', 'layout'];

const query = (): string => store.get().route.query;
const goTo = (to: string): void => location.replace(`#/jobs${to && '?' + to}`);

class Jobs extends View {
  #asked = 0;  // the newest question; older answers are dropped

  protected build(): Children {
    setTitle(t('shell.jobs'));
    let timer = 0;
    const again = (): void => {
      clearTimeout(timer);
      const active = store.get().jobs.list?.jobs.some((job) => !ended(job.state)) ?? false;
      timer = window.setTimeout(() => void read(), active ? often : rarely);
    };
    const read = async (): Promise<void> => {
      if (!document.hidden) await this.#read();
      again();
    };
    const wake = (): void => { if (!document.hidden) void read(); };
    document.addEventListener('visibilitychange', wake);
    onEnd(() => {
      this.#asked = -1;
      clearTimeout(timer);
      document.removeEventListener('visibilitychange', wake);
    });
    follow((state) => state.route, (route) => { if (route.view === 'jobs') void read(); });
    return [
      el('div', {class: 'spread head'},
        el('h1', null, t('shell.jobs')),
        el('a', {class: 'button primary', href: toNew()}, icon('add'), t('shell.new'))),
      this.#filters(), this.#comparing(), this.#list(), this.#pages(),
    ];
  }

  async #read(): Promise<void> {
    if (this.#asked < 0) return;
    const mine = ++this.#asked, asked = query();
    try {
      const page = await api.jobs(listQuery(asked));
      if (this.#asked !== mine) return;
      setJobs({list: {query: asked, jobs: page.jobs, next: page.next}, listProblem: null});
      store.set({online: true});
    } catch (error) {
      if (this.#asked !== mine) return;
      const unreachable = error instanceof Problem && error.status === 0;
      if (unreachable) store.set({online: false});
      // a list that is shown stays: the line above it says that the server does not answer
      if (!unreachable || store.get().jobs.list?.query !== asked) setJobs({list: null, listProblem: error});
    }
  }

  #filters(): HTMLElement {
    let timer = 0;
    onEnd(() => clearTimeout(timer));
    const set = (name: FilterName, value: string): void => goTo(withFilter(query(), name, value));
    const field = (name: FilterName, label: string, input: HTMLInputElement | HTMLSelectElement): HTMLElement => {
      input.id = `filter-${name}`;
      follow((state) => filterOf(state.route.query, name), (value) => { if (document.activeElement !== input) input.value = value; });
      return el('div', null, el('label', {for: input.id}, label), input);
    };
    const text = (name: FilterName, type: string, props = {}): HTMLInputElement => {
      const input = el('input', {type, autocomplete: 'off', spellcheck: 'false', ...props, oninput: () => {
        clearTimeout(timer);
        timer = window.setTimeout(() => set(name, input.value), typing);
      }});
      return input;
    };
    const day = (name: FilterName): HTMLInputElement => {
      const input = el('input', {type: 'date', onchange: () => set(name, input.value)});
      return input;
    };
    const select = (name: FilterName, options: readonly (readonly [string, string])[]): HTMLSelectElement => {
      const input = el('select', {onchange: () => set(name, input.value)},
        el('option', {value: ''}, t('jobs.all')), ...options.map(([value, label]) => el('option', {value}, label)));
      return input;
    };
    const fields = el('div', {class: 'filters'},
      field('text', t('jobs.text'), text('text', 'search', {maxlength: 64})),
      field('state', t('jobs.state'), select('state', [
        [activeStates, t('jobs.active')], ['succeeded', t('state.succeeded')], ['failed', t('state.failed')],
        ['cancelled', t('state.cancelled')]])),
      field('kind', t('jobs.kind'), select('kind', kinds.map((kind) => [kind, t(`kind.${kind}`)] as const))),
      live((state) => state.session?.scopes.includes('admin') ?? false, (admin) =>
        admin && field('owner', t('jobs.owner'), text('owner', 'text', {maxlength: 64}))),
      field('from', t('jobs.from'), day('from')), field('to', t('jobs.to'), day('to')),
      live((state) => isFiltered(state.route.query), (filtered) => filtered &&
        el('button', {type: 'button', class: 'plain', onclick: () => {
          clearTimeout(timer);
          for (const input of fields.querySelectorAll<HTMLInputElement | HTMLSelectElement>('input, select')) input.value = '';
          goTo('');
          document.getElementById('filter-text')?.focus();
        }}, icon('cancel'), t('jobs.clear'))));
    // On small screens the fields open on demand.
    return el('details', {class: 'filter-box', open: matchMedia('(min-width: 641px)').matches || isFiltered(query())},
      el('summary', null, icon('filter'), t('jobs.filters')),
      el('form', {role: 'search', 'aria-label': t('jobs.filters'), onsubmit: (event) => event.preventDefault()}, fields));
  }

  #comparing(): HTMLElement {
    return live((state) => state.jobs.chosen, ([a, b]) => a !== undefined && el('div', {class: 'notice good compare-bar', role: 'status'},
      icon('compare'),
      el('p', null, b === undefined ? t('jobs.choose_another') : t('jobs.two_chosen')),
      b !== undefined && el('a', {class: 'button primary', href: toCompare(a, b)}, t('jobs.compare')),
      el('button', {type: 'button', onclick: () => setJobs({chosen: []})}, t('jobs.choose_none'))));
  }

  #list(): HTMLElement {
    const rows = new Map<string, JobRow>();
    const list = el('ul', {class: 'jobs'});
    const actions = {
      choose: (job: ListedJob, on: boolean) => setJobs({chosen: choose(store.get().jobs.chosen, job.id, on)}),
      remove: (job: ListedJob) => void this.#remove(job),
    };
    follow((state) => [state.jobs.list, state.jobs.chosen, state.session] as const, ([shown, chosen, session]) => {
      const admin = session?.scopes.includes('admin') ?? false;
      const wanted = shown?.jobs ?? [];
      for (const [id, row] of rows)
        if (!wanted.some((job) => job.id === id)) rows.delete(id), row.element.remove();
      wanted.forEach((job, at) => {
        let row = rows.get(job.id);
        if (!row) rows.set(job.id, row = jobRow(job, actions));
        row.update(job, chosen.includes(job.id), admin);
        if (list.children[at] !== row.element) list.insertBefore(row.element, list.children[at] ?? null);
      });
      list.hidden = wanted.length === 0;
    });
    const around = live((state) => [state.jobs.listProblem, state.jobs.list?.jobs.length ?? -1, isFiltered(state.route.query)] as const,
      ([problem, count, filtered]) => {
        if (problem) return problemBox(problem, () => void this.#read());
        if (count < 0) return el('p', {class: 'empty quiet', role: 'status'}, t('shell.loading'));
        if (count > 0) return null;
        return filtered ? el('div', {class: 'card empty'}, icon('search'), el('h2', null, t('jobs.none_found')),
                            el('p', null, t('jobs.none_found_help')))
                        : el('div', {class: 'card empty'}, icon('head'), el('h2', null, t('jobs.none')),
                            el('p', null, t('jobs.none_help')),
                            el('p', null, el('a', {class: 'button primary', href: toNew()}, icon('add'), t('shell.new'))),
                            sampleButton());
      });
    return el('div', null, around, list);
  }

  #pages(): HTMLElement {
    const page = (to: string, words: string): HTMLElement =>
      el('a', {class: 'button', id: `page-${words}`, href: `#/jobs${to && '?' + to}`, onclick: () => scrollTo(0, 0)}, words);
    return live((state) => [state.jobs.list?.next, state.route.query] as const, ([next, at]) => {
      const newer = newerPage(at);
      if (newer === null && !next) return null;
      return el('nav', {class: 'row pages', 'aria-label': t('jobs.pages')},
        newer !== null && page(newer, t('jobs.newer')), next && page(olderPage(at, next), t('jobs.older')));
    });
  }

  async #remove(job: ListedJob): Promise<void> {
    const name = nameOf(job);
    if (!await confirm({title: t('jobs.delete_title', {name}), text: t('jobs.delete_text'), action: t('jobs.delete'), icon: 'delete'})) return;
    try {
      await api.remove(job.id);
      announce(t('jobs.deleted', {name}));
      setJobs({chosen: choose(store.get().jobs.chosen, job.id, false)});
      await this.#read();
      document.getElementById('main')?.focus({preventScroll: true});
    } catch (error) {
      setJobs({listProblem: error});
    }
  }
}
customElements.define('vf-jobs', Jobs);
