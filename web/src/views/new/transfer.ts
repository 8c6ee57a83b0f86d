// A file on its way to the server: bytes, speed, time left; pause and resume.
import {el, type Children} from '../../dom';
import {icon} from '../../parts/icon';
import {problemBox, problemLine} from '../../parts/problem';
import {bytes, duration, percent, t} from '../../text';
import {live} from '../../view';
import type {SentInput} from '../../state/draft';
import {removeIcc, removePattern, removeScan, uploadOf} from './work';

export function transferLine(input: SentInput): HTMLElement {
  return live((state) => state.draft.transfers[input], (transfer): Children => {
    if (!transfer || transfer.state === 'done') return null;
    const {state, sent, bytes: all, speed, left, problem} = transfer;
    const remove = {scan: removeScan, pattern: removePattern, icc: removeIcc}[input];
    if (state === 'failed')
      return problem?.code === 'file-changed'
        ? el('p', {class: 'notice', role: 'alert'}, icon('warning'), t('new.file_changed')) : problemBox(problem, () => uploadOf(input)?.resume());
    const share = all > 0 ? sent / all : 0;
    const facts = [
      t('new.sent', {sent: bytes(sent), all: bytes(all)}), speed !== null && t('new.speed', {speed: bytes(speed)}),
      left !== null && state === 'sending' && t('new.left', {time: duration(left)})].filter(Boolean).join(' · ');
    const stopped = state !== 'sending';
    return el('div', {class: 'transfer'},
      el('p', {class: 'spread'},
        el('strong', null, t(`new.transfer_${state}`)), el('span', {class: 'number'}, percent(share))),
      el('progress', {max: 1, value: share, 'aria-label': t(`new.transfer_${state}`)}),
      problem && el('p', null, problemLine(problem.body)),
      el('p', {class: 'quiet small'}, facts),
      el('p', {class: 'row'},
        el('button', {type: 'button', id: `${input}-pause`, onclick: () => stopped ? uploadOf(input)?.resume() : uploadOf(input)?.pause()},
          icon(stopped ? 'resume' : 'pause'), t(state === 'waiting' ? 'new.try_now' : stopped ? 'new.resume' : 'new.pause')),
        el('button', {type: 'button', id: `${input}-stop`, class: 'plain', onclick: remove}, icon('cancel'), t('new.stop_sending'))));
  });
}
