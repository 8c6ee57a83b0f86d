// Children that need an answer of the server: a line while it is read, the problem if it fails.
import {el, replace, type Children} from '../../dom';
import {problemBox} from '../../parts/problem';
import {t} from '../../text';

export interface Loaded {
  host: HTMLElement;
  // Asks again; what is shown stays until the answer is there.
  read(): Promise<void>;
}

export function loaded<T>(ask: () => Promise<T>, build: (answer: T) => Children): Loaded {
  const host = el('div', {class: 'stack', 'aria-busy': 'true'}, el('p', {class: 'quiet'}, t('shell.loading')));
  const read = async (): Promise<void> => {
    let children: Children;
    try {
      children = build(await ask());
    } catch (error) {
      children = problemBox(error, () => void read());
    }
    replace(host, children);
    host.removeAttribute('aria-busy');
  };
  void read();
  return {host, read};
}
