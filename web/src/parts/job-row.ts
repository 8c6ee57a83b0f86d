// One job in the list. What changes is redrawn; the picture stays.
import {el, newId, replace} from '../dom';
import {artifactPath} from '../api/client';
import type {ListedJob} from '../api/types';
import {ended} from '../api/types';
import {toJob} from '../route';
import {t, when} from '../text';
import {nameOf, shortId} from './band';
import {icon} from './icon';
import {problemName} from './problem';
import {doing, percentOf, percents, timeLeft} from './progress';
import {stateBadge} from './state-badge';

export interface RowActions {
  choose(job: ListedJob, on: boolean): void;
  remove(job: ListedJob): void;
}

export interface JobRow {
  element: HTMLElement;
  update(job: ListedJob, chosen: boolean, showOwner: boolean): void;
}

function thumbnail(job: ListedJob): Node {
  const symbol = (): Node => icon(job.kind === 'inspection' ? 'scan' : job.kind === 'layout' ? 'pattern' : 'head');
  if (job.state !== 'succeeded' || job.kind === 'layout') return symbol();
  const image = el('img', {
    src: artifactPath(job.id, job.kind === 'print' ? 'preview-with.png' : 'preview-findings.png'), loading: 'lazy', decoding: 'async',
    width: 104, height: 78, alt: job.kind === 'print' ? t('jobs.picture_print') : t('jobs.picture_findings')});
  image.addEventListener('error', () => image.replaceWith(symbol()));
  return image;
}

export function jobRow(first: ListedJob, actions: RowActions): JobRow {
  let job = first, drawn = '';
  const title = newId('job');
  const box = el('input', {type: 'checkbox', 'aria-labelledby': `${title}-choose ${title}`, onchange: () => actions.choose(job, box.checked)});
  const choice = el('label', {class: 'pick'}, box, el('span', {class: 'hidden', id: `${title}-choose`}, t('jobs.choose')));
  const picture = el('div', {class: 'picture'});
  const words = el('div', {class: 'words'}), state = el('div', {class: 'states'}), time = el('div', {class: 'time quiet small'});
  const remove = el('button', {type: 'button', class: 'plain icon-only danger', 'aria-labelledby': `${title}-delete ${title}`,
                               onclick: () => actions.remove(job)},
    icon('delete'), el('span', {class: 'hidden', id: `${title}-delete`}, t('jobs.delete')));
  const element = el('li', {class: 'job'}, choice, picture, words, state, time, remove);

  function draw(showOwner: boolean): void {
    replace(words, [
      el('a', {id: title, href: toJob(job.id)}, nameOf(job)),
      el('p', {class: 'quiet small'}, t(`kind.${job.kind}`), ' · ', job.reference ? shortId(job.id) : t('job.no_reference'),
        showOwner && ` · ${job.owner}`),
      job.note && el('p', {class: 'small note'}, job.note)]);
    const active = !ended(job.state);
    const left = timeLeft(job);
    replace(state, [
      el('div', {class: 'row'}, stateBadge(job)),
      active && el('p', {class: 'small'}, doing(job), job.state === 'running' && ` · ${percentOf(job)}`, left && ` · ${left}`),
      job.state === 'running' && el('progress', {max: 100, value: percents(job), 'aria-label': t('job.progress')}),
      job.problem && el('p', {class: 'small'}, problemName(job.problem))]);
    replace(time, el('time', {datetime: job.created}, when(job.created)));
    remove.hidden = active;
  }
  let pictured = '';
  return {element, update(now, chosen, showOwner) {
    job = now;
    box.checked = chosen;
    if (pictured !== job.state) replace(picture, thumbnail(job));
    pictured = job.state;
    const key = JSON.stringify([job, showOwner]);
    if (key !== drawn) draw(showOwner);
    drawn = key;
    element.toggleAttribute('data-chosen', chosen);
  }};
}
