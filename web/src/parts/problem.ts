// A problem as a person reads it: what, where, what to do; the code last, to quote.
import {Problem} from '../api/client';
import {el, newId} from '../dom';
import {announce} from '../state';
import {t} from '../text';
import {icon} from './icon';

// `retry`: adds a button that tries again.
export function problemBox(error: unknown, retry?: () => void): HTMLElement {
  const problem = error instanceof Problem ? error : null;
  const noServer = problem?.code === 'no-server';
  const what = noServer ? t('problem.no_server') : problem ? problem.message : String(error);
  const fix = noServer ? t('problem.no_server_fix') : problem?.body.fix;
  const id = newId('problem');
  const details = [what, problem?.body.where, fix, problem?.code, problem?.requestId].filter(Boolean).join('\n');
  return el('section', {class: 'problem', role: 'alert', 'aria-labelledby': id},
    el('h2', {id, tabindex: -1}, icon('error'), problem?.body.title || t('problem.title')),
    el('p', null, what),
    problem?.body.where && el('p', null, t('problem.where', {where: problem.body.where})),
    fix && el('p', null, t('problem.fix', {fix})),
    el('p', {class: 'row'},
      retry && el('button', {type: 'button', class: 'primary', onclick: retry}, t('shell.retry')),
      el('button', {type: 'button', onclick: () => {
        void navigator.clipboard.writeText(details).then(() => announce(t('problem.copied')));
      }}, icon('copy'), t('problem.copy')),
      problem && !noServer && el('a', {href: `/problems/${problem.code}`}, t('problem.explained'))),
    problem && !noServer && el('p', {class: 'quiet small'}, t('problem.code', {code: problem.code})));
}
