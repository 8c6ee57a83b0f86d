// A problem as a person reads it: what, where, what to do; the code last, to quote.
import {Problem} from '../api/client';
import type {ProblemBody} from '../api/types';
import {el, newId, type Children} from '../dom';
import {announce} from '../state';
import {currentLanguage, t} from '../text';
import {icon} from './icon';
import {inEnglish, settingsInWords, wordsOf, type Words} from './words';

// In the language of the person. `exact`: what the service says in English, where that is another language.
function explained({code, status, message, body: {title, fix}}: Problem): Words & {exact?: string} {
  if (code === 'no-server') return {what: t('problem.no_server'), fix: t('problem.no_server_fix')};
  if (currentLanguage() === 'en' || status === 0) return {title, what: message, fix};
  return {...wordsOf('error', code), exact: [message, fix].filter(Boolean).join(' – ')};
}
const exactly = (exact: string): Children => [t('problem.exact'), ': ', inEnglish(exact)];

// What is wrong, in one line.
export function problemName(body: ProblemBody): Children {
  const problem = new Problem(body), {title = t('problem.title'), what, exact} = explained(problem);
  return exact ? [title, ': ', inEnglish(problem.message)] : what;
}

// What is wrong and what to do, in one line.
export function problemLine(body: ProblemBody): Children {
  const problem = new Problem(body), {title, what, fix, exact} = explained(problem);
  if (problem.code === 'no-server') return what;
  const line = [exact ? title : what || title, fix && t('problem.fix', {fix})].filter(Boolean).join('. ');
  return [settingsInWords(line), exact && [el('br'), exactly(exact)]];
}

// `retry`: adds a button that tries again.
export function problemBox(error: unknown, retry?: () => void): HTMLElement {
  const problem = error instanceof Problem ? error : null;
  const {title, what, fix, exact}: ReturnType<typeof explained> = problem ? explained(problem) : {what: String(error)};
  const where = problem?.body.where, answered = problem && problem.code !== 'no-server';
  const id = newId('problem');
  const details = [what, where, fix, exact, problem?.code, problem?.requestId].filter(Boolean).join('\n');
  return el('section', {class: 'problem', role: 'alert', 'aria-labelledby': id},
    el('h2', {id, tabindex: -1}, icon('error'), title || t('problem.title')),
    what && el('p', null, what),
    where && el('p', null, t('problem.where', {where})),
    fix && el('p', null, settingsInWords(t('problem.fix', {fix}))),
    exact && el('p', null, exactly(exact)),
    el('p', {class: 'row'},
      retry && el('button', {type: 'button', class: 'primary', onclick: retry}, t('shell.retry')),
      el('button', {type: 'button', onclick: () => {
        void navigator.clipboard.writeText(details).then(() => announce(t('problem.copied')));
      }}, icon('copy'), t('problem.copy')),
      answered && el('a', {href: `/problems/${problem.code}`}, t('problem.explained'))),
    answered && el('p', {class: 'quiet small'}, t('problem.code', {code: problem.code})));
}
