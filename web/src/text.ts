// Every text by its key, in the language of the person. "{name}" stands for a value; "{count, one: coil, other: coils}"
// chooses by the plural rules of the language.
import keys from 'messages:keys';
import type shell from '../lang/en/shell.json';
import type jobs from '../lang/en/jobs.json';
import type print from '../lang/en/new.json';
import type result from '../lang/en/result.json';
import type scan from '../lang/en/scan.json';
import type job from '../lang/en/job.json';
import type settings from '../lang/en/settings.json';
import type warnings from '../lang/en/warnings.json';
import type admin from '../lang/en/admin.json';
import type help from '../lang/en/help.json';
import type array from '../lang/en/array.json';

export type Key = keyof (typeof shell & typeof jobs & typeof print & typeof scan & typeof job & typeof result & typeof settings &
                         typeof warnings & typeof admin & typeof help & typeof array);
type Values = Record<string, string | number>;

export const languages = ['en', 'de'] as const;
export type Language = (typeof languages)[number];
const keptUnder = 'vacuform.language';

let language: Language = 'en';
let messages: Record<string, string> = {};
let plurals = new Intl.PluralRules('en');

export function chosenLanguage(): Language {
  const wanted = [localStorage.getItem(keptUnder), ...navigator.languages].map((tag) => tag?.slice(0, 2));
  return languages.find((known) => known === wanted.find((tag) => languages.some((l) => l === tag))) ?? 'en';
}

// Stores the choice; the page is loaded again with it.
export function chooseLanguage(wanted: Language): void {
  localStorage.setItem(keptUnder, wanted);
  location.reload();
}

export async function loadLanguage(wanted: Language): Promise<void> {
  const {default: texts} = wanted === 'de' ? await import('messages:de') : await import('messages:en');
  useMessages(wanted, Object.fromEntries(keys.flatMap((key, i) => texts[i] ? [[key, texts[i]]] : [])));
  document.documentElement.lang = wanted;
}

export function useMessages(wanted: Language, all: Record<string, string>): void {
  language = wanted;
  messages = all;
  plurals = new Intl.PluralRules(wanted);
}

export const currentLanguage = (): Language => language;

export function t(key: Key, values: Values = {}): string {
  return filled(messages[key] ?? `[${key}]`, values);
}

// The text of a key that comes from the server, such as the name of a setting; undefined without a text.
export function textIfKnown(key: string, values: Values = {}): string | undefined {
  const text = messages[key];
  return text === undefined ? undefined : filled(text, values);
}

function filled(text: string, values: Values): string {
  return text.replace(/\{(\w+)(?:, one: ([^{}]*), other: ([^{}]*))?\}/g, (whole, name: string, one, other) => {
    const value = values[name];
    if (value === undefined) return whole;
    if (one !== undefined) return plurals.select(Number(value)) === 'one' ? String(one) : String(other);
    return typeof value === 'number' ? number(value) : value;
  });
}

// 1234.5 -> "1,234.5" or "1.234,5"; with `digits`, that many behind the point.
export function number(value: number, digits?: number): string {
  const options = digits === undefined ? {maximumFractionDigits: 3}
                                       : {minimumFractionDigits: digits, maximumFractionDigits: digits};
  return new Intl.NumberFormat(language, options).format(value);
}

export const withUnit = (value: number, unit: string, digits?: number): string => `${number(value, digits)} ${unit}`;
export const percent = (share: number, digits = 0): string => withUnit(share * 100, '%', digits);

// "3.4 MB": decimal megabytes, as the operating systems of the users count.
export function bytes(count: number): string {
  if (count < 1000) return withUnit(count, 'B');
  const units = ['kB', 'MB', 'GB', 'TB'];
  let at = -1;
  do {
    count /= 1000;
    ++at;
  } while (count >= 999.5 && at < units.length - 1);
  return withUnit(count, units[at] ?? 'TB', count < 10 ? 1 : 0);
}

// A time of the API (RFC 3339, UTC) as local time with its zone, as people write it in the region of the browser.
export function when(time: string): string {
  return new Date(time).toLocaleString(navigator.languages.find((tag) => tag.startsWith(language)) ?? language, {
    year: 'numeric', month: 'short', day: 'numeric', hour: '2-digit', minute: '2-digit', timeZoneName: 'short'});
}

// "12 s", "3 min", "1 h 20 min"
export function duration(seconds: number): string {
  if (seconds < 100) return withUnit(Math.round(seconds), 's');
  const minutes = Math.round(seconds / 60);
  if (minutes < 100) return withUnit(minutes, 'min');
  return `${withUnit(Math.floor(minutes / 60), 'h')} ${withUnit(minutes % 60, 'min')}`;
}
