// The state of a job: a word with an icon, and how many serious warnings it has.
import {el, type Child} from '../dom';
import type {JobState, ListedJob} from '../api/types';
import {t} from '../text';
import {icon, type IconName} from './icon';

const icons: Record<JobState, IconName> = {
  queued: 'more', running: 'resume', succeeded: 'check', failed: 'error', cancelling: 'cancel', cancelled: 'cancel'};

export const stateBadge = (job: Pick<ListedJob, 'state' | 'serious_warnings'>): Child[] => [
  el('span', {class: `state ${job.state}`}, icon(icons[job.state]), t(`state.${job.state}`)),
  job.serious_warnings ? el('span', {class: 'state serious'}, icon('warning'),
                            t('jobs.serious', {count: job.serious_warnings})) : null,
];
