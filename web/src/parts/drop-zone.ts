// A place for a file: a button, and a drop anywhere on it or, with `everywhere`, on the page.
import {el} from '../dom';
import {icon} from './icon';

export interface DropZoneOptions {
  id: string;
  label: string;          // of the button
  hint: string;
  accept: readonly string[];  // extensions with their point
  everywhere?: boolean;   // a file of these kinds that is dropped elsewhere on the page is taken too
  take(file: File): void;
  refused(name: string): void;  // a file of another kind
}

export interface DropZone {
  element: HTMLElement;
  button: HTMLElement;
  end(): void;            // no more drops on the page
}

export function dropZone(options: DropZoneOptions): DropZone {
  const {accept, id} = options;
  const fits = (file: File): boolean => accept.some((extension) => file.name.toLowerCase().endsWith(extension));
  const offer = (files: FileList | null | undefined): void => {
    const given = [...files ?? []];
    const file = given.find(fits);
    if (file) options.take(file);
    else if (given[0]) options.refused(given[0].name);
  };
  const input = el('input', {type: 'file', class: 'hidden', tabindex: -1, 'aria-hidden': 'true', accept: accept.join(','), onchange: () => {
    offer(input.files);
    input.value = '';
  }});
  const button = el('button', {type: 'button', id, 'aria-describedby': `${id}-hint`, onclick: () => input.click()}, icon('upload'), options.label);
  const element = el('div', {class: 'drop-zone'}, button, input, el('p', {class: 'hint', id: `${id}-hint`}, options.hint));
  const hasFiles = (event: DragEvent): boolean => event.dataTransfer?.types.includes('Files') ?? false;
  const over = (event: DragEvent): void => {
    if (!hasFiles(event)) return;
    event.preventDefault();
    element.classList.add('over');
  };
  const leave = (): void => element.classList.remove('over');
  element.addEventListener('dragover', over);
  element.addEventListener('dragleave', leave);
  element.addEventListener('drop', (event) => {
    leave();
    if (!hasFiles(event)) return;
    event.preventDefault();
    event.stopPropagation();
    offer(event.dataTransfer?.files);
  });
  const overPage = (event: DragEvent): void => { if (hasFiles(event)) event.preventDefault(); };
  const dropOnPage = (event: DragEvent): void => {
    leave();
    const file = [...event.dataTransfer?.files ?? []].find(fits);
    if (!file || event.defaultPrevented) return;
    event.preventDefault();
    options.take(file);
  };
  if (options.everywhere) {
    document.addEventListener('dragover', overPage);
    document.addEventListener('drop', dropOnPage);
  }
  return {element, button, end() {
    document.removeEventListener('dragover', overPage);
    document.removeEventListener('drop', dropOnPage);
  }};
}
