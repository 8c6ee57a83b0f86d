// Warnings, serious ones first: what, where, what to do, and the way to the place.
import {el} from '../dom';
import {bySeverity, type Severity, type Warning} from '../state/jobs';
import {currentLanguage, number, t, textIfKnown} from '../text';
import {icon, type IconName} from './icon';
import {inEnglish, settingsInWords, wordsOf} from './words';

const icons: Record<Severity, IconName> = {serious: 'error', warning: 'warning', note: 'info'};
// "0.57 mm, limit 0.8 mm". Units that are words have texts.
function figureText({value, unit, limit}: NonNullable<Warning['figure']>): string {
  const of = /^of (\d+) elements$/.exec(unit)?.[1];
  const written = (amount: number): string =>
    `${number(amount, Number.isInteger(amount) || Math.abs(amount) < 10 ? undefined : 1)} ${of ? t('job.unit_of', {count: of}) : textIfKnown(`job.unit_${unit}`) ?? unit}`.trim();
  return limit ? t('job.figure', {figure: written(value), limit: written(limit)}) : written(value);
}

// Where, in the language of the person: names, or a place in mm; empty where the server says it in other words.
function placeText({marks, place}: Warning): string {
  const names = place.split(/, | and /);
  if (place && names.every((name) => /^\S+$/.test(name))) return new Intl.ListFormat(currentLanguage()).format(names);
  const [x, y, z] = marks[0]?.place_mm.map((mm) => number(mm, 1)) ?? [];
  if (x === undefined || y === undefined || z === undefined) return '';
  const first = t('job.place_at', {x, y, z});
  return marks.length === 1 ? first : t('job.places', {place: first, count: marks.length - 1});
}

// Shows the places of a warning one after the other.
function showButton(warning: Warning, show: (place: readonly number[]) => void): HTMLElement {
  let next = 0;
  const {length} = warning.marks;
  const words = el('span', null);
  const label = (): void => {
    words.textContent = length === 1 ? t('job.show') : t('job.show_place', {place: next + 1, count: length});
  };
  label();
  return el('button', {type: 'button', onclick: () => {
    const mark = warning.marks[next];
    if (mark) show(mark.place_mm);
    next = (next + 1) % length;
    label();
  }}, icon('view'), words, el('span', {class: 'hidden'}, ': ', textIfKnown(`warning.${warning.code}`) ?? warning.code));
}

function item(warning: Warning, show?: (place: readonly number[]) => void): HTMLElement {
  const severity: Severity = warning.severity in icons ? warning.severity : 'warning';
  const {title = warning.code, what: meaning, fix = warning.fix} = wordsOf('warning', warning.code);
  const place = meaning ? placeText(warning) : warning.place;
  return el('li', {class: `warning ${severity}`},
    icon(icons[severity]),
    el('div', null,
      el('h3', null, title, ' ',
        el('span', {class: `state ${severity}`}, t(`severity.${severity}`))),
      el('p', null, meaning ?? warning.what),
      place && el('p', null, t('problem.where', {where: place})),
      meaning && warning.figure && el('p', null, figureText(warning.figure)),
      fix && el('p', null, settingsInWords(t('problem.fix', {fix}))),
      meaning && el('details', null, el('summary', null, t('problem.exact')),
        el('p', null, inEnglish([warning.what, warning.place, warning.fix].filter(Boolean).join(' – ')))),
      show && warning.marks.length > 0 && el('p', null, showButton(warning, show)),
      el('p', {class: 'quiet small'}, t('problem.code', {code: warning.code}))));
}

export const warningsList = (warnings: readonly Warning[], show?: (place: readonly number[]) => void): HTMLElement =>
  warnings.length === 0
    ? el('p', {class: 'notice good'}, icon('check'), t('job.no_warnings'))
    : el('ul', {class: 'warnings'}, ...bySeverity(warnings).map((warning) => item(warning, show)));
