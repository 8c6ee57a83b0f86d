// What the server still has to send: a line while it is on its way, and then the content or what is wrong.
import {el, replace, type Children} from '../dom';
import {api} from '../api/client';
import {t} from '../text';
import {problemBox} from './problem';

export function later<T>(ask: () => Promise<T>, build: (value: T) => Children): HTMLElement {
  const host = el('div', {class: 'stack'});
  const load = (): void => {
    replace(host, el('p', {class: 'quiet'}, t('shell.loading')));
    void ask().then((value) => replace(host, build(value)), (error: unknown) => replace(host, problemBox(error, load)));
  };
  load();
  return host;
}

// An SVG of a job as a picture of a blob: nothing in it can run or load.
export function pictureOf(svg: BlobPart, alt: string): HTMLImageElement {
  const image = el('img', {src: URL.createObjectURL(new Blob([svg], {type: 'image/svg+xml'})), alt});
  image.addEventListener('load', () => URL.revokeObjectURL(image.src));
  return image;
}
export const svgPicture = async (job: string, name: string, alt: string): Promise<HTMLImageElement> =>
  pictureOf(await (await api.artifact(job, name)).arrayBuffer(), alt);
