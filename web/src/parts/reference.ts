// The reference of a job that exists: how it is corrected, and what is said of its corrections.
import {api, Problem} from '../api/client';
import type {Job} from '../api/types';
import {el, newId, type Children} from '../dom';
import {toNew} from '../route';
import {t, when} from '../text';
import {openDialog} from './confirm';
import {icon} from './icon';
import {problemLine} from './problem';

const longest = 64;  // characters
const named = (reference: string): string => reference || t('job.no_reference');

// Asks for another reference until the service takes it. The job after the change; null if the person cancels.
export async function changeReference(job: Job): Promise<Job | null> {
  const title = newId('reference'), field = newId('reference'), hint = newId('reference');
  let text = job.reference, why: Children = null, taken = false, rescan = false;
  for (;;) {
    const input = el('input', {type: 'text', id: field, value: text, maxlength: longest, autocomplete: 'off', spellcheck: 'false', autofocus: true,
                               'aria-describedby': hint});
    const box: HTMLInputElement = el('input', {type: 'checkbox', checked: rescan});
    const answer = await openDialog({'aria-labelledby': title},
      el('h2', {id: title}, t(job.reference ? 'job.change_reference' : 'job.add_reference')),
      why && el('p', {class: 'notice', role: 'alert'}, icon('warning'), el('span', null, why)),
      el('div', {class: 'field'}, el('label', {for: field}, t('job.reference')), el('p', {class: 'hint', id: hint}, t('new.reference_hint')), input),
      taken && el('label', {class: 'choice'}, box, t('new.rescan')),
      el('div', {class: 'row end'},
        el('button', {type: 'submit', value: 'yes', class: 'primary'}, t('job.save_reference')),
        el('button', {type: 'submit', value: 'no', formnovalidate: true}, t('shell.cancel'))));
    if (answer !== 'yes') return null;
    text = input.value.trim();
    rescan = box.checked;
    try {
      return await api.setReference(job.id, text, rescan, job.version);
    } catch (error) {
      if (!(error instanceof Problem)) throw error;
      taken = error.body.where === 'reference' && error.status === 409;
      why = taken ? t('new.reference_taken') : problemLine(error.body);
      if (error.status === 412) job = await api.job(job.id);  // it went on meanwhile: ask again, with what it is now
    }
  }
}

// Who changed the reference, and that the print still has the former one.
export function referenceChanges(job: Job): Children {
  const {reference_changes: changes, printed_reference: printed} = job;
  return [
    printed !== null && printed !== job.reference && el('div', {class: 'notice settle'}, icon('warning'),
      el('p', null, t('job.printed_reference', {printed: named(printed), reference: named(job.reference)})),
      job.state === 'succeeded' && el('a', {class: 'button', href: toNew(`from=${job.id}`)}, icon('copy'), t('job.new_from'))),
    changes.length > 0 && el('ul', {class: 'plain-list small quiet', 'aria-label': t('job.reference_changes')}, changes.map((change) =>
      el('li', null, t('job.reference_change', {time: when(change.time), owner: change.owner, token: change.token, old: named(change.old),
                                                new: named(change.new)}))))];
}
