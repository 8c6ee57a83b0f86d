// One job: its progress while it runs, and then what came of it.
import {el, jumpTo, replace, type Children} from '../dom';
import {api, foundProblem, Problem} from '../api/client';
import {followJob} from '../api/events';
import type {Job, ListedJob, SettingsSchema} from '../api/types';
import {ended} from '../api/types';
import {band, identityOf, nameOf, shortId} from '../parts/band';
import {confirm} from '../parts/confirm';
import {downloads, titleOf} from '../parts/downloads';
import {facts} from '../parts/facts';
import {icon} from '../parts/icon';
import {later, svgPicture} from '../parts/later';
import {logPart} from '../parts/log';
import {problemBox} from '../parts/problem';
import {changeReference, referenceChanges} from '../parts/reference';
import {progressCard, signTab} from '../parts/progress';
import {labelOf, valueText} from '../parts/settings-form';
import {stateBadge} from '../parts/state-badge';
import {warningsList} from '../parts/warnings-list';
import {toJob, toJobs, toNew} from '../route';
import {announce, setJobs, store} from '../state';
import {fieldOf, staleJob} from '../state/draft';
import {settingsOf, type Report, type Setting, type Warning} from '../state/jobs';
import type {PrintReport} from '../state/result';
import {bytes, duration, number, percent, t, textIfKnown, when} from '../text';
import {follow, live, onEnd, View} from '../view';
import {ResultView} from './result';
import {failureView} from './result/failure';
import {loadModel, type Model} from './result/part';

const queueEvery = 5000;  // ms: nothing tells a queued job that those before it are done

const shown = (): Job | null => store.get().jobs.job;
const phaseOf = (job: ListedJob | null): string => !job ? '' : ended(job.state) ? job.state : 'active';
const size = (mm: readonly number[]): string => `${mm.map((side) => number(side, 0)).join(' × ')} mm`;

interface Coupled {
  a: string;
  b: string;
  k: number;
}
// layout.json, as far as the page shows it.
interface Layout {
  count: number;
  diameter_mm: number;
  spacing_mm: number;
  spacing_rms_mm: number;
  off_head: number;
  covered: number;
  strongest_neighbours: Coupled | null;
  strongest: Coupled | null;
  warnings: readonly Warning[];
}

// Builds its content when it is opened for the first time.
function onDemand(title: string, build: () => Children): HTMLDetailsElement {
  const body = el('div');
  return el('details', {ontoggle: () => { if (!body.hasChildNodes()) replace(body, build()); }}, el('summary', null, title), body);
}

class JobView extends View {
  readonly #id = (() => {
    const {route} = store.get();
    return route.view === 'job' ? route.id : '';
  })();
  #stopFollowing = (): void => {};
  #over = false;

  protected build(): Children {
    setJobs({job: null, jobProblem: null, log: []});
    onEnd(() => {
      this.#over = true;
      this.#stopFollowing();
      signTab(null);
    });
    document.title = t('shell.name');
    void this.#load();
    follow((state) => state.jobs.job, (job) => { if (job) signTab(job); });
    let phase = '';
    follow((state) => phaseOf(state.jobs.job), (now) => {
      const job = shown();
      if (phase && job) {
        announce(`${nameOf(job)}: ${t(`state.${job.state}`)}`);
        // what had the focus may be gone
        queueMicrotask(() => { if (document.activeElement === document.body) document.getElementById('main')?.focus({preventScroll: true}); });
      }
      phase = now;
    });
    return [
      el('p', {class: 'small'}, el('a', {href: toJobs()}, icon('back'), t('job.all_jobs'))),
      live((state) => [phaseOf(state.jobs.job), state.jobs.job?.id, state.jobs.job?.reference, state.jobs.jobProblem] as const, ([, , , problem]) => {
        const job = shown();
        if (job && !problem) return this.#page(job);
        return [el('h1', null, job ? nameOf(job) : t('job.unnamed', {id: shortId(this.#id)})),
          problem ? problemBox(problem, () => void this.#load()) : el('p', {class: 'empty quiet', role: 'status'}, t('shell.loading'))];
      }),
    ];
  }

  async #load(): Promise<void> {
    try {
      const job = await api.job(this.#id);
      if (this.#over) return;
      setJobs({job, jobProblem: null});
      if (!ended(job.state)) this.#follow(job);
    } catch (error) {
      if (!this.#over) setJobs({jobProblem: error});
    }
  }

  #follow(job: Job): void {
    this.#stopFollowing();
    const waiting = setInterval(() => void this.#askPlace(), queueEvery);
    const stop = followJob(job.id, {
      job: (change) => {
        const known = shown();
        if (!known || this.#over) return;
        if (ended(change.state)) void this.#load();  // with its files
        else setJobs({job: {...known, ...change}});
      },
      log: (line) => setJobs({log: [...store.get().jobs.log, line]}),
      reached: (online) => store.set({online}),
      failed: (problem) => setJobs({jobProblem: problem}),
    });
    this.#stopFollowing = () => {
      clearInterval(waiting);
      stop();
      this.#stopFollowing = () => {};
    };
    if (this.#over) this.#stopFollowing();
  }

  // The place in the queue, and the expected time.
  async #askPlace(): Promise<void> {
    if (shown()?.state !== 'queued' || document.hidden) return;
    try {
      const {queue_position, seconds_expected} = await api.job(this.#id);
      const known = shown();
      if (known?.state === 'queued' && !this.#over)
        setJobs({job: {...known, queue_position: queue_position ?? null, seconds_expected: seconds_expected ?? null}});
    } catch {
      // the place is asked for again soon; the stream says when the server is gone
    }
  }

  #page(job: Job): Children {
    const done = ended(job.state);
    const identity = el('div', null, band(job));
    return [
      el('div', {class: 'spread head'},
        el('div', {class: 'row'}, el('h1', null, nameOf(job), ' ', el('span', {class: 'kind quiet'}, t(`kind.${job.kind}`))),
          live((state) => [state.jobs.job?.state, state.jobs.job?.serious_warnings], () => {
            const now = shown();
            return now && stateBadge(now);
          })),
        el('div', {class: 'row'}, done && this.#again(job),
          el('button', {type: 'button', id: 'change-reference', onclick: () => void this.#changeReference()}, t(job.reference ? 'job.change_reference' : 'job.add_reference')),
          done && el('button', {type: 'button', class: 'danger', onclick: () => void this.#remove(job)}, icon('delete'), t('jobs.delete')))),
      identity, referenceChanges(job),
      job.note && el('p', {class: 'note'}, job.note),
      !done ? this.#active(job)
        : job.state === 'succeeded' ? this.#succeeded(job, identity)
        : job.state === 'failed' ? this.#failed(job)
        : el('section', {class: 'card stack'}, el('p', null, t('job.cancelled')),
            el('p', null, el('a', {class: 'button primary', href: toNew(`from=${job.id}`)}, icon('reset'), t('job.start_again')))),
      this.#about(job),
    ];
  }

  // What to do next with a job that has ended.
  #again(job: Job): Children {
    if (job.state !== 'succeeded' || job.kind !== 'print') return null;
    return [
      el('button', {type: 'button', class: 'primary', onclick: () => jumpTo('downloads')}, icon('download'), t('job.downloads')),
      el('a', {class: 'button', href: toNew(`from=${job.id}`)}, icon('copy'), t('job.new_from'))];
  }

  #active(job: Job): Children {
    const card = progressCard(job, () => void this.#cancel());
    follow((state) => state.jobs.job, (now) => { if (now && !ended(now.state)) card.update(now); });
    return card.element;
  }

  #failed(job: Job): Children {
    const ends: (() => void)[] = [];
    onEnd(() => ends.forEach((end) => end()));
    return [
      problemBox(job.problem ? new Problem(job.problem) : t('state.failed')),
      el('p', {class: 'row'}, el('a', {class: 'button primary', href: toNew(`from=${job.id}`)}, icon('reset'), t('job.try_changed'))),
      job.artifacts.some((file) => file.name === 'findings.json') && later(() => api.artifactJson<Report>(job.id, 'findings.json'),
        (report) => [failureView(job, report, this.#pictures(job, report), ends), downloads(job).element])];
  }

  #succeeded(job: Job, identity: HTMLElement): Children {
    if (job.kind === 'layout') return this.#layout(job);
    const name = job.kind === 'print' ? 'report.json' : 'findings.json', model = job.kind === 'print' ? loadModel(job) : null;
    return later(() => api.artifactJson<Report & PrintReport>(job.id, name), (report) => {
      replace(identity, band(job, report));
      return job.kind === 'print' ? this.#print(job, report, model) : this.#inspection(job, report);
    });
  }

  #print(job: Job, report: Report & PrintReport, model: Model): Children {
    const files = downloads(job);
    const pictures = onDemand(t('job.pictures'), () => this.#pictures(job, report));
    const view = new ResultView(job, report, model);
    const result = el('div', null, view);
    const show = ([x = 0, y = 0, z = 0]: readonly number[]): void => {
      result.scrollIntoView();
      view.showPlace(x, y, z);
    };
    // out of date too while a print that starts from this job has other settings
    const setStale = (moved: boolean): void => files.setStale(moved || staleJob(store.get().draft) === job.id);
    result.addEventListener('stale', (event) => setStale((event as CustomEvent<{stale: boolean}>).detail.stale));
    setStale(false);
    const serious = job.serious_warnings ?? 0, count = serious || report.warnings.length;
    return [
      count > 0 && el('div', {class: 'notice settle'}, icon('warning'), el('p', null, t(serious ? 'job.settle' : 'job.read_warnings', {count})),
        el('button', {type: 'button', class: 'plain', onclick: () => jumpTo('warnings')}, icon('down'), t('job.to_warnings'))),
      el('h2', {class: 'hidden'}, t('job.result')), result,
      el('div', {class: 'columns'},
        el('section', {class: 'card'}, el('h2', {id: 'warnings', tabindex: -1}, t('job.warnings')), warningsList(report.warnings, show)),
        el('div', {class: 'stack'}, this.#printing(job, report), files.element)),
      pictures,
    ];
  }

  // What must be true when the print is made.
  #printing(job: Job, report: Report): HTMLElement {
    const inner = report.print?.inked_face === 'inner', ruler = report.print?.ruler_mm;
    const steps = job.artifacts.filter((file) => /^print.*\.pdf$/.test(file.name)).length;
    return el('section', {class: 'card'}, el('h2', {id: 'printing', tabindex: -1}, t('job.before_print')),
      el('ol', {class: 'todo'},
        el('li', null, t('job.print_scale')),
        el('li', null, ruler ? t('job.print_ruler', {mm: ruler}) : t(ruler === null ? 'job.print_no_ruler' : 'job.print_ruler_any')),
        el('li', null, steps > 1 ? t('job.print_steps', {count: steps}) : inner ? t('job.print_inner') : t('job.print_outer')),
        el('li', null, t('job.print_label', {label: report.label ?? ''}))));
  }

  #pictures(job: Job, report?: Report): HTMLElement {
    const identity = identityOf(job, report);
    const previews = job.artifacts.filter((file) => file.name.startsWith('preview-'));
    return el('div', {class: 'pictures'}, ...previews.map((file) =>
      el('figure', null,
        el('a', {href: file.href}, el('img', {src: file.href, loading: 'lazy', decoding: 'async', alt: `${titleOf(file)}. ${identity}`})),
        el('figcaption', null, titleOf(file)))));
  }

  #inspection(job: Job, report: Report): Children {
    const {scan, mold, problem} = report;
    const guessed = (text: string, isGuess: boolean): string => isGuess ? t('job.guessed', {text}) : text;
    return [
      el('section', {class: 'card stack'},
        report['fits'] === false
          ? el('p', {class: 'notice'}, icon('warning'), t('job.fits_not'))
          : el('p', {class: 'notice good'}, icon('check'), t('job.fits')),
        problem && problemBox(foundProblem(problem)),
        el('p', null, el('a', {class: 'button primary', href: toNew(`from=${job.id}`)}, icon('print'), t('job.make_print')))),
      el('div', {class: 'columns'},
        el('div', {class: 'stack'},
          el('section', {class: 'card'}, el('h2', null, t('job.warnings')), warningsList(report.warnings)), this.#pictures(job, report)),
        el('section', {class: 'card'}, el('h2', null, t('job.scan_found')), facts(
          [t('job.format'), scan.format],
          [t('job.triangles'), number(scan.triangles_read)],
          [t('job.unit'), guessed(scan.unit, scan.unit_guessed)],
          [t('job.size'), size(scan.size_mm)],
          [t('job.up'), guessed(scan.up, scan.up_guessed)],
          [t('job.front'), scan.front_from_format ? t('job.from_format', {text: scan.front}) : guessed(scan.front, scan.front_assumed)],
          [t('job.holes'), number(scan.holes_closed + scan.holes_capped)],
          scan.trim_mm !== null && [t('job.trim'), `${number(scan.trim_mm, 1)} mm`],
          [t('job.mold_size'), size(mold.size_mm)],
          [t('job.undercuts'), number(mold.undercut_count)]))),
      downloads(job).element,
    ];
  }

  #layout(job: Job): Children {
    const load = (): Promise<[HTMLImageElement, Layout]> => Promise.all([
      svgPicture(job.id, 'pattern.svg', `${t('artifact.pattern.svg')}. ${identityOf(job)}`), api.artifactJson<Layout>(job.id, 'layout.json')]);
    const mm = (value: number): string => `${number(value, 1)} mm`;
    const pair = (two: Coupled | null | undefined): string =>
      two ? t('job.pair', {...two, k: number(two.k, 3)}) : t('job.not_there');
    return [later(load, ([image, made]) => [
      el('div', {class: 'columns'},
        el('figure', {class: 'card drawing'}, image, el('figcaption', null, t('artifact.pattern.svg'))),
        el('section', {class: 'card stack'}, el('h2', null, t('job.array')), facts(
          [t('job.coils'), number(made.count)],
          [t('job.diameter'), mm(made.diameter_mm)],
          [t('job.spacing'), mm(made.spacing_mm)],
          [t('job.spacing_rms'), mm(made.spacing_rms_mm)],
          [t('job.off_head'), number(made.off_head)],
          [t('job.covered'), percent(made.covered)],
          [t('job.strongest_neighbours'), pair(made.strongest_neighbours)],
          [t('job.strongest'), pair(made.strongest)]),
          el('p', null, el('a', {class: 'button primary', href: toNew(`from=${job.id}`)}, icon('pattern'), t('job.use_pattern'))))),
      el('section', {class: 'card'}, el('h2', null, t('job.warnings')), warningsList(made.warnings))]),
      downloads(job).element];
  }

  // Settings, log, times: on demand.
  #about(job: Job): HTMLElement {
    const log = logPart(() => void this.#readLog(job));
    follow((state) => state.jobs.log, log.show);
    const seconds = job.started && job.ended ? (Date.parse(job.ended) - Date.parse(job.started)) / 1000 : null;
    return el('section', {class: 'card about'},
      onDemand(t('job.settings'), () => later(() => api.schema(), (schema) => this.#settings(settingsOf(job.settings, schema), schema))),
      log.element,
      onDemand(t('job.about'), () => facts(
        [t('job.id'), el('code', null, job.id)],
        [t('jobs.owner'), job.owner],
        [t('job.created'), when(job.created)],
        job.started !== null && [t('job.started'), when(job.started)],
        job.ended !== null && [t('job.ended'), when(job.ended)],
        seconds !== null && [t('job.took'), duration(seconds)],
        job.derived_from !== null && [t('job.derived_from'), el('a', {href: toJob(job.derived_from)}, shortId(job.derived_from))],
        ...Object.entries(job.inputs).map(([name, input]): [string, Children] =>
          [textIfKnown(`job.input_${name}`) ?? name,
           [`${(input.format ?? input.extension).toUpperCase()}, ${bytes(input.bytes)}`, el('br'), el('code', null, input.sha256)]]))));
  }

  #settings(all: readonly Setting[], schema: SettingsSchema): Children {
    const text = (id: string, value: unknown): string => valueText(id, fieldOf(schema, id), value);
    const table = (rows: readonly Setting[]): HTMLElement => el('div', {class: 'wide', tabindex: 0, role: 'group', 'aria-label': t('job.settings')}, el('table', null,
      el('thead', null, el('tr', null, el('th', {scope: 'col'}, t('job.setting')), el('th', {scope: 'col'}, t('job.value')),
        el('th', {scope: 'col'}, t('job.preset')))),
      el('tbody', null, ...rows.map((row) => el('tr', null, el('th', {scope: 'row'}, labelOf(row.id)),
        el('td', null, text(row.id, row.value)),
        el('td', {class: 'quiet'}, text(row.id, fieldOf(schema, row.id)?.default)))))));
    const changed = all.filter((one) => one.changed);
    return [
      el('h3', null, t('job.changed')),
      changed.length > 0 ? table(changed) : el('p', null, t('job.none_changed')),
      onDemand(t('job.all_settings'), () => table(all)),
    ];
  }

  async #readLog(job: Job): Promise<void> {
    if (!ended(job.state) || store.get().jobs.log.length > 0) return;
    const {lines} = await api.log(job.id);
    if (!this.#over) setJobs({log: lines});
  }

  async #cancel(): Promise<void> {
    try {
      const now = await api.cancel(this.#id);
      if (this.#over) return;
      setJobs({job: now});
      announce(t('job.cancelling'));
    } catch (error) {
      setJobs({jobProblem: error});
    }
  }

  async #changeReference(): Promise<void> {
    const now = shown(), changed = now && await changeReference(now);
    if (!changed || this.#over) return;
    setJobs({job: {...changed, queue_position: now.queue_position ?? null, seconds_expected: now.seconds_expected ?? null}});
    announce(t('job.reference_changed', {reference: changed.reference || t('job.no_reference')}));
    document.getElementById('change-reference')?.focus({preventScroll: true});
  }

  async #remove(job: Job): Promise<void> {
    const name = nameOf(job);
    if (!await confirm({title: t('jobs.delete_title', {name}), text: t('jobs.delete_text'), action: t('jobs.delete'), icon: 'delete'})) return;
    try {
      await api.remove(job.id);
      announce(t('jobs.deleted', {name}));
      location.hash = toJobs();
    } catch (error) {
      setJobs({jobProblem: error});
    }
  }
}
customElements.define('vf-job', JobView);
