// How far a job is: place in the queue, stages, percent, time left; and the same in the title and icon of the tab.
import {el, replace} from '../dom';
import type {ListedJob} from '../api/types';
import {ended} from '../api/types';
import {quarter, secondsLeft, stagesOf} from '../state/jobs';
import {announce} from '../state';
import {duration, percent, t, when} from '../text';
import {nameOf} from './band';
import {icon} from './icon';

// Whole percents, never more than is done; 0.58 * 100 is a little less than 58.
export const percents = ({progress}: Pick<ListedJob, 'progress'>): number => Math.floor(progress * 100 + 1e-6);
export const percentOf = (job: Pick<ListedJob, 'progress'>): string => percent(percents(job) / 100);

// "about 2 min left"; empty where nothing is known.
export function timeLeft(job: ListedJob): string {
  const seconds = secondsLeft(job);
  if (seconds === null) return '';
  return seconds < 5 ? t('job.seconds_left') : t('job.time_left', {time: duration(seconds)});
}

// What a job that has not ended is doing, in one line.
export function doing(job: ListedJob): string {
  if (job.state === 'queued') {
    if (job.not_before && Date.parse(job.not_before) > Date.now()) return t('job.not_before', {time: when(job.not_before)});
    return job.queue_position ? t('job.queue_place', {place: job.queue_position}) : t('job.queued');
  }
  if (job.state === 'cancelling') return t('job.cancelling');
  return job.stage ? t(`stage.${job.stage}`) : t('job.starting');
}

export function progressCard(first: ListedJob, cancel: () => void): {element: HTMLElement; update(job: ListedJob): void} {
  const bar = el('progress', {max: 100, 'aria-label': t('job.progress')});
  const share = el('strong', {class: 'figure'});
  const left = el('span', {class: 'quiet'});
  const now = el('p', {class: 'quiet'});
  const stages = el('ol', {class: 'stages'});
  const button = el('button', {type: 'button', onclick: cancel}, icon('cancel'), t('job.cancel'));
  const element = el('section', {class: 'card stack', 'aria-label': t('job.progress')},
    el('div', {class: 'spread'}, el('div', null, el('p', {class: 'row'}, share, left), now), button), bar, stages);

  let said = {state: first.state, stage: first.stage, quarter: quarter(first.progress)};
  function speak(job: ListedJob): void {
    const saying = {state: job.state, stage: job.stage, quarter: quarter(job.progress)};
    if (saying.state !== said.state || saying.stage !== said.stage || saying.quarter !== said.quarter)
      announce(job.state === 'running' ? t('job.spoken', {percent: percentOf(job), stage: doing(job)}) : doing(job));
    said = saying;
  }
  function update(job: ListedJob): void {
    const running = job.state === 'running';
    share.textContent = job.state === 'queued' ? t('state.queued') : percentOf(job);
    left.textContent = timeLeft(job);
    now.textContent = doing(job) + (job.attempt > 1 ? ' ' + t('job.attempt', {attempt: job.attempt}) : '');
    bar.hidden = job.state === 'queued';
    bar.value = percents(job);
    button.hidden = job.state === 'cancelling';
    const all = stagesOf(job.kind), at = job.stage ? all.indexOf(job.stage) : -1;
    replace(stages, all.map((stage, i) => {
      const phase = i < at ? 'done' : i === at && running ? 'current' : 'next';
      return el('li', {class: phase, 'aria-current': phase === 'current' && 'step'},
        el('span', {class: 'dot', 'aria-hidden': 'true'}, phase === 'done' ? icon('check') : String(i + 1)),
        el('span', null, t(`stage.${stage}`), el('span', {class: 'hidden'}, ', ', t(`job.stage_${phase}`))));
    }));
    speak(job);
  }
  update(first);
  return {element, update};
}

// ---- the tab ----

const original = 'data:,';

function drawIcon(job: ListedJob): string {
  const canvas = el('canvas', {width: 32, height: 32});
  const pen = canvas.getContext('2d');
  if (!pen) return original;
  const ring = (share: number, colour: string): void => {
    pen.strokeStyle = colour;
    pen.beginPath();
    pen.arc(16, 16, 12, -Math.PI / 2, -Math.PI / 2 + 2 * Math.PI * share);
    pen.stroke();
  };
  const line = (...points: [number, number][]): void => {
    pen.strokeStyle = '#fff';
    pen.lineWidth = 4;
    pen.beginPath();
    for (const [x, y] of points) pen.lineTo(x, y);
    pen.stroke();
  };
  pen.lineWidth = 7;
  if (!ended(job.state)) {
    ring(1, '#9fb3c1');
    ring(Math.max(0.02, job.progress), '#1f7ae0');
    return canvas.toDataURL();
  }
  pen.fillStyle = job.state === 'succeeded' ? '#00662f' : job.state === 'failed' ? '#b01b10' : '#4c6272';
  pen.arc(16, 16, 16, 0, 2 * Math.PI);
  pen.fill();
  if (job.state === 'succeeded') line([8, 17], [14, 22], [24, 10]);
  else if (job.state === 'failed') line([16, 7], [16, 18], [16, 18], [16, 26]);
  else line([9, 16], [23, 16]);
  return canvas.toDataURL();
}

export function setTitle(name: string): void {
  document.title = `${name} · ${t('shell.name')}`;
}

// The title and the icon of the tab follow a job; null gives both back.
export function signTab(job: ListedJob | null): void {
  const link = document.querySelector<HTMLLinkElement>('link[rel="icon"]');
  if (link) link.href = job ? drawIcon(job) : original;
  document.title = !job ? t('shell.name')
    : `${job.state === 'running' ? percentOf(job) : t(`state.${job.state}`)} · ${nameOf(job)}`;
}
