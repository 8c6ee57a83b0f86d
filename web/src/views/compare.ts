// Two jobs side by side: what was asked, what came out, and in what they differ.
import {el, replace, type Children} from '../dom';
import {api} from '../api/client';
import type {Job, SettingsSchema} from '../api/types';
import {band, identityOf, nameOf} from '../parts/band';
import {titleOf} from '../parts/downloads';
import {icon} from '../parts/icon';
import {problemBox} from '../parts/problem';
import {setTitle} from '../parts/progress';
import {labelOf, valueText} from '../parts/settings-form';
import {stateBadge} from '../parts/state-badge';
import {warningsList} from '../parts/warnings-list';
import {toCompare, toJob, toJobs} from '../route';
import {store} from '../state';
import {fieldOf, settingOf} from '../state/draft';
import {differences, figureAt, type Report} from '../state/jobs';
import {number, t, withUnit} from '../text';
import {onEnd, View} from '../view';

interface Side {
  job: Job;
  report: Report | null;
}

async function read(id: string): Promise<Side> {
  const job = await api.job(id);
  const name = job.kind === 'print' ? 'report.json' : 'findings.json';
  const has = job.artifacts.some((file) => file.name === name);
  return {job, report: has ? await api.artifactJson<Report>(id, name) : null};
}

// The figures that are compared: where they are in report.json, and how they are written.
const share = (value: number): string => withUnit(value * 100, '%', 2);
const plain = (value: number): string => number(value, 3);
const mm = (value: number): string => withUnit(value, 'mm', 2);
const whole = (value: number): string => number(value, 0);
const figures = [
  ['round', 'coils.mean_circularity', share], ['round_worst', 'coils.worst_circularity', share],
  ['area', 'coils.mean_area_error', share], ['area_worst', 'coils.worst_area_error', share],
  ['spacing', 'coils.spacing_rms_mm', mm], ['coupling', 'coils.worst_k', plain], ['on_head', 'coils.on_head', whole],
  ['chart_shape', 'shape.mean', plain], ['chart_shape_95', 'shape.p95', plain], ['chart_area', 'area.mean', plain],
] as const;
const single = [['thinnest', 'thickness.least_mm', mm], ['printed', 'pattern.ink_printed', share], ['on_mold', 'pattern.ink_on_head', share]] as const;

class Compare extends View {
  #over = false;

  protected build(): Children {
    const {route} = store.get();
    if (route.view !== 'compare') return null;
    setTitle(t('jobs.compare'));
    onEnd(() => { this.#over = true; });
    const {a, b} = route;
    const body = el('div', {class: 'stack'}, el('p', {class: 'empty quiet', role: 'status'}, t('shell.loading')));
    const load = (): void => void Promise.all([read(a), read(b), api.schema()]).then(
      ([one, other, schema]) => { if (!this.#over) replace(body, this.#both([one, other], schema)); },
      (error: unknown) => { if (!this.#over) replace(body, problemBox(error, load)); });
    load();
    return [
      el('p', {class: 'small'}, el('a', {href: toJobs()}, icon('back'), t('job.all_jobs'))),
      el('div', {class: 'spread head'}, el('h1', null, t('jobs.compare_title')),
        el('a', {class: 'button', href: toCompare(b, a)}, icon('compare'), t('jobs.swap'))),
      body,
    ];
  }

  #both(sides: readonly [Side, Side], schema: SettingsSchema): Children {
    const [a, b] = sides;
    return [
      el('div', {class: 'pair'}, ...sides.map(({job, report}, at) => el('section', {class: 'card'},
        el('h2', null, this.#letter(at), ' ', el('a', {href: toJob(job.id)}, nameOf(job))),
        el('p', {class: 'row'}, stateBadge(job), el('span', {class: 'quiet'}, t(`kind.${job.kind}`))),
        band(job, report)))),
      this.#sameScan(a.job, b.job),
      this.#settings(a.job, b.job, schema),
      this.#figures(a, b),
      this.#pictures(sides),
      this.#warnings(sides),
    ];
  }

  #letter = (at: number): HTMLElement => el('span', {class: 'letter'}, at === 0 ? 'A' : 'B');
  #heads = (...first: string[]): HTMLElement => el('thead', null, el('tr', null, ...first.map((words) => el('th', {scope: 'col'}, words)),
    el('th', {scope: 'col', class: 'number'}, 'A'), el('th', {scope: 'col', class: 'number'}, 'B')));

  #sameScan(a: Job, b: Job): Children {
    const same = (name: string): boolean => a.inputs[name]?.sha256 === b.inputs[name]?.sha256;
    return el('p', {class: same('scan') ? 'notice good' : 'notice'}, icon(same('scan') ? 'check' : 'warning'),
      same('scan') ? (same('pattern') ? t('jobs.same_both') : t('jobs.same_scan')) : t('jobs.other_scan'));
  }

  #settings(a: Job, b: Job, schema: SettingsSchema): HTMLElement {
    const differ = differences(a.settings, b.settings);
    const text = (job: Job, id: string): string => {
      const value = settingOf(job.settings, id);
      return value === undefined ? t('job.not_there') : valueText(id, fieldOf(schema, id), value);
    };
    return el('section', {class: 'card'}, el('h2', null, t('jobs.settings_differ')),
      differ.length === 0 ? el('p', null, t('jobs.settings_same')) : this.#wide(t('jobs.settings_differ'), el('table', null,
        this.#heads(t('job.setting')),
        el('tbody', null, ...differ.map((id) => el('tr', null, el('th', {scope: 'row'}, labelOf(id)),
          el('td', {class: 'number'}, text(a, id)), el('td', {class: 'number'}, text(b, id))))))));
  }

  #figures(a: Side, b: Side): Children {
    const row = (words: string, path: string, write: (value: number) => string): HTMLElement | null => {
      const [one, other] = [figureAt(a.report, path), figureAt(b.report, path)];
      if (one === null && other === null) return null;
      const written = (value: number | null): string => value === null ? t('job.not_there') : write(value);
      const difference = one === null || other === null ? '' : write(Math.abs(other - one)) === write(0) ? t('jobs.equal') : `${other > one ? '+' : '−'}${write(Math.abs(other - one))}`;
      return el('tr', null, el('th', {scope: 'row'}, words), el('td', {class: 'number'}, written(one)),
        el('td', {class: 'number'}, written(other)), el('td', {class: 'number'}, difference));
    };
    const bodies = ([['with', t('jobs.with')], ['without', t('jobs.without')]] as const).map(([side, words]) =>
      [words, figures.map(([name, path, write]) => row(t(`jobs.figure_${name}`), `figures.${side}.${path}`, write))] as const);
    bodies.push([t('jobs.both_prints'), single.map(([name, path, write]) => row(t(`jobs.figure_${name}`), path, write))]);
    const head = this.#heads(t('jobs.figure'));
    head.firstElementChild?.append(el('th', {scope: 'col', class: 'number'}, t('jobs.difference')));
    const table = el('table', {class: 'figures'}, head, ...bodies.map(([words, rows]) => {
      const known = rows.filter((one) => one !== null);
      return known.length === 0 ? null : el('tbody', null,
        el('tr', null, el('th', {scope: 'rowgroup', colspan: 4, class: 'group'}, words)), ...known);
    }));
    return table.tBodies.length === 0 ? null : el('section', {class: 'card'}, el('h2', null, t('jobs.figures')), this.#wide(t('jobs.figures'), table));
  }

  // A table that scrolls sideways alone where the screen is narrow.
  #wide = (name: string, table: HTMLElement): HTMLElement =>
    el('div', {class: 'wide', tabindex: 0, role: 'group', 'aria-label': name}, table);

  #pictures(sides: readonly [Side, Side]): Children {
    const names = sides[0].job.artifacts.filter((file) => file.name.startsWith('preview-') &&
      sides[1].job.artifacts.some((other) => other.name === file.name));
    if (names.length === 0) return null;
    const images = sides.map(() => el('img'));
    const choice = el('select', {id: 'picture', onchange: () => show()},
      ...names.map((file) => el('option', {value: file.name, selected: file.name === 'preview-with.png'}, titleOf(file))));
    const show = (): void => images.forEach((image, at) => {
      const side = sides[at], file = side?.job.artifacts.find((one) => one.name === choice.value);
      if (!side || !file) return;
      image.src = file.href;
      image.alt = `${titleOf(file)}. ${identityOf(side.job, side.report)}`;
    });
    show();
    return el('section', {class: 'card'}, el('h2', null, t('job.pictures')),
      el('div', {class: 'field'}, el('label', {for: 'picture'}, t('jobs.picture')), choice),
      el('div', {class: 'pair'}, ...images.map((image, at) => el('figure', null, image,
        el('figcaption', null, this.#letter(at), ' ', sides[at] ? nameOf(sides[at].job) : '')))));
  }

  #warnings(sides: readonly [Side, Side]): Children {
    const [a, b] = sides.map((side) => side.report?.warnings ?? []);
    if (!a || !b || !sides[0].report || !sides[1].report) return null;
    const only = (mine: typeof a, other: typeof a): typeof a => mine.filter((one) => !other.some((two) => two.code === one.code));
    const both = a.length - only(a, b).length;
    const list = (at: number, mine: typeof a): HTMLElement => el('div', null, el('h3', null, this.#letter(at), ' ', t('jobs.only_here')),
      mine.length > 0 ? warningsList(mine) : el('p', {class: 'quiet'}, t('jobs.nothing_more')));
    return el('section', {class: 'card'}, el('h2', null, t('job.warnings')),
      both > 0 && el('p', null, t('jobs.warnings_both', {count: both})),
      el('div', {class: 'pair'}, list(0, only(a, b)), list(1, only(b, a))));
  }
}
customElements.define('vf-compare', Compare);
