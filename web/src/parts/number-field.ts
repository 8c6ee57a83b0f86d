// A number as people type it, with comma or point. What can be read in two ways is refused with a question.
import {el, newId} from '../dom';
import {currentLanguage, t} from '../text';

export type Parsed =
  | {kind: 'number'; value: number}
  | {kind: 'doubt'; grouped: number; decimal: number}  // "1.234" in German: 1234 or 1.234
  | {kind: 'empty' | 'none'};

export function parseNumber(text: string, language: string): Parsed {
  const plain = text.replace(/[\s'’]/g, '').replace(/^[−–]/, '-');  // spaces and marks between groups
  if (plain === '') return {kind: 'empty'};
  const parts = /^([+-]?)(\d*(?:[.,]\d*)*)$/.exec(plain);
  const digits = parts?.[2] ?? '';
  if (!/\d/.test(digits)) return {kind: 'none'};
  const sign = parts?.[1] === '-' ? -1 : 1;
  const marks: string[] = digits.match(/[.,]/g) ?? [];
  const last = marks.at(-1) ?? '';
  const as = (grouping: string): number => sign * Number(digits.replaceAll(grouping, '').replace(',', '.'));
  const grouped = (rest: string, mark: string): boolean => new RegExp(`^\\d{1,3}(\\${mark}\\d{3})+$`).test(rest);
  if (marks.length <= 1) {
    const decimal = sign * Number(digits.replace(',', '.'));
    const groupMark = language === 'de' ? '.' : ',';
    const doubtful = last === groupMark && grouped(digits, last) && !digits.startsWith('0');
    return doubtful ? {kind: 'doubt', grouped: as(last), decimal} : {kind: 'number', value: decimal};
  }
  if (marks.every((mark) => mark === last))  // 1.234.567
    return grouped(digits, last) ? {kind: 'number', value: as(last)} : {kind: 'none'};
  const first = marks[0] ?? '';
  const whole = digits.slice(0, digits.lastIndexOf(last));
  if (first === last || marks.indexOf(last) !== marks.length - 1 || !grouped(whole, first)) return {kind: 'none'};
  return {kind: 'number', value: as(first)};
}

// As it is typed: no marks between groups, so that it can be read in one way only.
export function typed(value: number, language: string): string {
  const text = String(Number(value.toPrecision(12)));
  return language === 'de' ? text.replace('.', ',') : text;
}

export interface NumberOptions {
  id: string;
  label: string;             // for screen readers only, where the field has no label of its own
  unit: string;              // as it is shown, or empty
  min?: number | undefined;
  max?: number | undefined;
  whole?: boolean;
  describedBy?: string;
  named?: boolean;           // has a <label>
  // The number, or null and the reason why it cannot be used.
  change(value: number | null, fault: string): void;
}

export interface NumberField {
  element: HTMLElement;
  input: HTMLInputElement;
  show(value: number | null): void;
}

// A unit as it follows a number.
export const joined = (unit: string): string => unit === '' || unit === '°' ? unit : `\u00a0${unit}`;

export function rangeText(min: number | undefined, max: number | undefined, unit: string): string {
  const language = currentLanguage();
  if (min === undefined || max === undefined) return '';
  return t('settings.range', {min: typed(min, language), max: typed(max, language), unit: joined(unit)});
}

export function numberField(options: NumberOptions): NumberField {
  const {min, max, unit} = options;
  const language = currentLanguage();
  const withUnit = (text: string): string => text + joined(unit);
  const answerId = newId('read');
  const signed = (min ?? -1) < 0;
  const input = el('input', {
    id: options.id, type: 'text', autocomplete: 'off', spellcheck: 'false', class: 'number-input',
    inputmode: signed ? null : 'decimal', 'aria-label': options.named ? null : options.label,
    'aria-describedby': [options.describedBy, answerId].filter(Boolean).join(' '),
    onchange: () => read(), onkeydown: (event) => { if (event.key === 'Enter') { event.preventDefault(); read(); } }});
  const answer = el('div', {class: 'answer', id: answerId, role: 'status'});
  let shown = '';

  function fault(text: string, ...more: Node[]): void {
    input.setAttribute('aria-invalid', 'true');
    answer.replaceChildren(el('p', {class: 'fault'}, text), ...more);
    options.change(null, text);
  }
  function take(value: number): void {
    const text = typed(value, language);
    if ((min !== undefined && value < min) || (max !== undefined && value > max)) {
      fault(t('settings.out_of_range', {range: rangeText(min, max, unit)}));
      return;
    }
    if (options.whole && !Number.isInteger(value)) {
      fault(t('settings.not_whole'));
      return;
    }
    input.removeAttribute('aria-invalid');
    const same = input.value.trim() === text;
    input.value = shown = text;
    answer.replaceChildren(same ? '' : el('p', {class: 'hint'}, t('settings.read_as', {value: withUnit(text)})));
    options.change(value, '');
  }
  function read(): void {
    if (input.value === shown && !input.hasAttribute('aria-invalid')) return;
    const parsed = parseNumber(input.value, language);
    switch (parsed.kind) {
      case 'number': return take(parsed.value);
      case 'empty': return fault(t('settings.no_number', {range: rangeText(min, max, unit)}));
      case 'none': return fault(t('settings.not_a_number', {example: withUnit(typed(1.5, language))}));
      case 'doubt': {
        const choice = (value: number): HTMLElement => el('button', {
          type: 'button', onclick: () => { input.value = ''; take(value); input.focus(); }}, withUnit(typed(value, language)));
        fault(t('settings.which_number', {text: input.value}),
          el('p', {class: 'row'}, choice(parsed.decimal), choice(parsed.grouped)));
      }
    }
  }
  return {
    input,
    element: el('div', {class: 'number-field'},
      el('span', {class: 'with-unit'}, input, unit && el('span', {class: 'unit'}, unit)), answer),
    show(value) {
      const text = value === null ? '' : typed(value, language);
      if (text === shown && !input.hasAttribute('aria-invalid')) return;
      input.value = shown = text;
      input.removeAttribute('aria-invalid');
      answer.replaceChildren();
    },
  };
}
