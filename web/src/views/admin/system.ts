// How the service does. What is wrong comes first, in words and with what to do.
import {api} from '../../api/client';
import type {JobState, Service} from '../../api/types';
import {el, type Children} from '../../dom';
import {facts, type Fact} from '../../parts/facts';
import {icon} from '../../parts/icon';
import {toJob} from '../../route';
import {bytes, duration, number, percent, t, when} from '../../text';
import {onEnd} from '../../view';
import {loaded} from './loaded';

const longWait = 600;  // seconds in the queue that an administrator should know of
const oldBackup = 7;   // days
const states: JobState[] = ['running', 'cancelling', 'succeeded', 'failed', 'cancelled'];

const daysSince = (time: string): number => Math.floor((Date.now() - new Date(time).getTime()) / 86_400_000);

function faults(service: Service): string[] {
  const {disk, queue, workers} = service;
  const lacking = workers.filter((worker) => worker.lacks?.length);
  return [
    disk.free_bytes <= disk.kept_free_bytes ? t('admin.fault_disk_full')
    : disk.free_bytes < 2 * disk.kept_free_bytes || disk.free_bytes < disk.total_bytes / 20 ? t('admin.fault_disk', {free: bytes(disk.free_bytes)})
    : '',
    workers.length === 0 ? t('admin.fault_workers') : '',
    workers.length > 0 && (queue.oldest_seconds ?? 0) > longWait
      ? t('admin.fault_queue', {time: duration(queue.oldest_seconds ?? 0)}) : '',
    ...lacking.map(({worker, lacks}) => t('admin.fault_sandbox', {worker, measures: (lacks ?? []).join(', ')})),
    service.last_backup === null ? t('admin.fault_no_backup')
    : daysSince(service.last_backup) >= oldBackup ? t('admin.fault_backup', {days: daysSince(service.last_backup)}) : '',
  ].filter(Boolean);
}

const card = (title: string, ...children: Children[]): HTMLElement =>
  el('section', {class: 'card'}, el('h2', null, title), ...children);

function build(service: Service): Children {
  const wrong = faults(service);
  const {disk, queue} = service;
  const used = disk.total_bytes - disk.free_bytes;
  return [
    wrong.length === 0
      ? el('p', {class: 'notice good'}, icon('check'), el('span', null, t('admin.all_well')))
      : el('ul', {class: 'faults'}, wrong.map((text) => el('li', {class: 'notice'}, icon('warning'), el('span', null, text)))),
    el('div', {class: 'cards'},
      card(t('admin.queue'),
        facts(
          [t('admin.queue_length'), number(queue.length)],
          queue.oldest_seconds !== null && [t('admin.queue_oldest'), duration(queue.oldest_seconds)],
          ...states.map((state): Fact => [t(`state.${state}`), String(service.jobs[state] ?? 0)]))),
      card(t('admin.disk'),
        el('p', null, t('admin.disk_free', {free: bytes(disk.free_bytes), total: bytes(disk.total_bytes)})),
        el('progress', {max: disk.total_bytes, value: used, 'aria-label': t('admin.disk_used')}, percent(used / disk.total_bytes)),
        el('p', {class: 'quiet small'}, t('admin.disk_kept', {kept: bytes(disk.kept_free_bytes)}))),
      card(t('admin.workers'),
        service.workers.length === 0 ? el('p', null, t('admin.no_workers'))
        : el('ul', {class: 'workers'}, service.workers.map((worker) => el('li', null,
            el('strong', null, worker.worker), ' ',
            worker.job ? el('a', {href: toJob(worker.job)}, t('admin.worker_busy'))
                       : el('span', {class: 'quiet'}, t('admin.worker_free')),
            el('p', {class: 'quiet small'}, t('admin.worker_seen', {time: when(worker.last_seen)}), ' ',
               worker.sandbox === null ? t('admin.sandbox_unknown')
               : t('admin.sandbox', {measures: worker.sandbox.join(', ') || t('admin.sandbox_none')})))))),
      card(t('admin.backup'),
        el('p', null, service.last_backup ? t('admin.backup_last', {time: when(service.last_backup)}) : t('admin.backup_none')),
        el('p', {class: 'quiet small'}, t('admin.backup_how'))),
      card(t('admin.versions'),
        facts(
          [t('admin.version'), el('code', null, service.version)],
          [t('admin.schema'), String(service.schema)],
          [t('admin.uptime'), duration(service.uptime_seconds)]))),
  ];
}

export function system(): Children {
  const {host, read} = loaded(() => api.service<Service>(), build);
  const timer = setInterval(() => {
    if (!document.hidden) void read();
  }, 10_000);
  onEnd(() => clearInterval(timer));
  return [el('p', {class: 'quiet'}, t('admin.system_intro')), host];
}
