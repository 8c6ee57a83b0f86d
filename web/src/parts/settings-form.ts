// Fields for settings, made from their schema: label, unit, range, default and a reset for each.
import {el, newId, replace} from '../dom';
import type {FieldSchema, ProblemBody, Settings, SettingsSchema} from '../api/types';
import {announce} from '../state';
import {fieldOf, idsOf, sameValue, settingOf, valueOf} from '../state/draft';
import {currentLanguage, t, textIfKnown} from '../text';
import {icon} from './icon';
import {hasPictures, pictureChoice} from './picture-choice';
import {joined, numberField, rangeText, typed} from './number-field';
import {problemLine} from './problem';
import {choiceOf, labelOf} from './words';

export {choiceOf, labelOf};

export interface SettingsFormOptions {
  schema: SettingsSchema;
  prefix: string;                                // of the ids of the fields: one for each form on a page
  only?: readonly string[];                      // these settings, in this order; without it all, in groups with a search
  settings(): Settings;                          // what differs from the defaults
  change(id: string, value: unknown): void;      // undefined: back to the default
  fault?(id: string, text: string): void;        // text that cannot be used; empty when it is right again
}

export interface SettingsForm {
  element: HTMLElement;
  // Shows the settings as they are now, but leaves the fields that hold text which cannot be used. `problem`: what the server
  // says about one of them.
  show(faults?: Record<string, string>, problem?: ProblemBody | null): void;
  focus(id: string): boolean;                    // false if there is no such field
}

const units: Record<string, string> = {deg: '°', C: '°C', '1/in': 'dpi', '1': '', 'W/m2K': 'W/(m²·K)'};
export const unitOf = (field: FieldSchema | undefined): string => {
  const unit = (numeric(field) ?? field?.items)?.['x-unit'] ?? '';
  return units[unit] ?? unit;
};
const numeric = (field: FieldSchema | undefined): FieldSchema | undefined =>
  field?.type === 'number' || field?.type === 'integer' ? field : field?.oneOf?.find((one) => one.type === 'number' || one.type === 'integer');
const maybeAuto = (field: FieldSchema): boolean => field.oneOf !== undefined;

export const hintOf = (id: string, field: FieldSchema | undefined): string =>
  textIfKnown(`setting.${id}.hint`) ?? (currentLanguage() === 'en' ? field?.description ?? '' : '');
export const groupTitle = (group: string, schema: SettingsSchema): string =>
  textIfKnown(`group.${group}`) ?? schema.properties[group]?.title ?? group;

// A value as a person reads it.
export function valueText(id: string, field: FieldSchema | undefined, value: unknown): string {
  const unit = unitOf(field);
  const number = (v: number): string => typed(v, currentLanguage());
  if (value === 'auto') return t('settings.automatic');
  if (typeof value === 'number') return number(value) + joined(unit);
  if (typeof value === 'boolean') return t(value ? 'settings.yes' : 'settings.no');
  if (typeof value === 'string') return choiceOf(id, value);
  if (Array.isArray(value) && value.every((item) => typeof item === 'number'))
    return value.length === 0 ? t('settings.none') : value.map(number).join('; ') + joined(unit);
  const text = JSON.stringify(value);
  return text === '[]' || text === '{}' || text === undefined ? t('settings.none') : text;
}

interface Field {
  element: HTMLElement;
  target(): HTMLElement;   // what takes the focus
  show(value: unknown): void;
  say(problem: ProblemBody | null): void;  // why the server refuses the value
}

function build(id: string, schema: FieldSchema, options: SettingsFormOptions): Field {
  const htmlId = `${options.prefix}-${id.replace('.', '-')}`;
  const hintId = `${htmlId}-hint`;
  const label = labelOf(id), hint = hintOf(id, schema), unit = unitOf(schema);
  const number = numeric(schema);
  const range = schema.type === 'array' && schema.maxItems === 2 ? schema.items : number;
  const change = (value: unknown): void => {
    options.fault?.(id, '');
    options.change(id, sameValue(value, schema.default) ? undefined : value);
  };
  const facts = [
    rangeText(range?.minimum, range?.maximum, unit),
    t('settings.default', {value: valueText(id, schema, schema.default)})].filter(Boolean).join(' · ');
  const reset = el('button', {
    type: 'button', class: 'plain icon-only reset', 'aria-label': t('settings.reset', {label, value: valueText(id, schema, schema.default)}),
    title: t('settings.reset', {label, value: valueText(id, schema, schema.default)}),
    onclick: () => {
      change(schema.default);
      announce(t('settings.was_reset', {label}));
      focused().focus();
    }}, icon('reset'));
  const below = el('p', {class: 'hint', id: hintId}, hint && hint !== label && [hint, el('br')], facts);
  const labelled = (control: HTMLElement): HTMLElement[] => [
    el('span', {class: 'label-row'}, el('label', {for: htmlId}, label), reset), below, control];

  let target: HTMLElement, focused = (): HTMLElement => target;
  let parts: HTMLElement[];
  let apply: (value: unknown) => void;

  if (schema.type === 'boolean') {
    const box = el('input', {type: 'checkbox', id: htmlId, 'aria-describedby': hintId, onchange: () => change(box.checked)});
    target = box;
    parts = [el('span', {class: 'label-row'}, el('label', {class: 'choice', for: htmlId}, box, label), reset), below];
    apply = (value) => { box.checked = value === true; };
  } else if (schema.enum && hasPictures(id)) {
    const choice = pictureChoice({id, name: htmlId, legend: el('legend', {class: 'label-row'}, label, reset), values: schema.enum,
                                  describedBy: hintId, change});
    target = choice.element;
    focused = choice.target;
    parts = [choice.element, below];
    apply = (value) => choice.show(String(value));
  } else if (schema.enum) {
    const box = el('select', {id: htmlId, 'aria-describedby': hintId, onchange: () => change(box.value)},
      ...schema.enum.map((value) => el('option', {value}, value === 'auto' ? t('settings.automatic') : choiceOf(id, value))));
    target = box;
    parts = labelled(box);
    apply = (value) => { box.value = String(value); };
  } else if (number) {
    const field = numberField({
      id: htmlId, label, named: true, unit, min: number.minimum, max: number.maximum, whole: number.type === 'integer',
      describedBy: hintId, change: (value, fault) => value === null ? options.fault?.(id, fault) : change(value)});
    target = field.input;
    if (maybeAuto(schema)) {
      const auto = el('input', {type: 'checkbox', id: `${htmlId}-auto`, onchange: () => {
        if (auto.checked) change('auto');
        else {
          field.element.hidden = false;
          field.input.focus();
        }
      }});
      parts = [el('fieldset', {class: 'maybe-auto'},
        el('legend', {class: 'hidden'}, label), ...labelled(el('div', {class: 'row'},
          el('label', {class: 'choice', for: auto.id}, auto, t('settings.automatic')), field.element)))];
      apply = (value) => {
        auto.checked = value === 'auto';
        field.element.hidden = auto.checked;
        field.show(typeof value === 'number' ? value : null);
      };
      target = auto;
    } else {
      parts = labelled(field.element);
      apply = (value) => field.show(typeof value === 'number' ? value : null);
    }
  } else if (schema.type === 'array' && schema.maxItems === 2 && schema.items) {
    const {items} = schema;
    const names = [t('settings.first'), t('settings.second')];
    let now: number[] = [];
    const fields = names.map((name, at) => numberField({
      id: at === 0 ? htmlId : `${htmlId}-2`, label: name, named: true, unit, min: items.minimum, max: items.maximum, describedBy: hintId,
      change: (value, fault) => {
        if (value === null) options.fault?.(id, fault);
        else change(now = now.map((old, i) => i === at ? value : old));
      }}));
    target = fields[0]?.input ?? below;
    parts = [el('fieldset', null, el('legend', {class: 'label-row'}, label, reset), below, el('div', {class: 'row pair'},
      ...fields.map((field, at) => el('div', null, el('label', {for: field.input.id, class: 'small'}, names[at]), field.element))))];
    apply = (value) => {
      now = Array.isArray(value) ? value.map(Number) : [0, 0];
      fields.forEach((field, at) => field.show(now[at] ?? 0));
    };
  } else {  // a list or an object: as JSON
    const answer = el('div', {class: 'answer', role: 'status', id: `${htmlId}-answer`});
    const box = el('textarea', {id: htmlId, rows: 3, spellcheck: 'false', class: 'code', 'aria-describedby': `${hintId} ${answer.id}`, onchange: () => {
      try {
        change(box.value.trim() === '' ? schema.default : JSON.parse(box.value));
        box.removeAttribute('aria-invalid');
        answer.replaceChildren();
      } catch {
        const text = t('settings.not_json', {example: JSON.stringify(schema.type === 'array' ? [[1, 2]] : {name: 1})});
        box.setAttribute('aria-invalid', 'true');
        answer.replaceChildren(el('p', {class: 'fault'}, text));
        options.fault?.(id, text);
      }
    }});
    target = box;
    parts = [...labelled(box), answer];
    apply = (value) => {
      box.value = sameValue(value, schema.default) ? '' : JSON.stringify(value);
      box.removeAttribute('aria-invalid');
      answer.replaceChildren();
    };
  }
  const refused = el('p', {class: 'fault', hidden: true});
  const element = el('div', {class: 'field setting', id: `${htmlId}-field`}, ...parts, refused);
  return {
    element, target: focused,
    say(problem) {
      replace(refused, problem && problemLine(problem));
      refused.hidden = !problem;
    },
    show(value) {
      reset.hidden = sameValue(value, schema.default);
      element.classList.toggle('set', !reset.hidden);
      apply(value);
    },
  };
}

export function settingsForm(options: SettingsFormOptions): SettingsForm {
  const {schema} = options;
  const fields = new Map<string, Field>();
  for (const id of options.only ?? idsOf(schema)) {
    const field = fieldOf(schema, id);
    if (field) fields.set(id, build(id, field, options));
  }
  const element = el('div', {class: 'settings'});
  if (options.only) {
    element.append(el('div', {class: 'setting-grid'}, ...[...fields.values()].map((field) => field.element)));
  } else {
    element.append(...withSearch(options, fields));
  }
  const form: SettingsForm = {
    element,
    show(faults = {}, problem = null) {
      const settings = options.settings();
      for (const [id, field] of fields) {
        if (!(id in faults)) field.show(valueOf(schema, settings, id));
        field.say(problem?.where === id ? problem : null);
      }
    },
    focus(id) {
      const field = fields.get(id);
      if (!field) return false;
      field.element.hidden = false;
      for (let at: HTMLElement | null = field.element; at && at !== element; at = at.parentElement) at.hidden = false;
      field.element.scrollIntoView({block: 'center'});
      field.target().focus({preventScroll: true});
      return true;
    },
  };
  form.show();
  return form;
}

function withSearch(options: SettingsFormOptions, fields: Map<string, Field>): HTMLElement[] {
  const {schema, prefix} = options;
  const fold = (text: string): string => text.toLocaleLowerCase(currentLanguage());
  const texts = new Map([...fields.keys()].map((id) => [id, fold(
    [id, labelOf(id), hintOf(id, fieldOf(schema, id)), fieldOf(schema, id)?.description, groupTitle(id.split('.')[0] ?? '', schema),
      ...(fieldOf(schema, id)?.enum ?? []).map((value) => choiceOf(id, value))].join(' '))]));
  const groups = Object.keys(schema.properties).map((group) => {
    const ids = [...fields.keys()].filter((id) => id.startsWith(`${group}.`));
    const title = newId('group');
    return {ids, element: el('div', {class: 'setting-group', role: 'group', 'aria-labelledby': title},
      el('h4', {id: title}, groupTitle(group, schema)),
      el('div', {class: 'setting-grid'}, ...ids.map((id) => fields.get(id)?.element)))};
  });
  const found = el('p', {class: 'quiet small', role: 'status'});
  const search = el('input', {type: 'search', id: `${prefix}-search`, autocomplete: 'off', oninput: () => narrow()});
  const onlyChanged = el('input', {type: 'checkbox', id: `${prefix}-changed`, onchange: () => narrow()});
  function narrow(): void {
    const wanted = fold(search.value).split(/\s+/).filter(Boolean);
    const settings = options.settings();
    let count = 0;
    for (const {ids, element} of groups) {
      let any = false;
      for (const id of ids) {
        const field = fields.get(id);
        if (!field) continue;
        const fits = wanted.every((word) => texts.get(id)?.includes(word)) &&
          (!onlyChanged.checked || settingOf(settings, id) !== undefined);
        field.element.hidden = !fits;
        any ||= fits;
        if (fits) ++count;
      }
      element.hidden = !any;
    }
    const all = wanted.length === 0 && !onlyChanged.checked;
    replace(found, all ? null : count === 0 ? t('settings.found_none') : t('settings.found', {count}) );
  }
  return [
    el('div', {class: 'setting-search'},
      el('div', {class: 'field'}, el('label', {for: search.id}, t('settings.search')), search),
      el('label', {class: 'choice', for: onlyChanged.id}, onlyChanged, t('settings.only_changed'))),
    found, ...groups.map((group) => group.element)];
}
