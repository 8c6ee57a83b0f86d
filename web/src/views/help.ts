// Help: the tutorial with the bundled sample, what the figures mean, keys, errors that the page guards against, limits.
import {el, type Children} from '../dom';
import {icon} from '../parts/icon';
import {toHelp, toNew} from '../route';
import {store} from '../state';
import {t} from '../text';
import {View} from '../view';
import {sampleButton} from './help/sample';

const steps = ['scan', 'pattern', 'machine', 'start', 'result', 'print'] as const;
const figures = ['round', 'area', 'shape', 'thickness', 'temperature', 'stretch', 'inductance', 'coupling'] as const;
const guards = ['scan', 'unit', 'mirror', 'face', 'stale', 'scale', 'tabs'] as const;
const limits = ['model', 'map', 'undercut', 'machine', 'measured'] as const;
const keys = {
  turn: ['←', '→', '↑', '↓'], fine: ['Shift', '←'], move: ['Ctrl', '←'], zoom: ['+', '−'], home: ['Home'], views: ['1', '6'], compare: ['B'],
  inspect: ['I'], leave: ['Esc']} as const;
const keyNames = Object.keys(keys) as (keyof typeof keys)[];

const tutorial = (): Children => [
  el('p', null, t('help.tutorial_intro')),
  sampleButton(),
  el('ol', {class: 'steps'}, steps.map((step) =>
    el('li', null, el('h3', null, t(`help.step_${step}`)), el('p', null, t(`help.step_text_${step}`))))),
  el('p', null, el('a', {class: 'button', href: toNew()}, icon('add'), t('shell.new'))),
];

const list = (names: readonly (readonly [string, string])[]): HTMLElement =>
  el('dl', {class: 'terms'}, names.map(([name, text]) => el('div', null, el('dt', null, name), el('dd', null, text))));

const sections = {
  tutorial,
  figures: (): Children => [
    el('p', null, t('help.figures_intro')),
    list(figures.map((name) => [t(`help.figure_${name}`), t(`help.figure_text_${name}`)] as const))],
  keys: (): Children => [
    el('p', null, t('help.keys_intro')),
    el('dl', {class: 'keys'}, keyNames.map((name) => el('div', null,
      el('dt', null, keys[name].map((key, i) => [i > 0 && (name === 'views' ? ' – ' : ' '), el('kbd', null, key)])),
      el('dd', null, t(`help.key_${name}`))))),
    el('p', null, t('help.keys_touch'))],
  safety: (): Children => [
    el('p', null, t('help.safety_intro')),
    list(guards.map((name) => [t(`help.guard_${name}`), t(`help.guard_text_${name}`)] as const))],
  limits: (): Children => [
    el('p', {class: 'notice'}, icon('warning'), el('span', null, t('help.not_a_device'))),
    el('ul', null, limits.map((name) => el('li', null, t(`help.limit_${name}`))))],
} satisfies Record<string, () => Children>;
type Section = keyof typeof sections;
const names = Object.keys(sections) as Section[];

class Help extends View {
  protected build(): Children {
    const {route} = store.get();
    const asked = route.view === 'help' ? route.page : '';
    const place = names.find((name) => name === asked);
    // After the frame has moved the page to its top.
    if (place) requestAnimationFrame(() => this.querySelector<HTMLElement>(`#help-${place}`)?.focus());
    return [
      el('h1', null, t('shell.help')),
      el('div', {class: 'help'},
        el('nav', {'aria-label': t('help.contents')}, el('ul', null, names.map((name) =>
          el('li', null, el('a', {href: toHelp(name), 'aria-current': name === place && 'location'}, t(`help.title_${name}`)))))),
        el('div', {class: 'stack'}, names.map((name) =>
          el('section', {class: 'card', 'aria-labelledby': `help-${name}`},
             el('h2', {id: `help-${name}`, tabindex: -1}, t(`help.title_${name}`)), sections[name]())))),
    ];
  }
}
customElements.define('vf-help', Help);
