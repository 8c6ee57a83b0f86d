// The files of a job: the one to print first, then all others; greyed while they do not match what is shown.
import {el, newId, replace} from '../dom';
import {artifactPath} from '../api/client';
import type {Artifact, Job} from '../api/types';
import {bytes, t, textIfKnown} from '../text';
import {icon} from './icon';

const first = ['print.pdf', 'colours.pdf', 'pattern.svg', 'print.svg', 'print.png', 'report.html', 'mold.stl', 'formed.glb'];
const rank = (name: string): number => first.includes(name) ? first.indexOf(name) : first.length;

export const titleOf = (artifact: Pick<Artifact, 'name' | 'title'>): string =>
  textIfKnown(`artifact.${artifact.name}`) ?? artifact.title;

// While a serious warning is open, no file is called the one to print.
export function downloads(job: Job): {element: HTMLElement; setStale(stale: boolean): void} {
  const reason = newId('stale'), held = (job.serious_warnings ?? 0) > 0;
  const element = el('section', {class: 'card stack downloads'});
  const link = (href: string, stale: boolean, main: boolean, ...words: (Node | string)[]): HTMLElement =>
    stale ? el('span', {class: 'button', role: 'link', 'aria-disabled': 'true', 'aria-describedby': reason}, icon('download'), ...words)
          : el('a', {class: main ? 'button primary' : 'button', href, download: true}, icon('download'), ...words);
  const row = (file: Artifact, stale: boolean): HTMLElement =>
    el('li', null,
      link(artifactPath(job.id, file.name), stale, file.name === 'print.pdf' && !held, file.name),
      el('span', null, titleOf(file), ' ', el('span', {class: 'quiet'}, bytes(file.bytes)),
        file.name === 'print.pdf' && !stale && (held ? el('strong', {class: 'state warning'}, icon('warning'), t('job.not_to_print'))
          : el('strong', {class: 'state succeeded'}, icon('print'), t('job.to_print')))));
  function setStale(stale: boolean): void {
    const files = [...job.artifacts].sort((a, b) => rank(a.name) - rank(b.name));
    const main = files.filter((file) => rank(file.name) < first.length);
    const more = files.filter((file) => rank(file.name) === first.length);
    const sum = files.reduce((all, file) => all + file.bytes, 0);
    replace(element, [
      el('h2', {id: 'downloads', tabindex: -1}, t('job.downloads')),
      stale && el('p', {class: 'notice', id: reason, role: 'status'}, icon('warning'), t('job.stale')),
      el('ul', null, ...main.map((file) => row(file, stale))),
      more.length > 0 && el('details', null, el('summary', null, t('job.more_files', {count: more.length})),
        el('ul', null, ...more.map((file) => row(file, stale)))),
      job.links['zip'] && el('p', {class: 'row'}, link(job.links['zip'], stale, false, t('job.zip')),
        el('span', {class: 'quiet'}, t('job.zip_size', {size: bytes(sum)}))),
    ]);
  }
  setStale(false);
  return {element, setStale};
}
