// What the service says about a warning or a problem. It speaks English. Other languages have texts by its codes; its own
// sentence stays next to them, since it has the figures.
import {el} from '../dom';
import {currentLanguage, textIfKnown} from '../text';

export interface Words {
  title?: string | undefined;
  what?: string | undefined;
  fix?: string | undefined;
}
export const wordsOf = (kind: 'warning' | 'error', code: string): Words => {
  const key = `${kind}.${code}`;
  return {title: textIfKnown(key), what: textIfKnown(`${key}.what`), fix: textIfKnown(`${key}.fix`)};
};

// Marked as English for screen readers.
export const inEnglish = (text: string): HTMLElement => el('span', {lang: currentLanguage() === 'en' ? null : 'en'}, text);
