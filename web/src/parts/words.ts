// What the service says about a warning or a problem. It speaks English. Other languages have texts by its codes; its own
// sentence stays next to them, since it has the figures.
import {el, type Children} from '../dom';
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
export const inEnglish = (text: string): HTMLElement => el('span', {lang: currentLanguage() === 'en' ? null : 'en'}, settingsInWords(text));

const words = (key: string): string => {
  const text = key.replace(/_(mm|deg|c|kpa|mm_s|w_m2k|ms)$/, '').replaceAll('_', ' ');
  return text.charAt(0).toUpperCase() + text.slice(1);
};
export const labelOf = (id: string): string => textIfKnown(`setting.${id}`) ?? words(id.split('.')[1] ?? id);
export const choiceOf = (id: string, value: string): string =>
  textIfKnown(`choice.${id}.${value}`) ?? textIfKnown(`choice.${value}`) ?? value;

// A text of the service with its settings in words: "--set scan.up=-z" as the label and the value, and as a key.
export function settingsInWords(text: string): Children {
  return text.split(/(?:--set )?\b([a-z]+\.[a-z_]+(?:=[+-]?\w+(?:\.\w+)*)?)/).map((part, i): Children => {
    const [id = '', value] = part.split('=');
    if (i % 2 === 0 || textIfKnown(`setting.${id}`) === undefined) return part;
    const word = {auto: 'automatic', true: 'yes', false: 'no'}[value ?? ''];
    const shown = word ? textIfKnown(`settings.${word}`) : value && choiceOf(id, value) + (/_mm$/.test(id) ? ' mm' : '');
    return [el('q', {lang: currentLanguage()}, [labelOf(id), shown].filter(Boolean).join(': ')), ' ', el('code', {class: 'quiet'}, part)];
  });
}
