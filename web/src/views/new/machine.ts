// Section 3: the machine and its sheet. Profiles first, then the settings that matter most, then all of them.
import {el, svg, type Children} from '../../dom';
import type {Profile, Settings, SettingsSchema} from '../../api/types';
import {dropZone} from '../../parts/drop-zone';
import {icon} from '../../parts/icon';
import type {SettingsForm} from '../../parts/settings-form';
import {iccSpace} from '../../read/icc';
import {follows, valueOf, withProfile} from '../../state/draft';
import {bytes, t} from '../../text';
import {follow, live, onEnd} from '../../view';
import {sizeText} from './pattern';
import {draftFields} from './fields';
import {transferLine} from './transfer';
import {draft, edit, removeIcc, takeIcc} from './work';

const basic = [
  'sheet.width_mm', 'sheet.height_mm', 'sheet.thickness_mm', 'sheet.material', 'machine.window', 'machine.window_width_mm',
  'machine.window_height_mm', 'machine.drape_height_mm', 'sheet.resolution_mm', 'print.dpi'];

interface Frame {
  sheet: [number, number];
  window: [number, number];
  round: boolean;
}
export function frameOf(schema: SettingsSchema, settings: Settings): Frame {
  const at = (id: string): number => Number(valueOf(schema, settings, id));
  const round = valueOf(schema, settings, 'machine.window') === 'circle';
  const width = at('machine.window_width_mm');
  return {sheet: [at('sheet.width_mm'), at('sheet.height_mm')], window: [width, round ? width : at('machine.window_height_mm')], round};
}
export const frameText = ({sheet, window, round}: Frame): string => round
  ? t('new.frame_round', {sheet: sizeText(sheet), diameter: sizeText([window[0], NaN])})
  : t('new.frame', {sheet: sizeText(sheet), window: sizeText(window)});

// Sheet and window in proportion, with a head of an adult (152 x 195 mm) for scale. `largest`: mm of the widest sheet.
function drawing({sheet, window, round}: Frame, largest: number): SVGElement {
  const [w, h] = sheet, [a, b] = window;
  const half = largest / 2;
  return svg('svg', {class: 'profile-frame', viewBox: `${-half} ${-half} ${largest} ${largest}`, 'aria-hidden': 'true', focusable: 'false'},
    svg('rect', {class: 'sheet', x: -w / 2, y: -h / 2, width: w, height: h, rx: largest / 80}),
    round ? svg('circle', {class: 'window', cx: 0, cy: 0, r: a / 2})
          : svg('rect', {class: 'window', x: -a / 2, y: -b / 2, width: a, height: b}),
    svg('ellipse', {class: 'head', cx: 0, cy: 0, rx: 76, ry: 97.5}));
}

function cards(schema: SettingsSchema, profiles: readonly Profile[]): Children {
  const settingsOf = (name: string): Settings => profiles.find((profile) => profile.name === name)?.settings ?? {};
  const frames = profiles.map((profile) => ({name: profile.name, frame: frameOf(schema, profile.settings)}));
  const own = frameOf(schema, {});
  const largest = Math.max(260, ...[own, ...frames.map(({frame}) => frame)].flatMap(({sheet}) => sheet)) * 1.04;
  const inputs: HTMLInputElement[] = [];
  const card = (name: string, title: string, frame: Frame): HTMLElement => {
    const input = el('input', {type: 'radio', name: 'profile', value: name, onchange: () => {
      const {form} = draft();
      edit({profile: name, settings: withProfile(form.settings, settingsOf(form.profile), settingsOf(name), schema)});
    }});
    inputs.push(input);
    return el('label', {class: 'profile'}, drawing(frame, largest),
      el('span', {class: 'choice'}, input, el('span', null, title)), el('span', {class: 'quiet small'}, frameText(frame)));
  };
  const list = [card('', t('new.no_profile'), own), ...frames.map(({name, frame}) => card(name, name, frame))];
  const other = el('p', {class: 'notice plain', role: 'status'});
  follow((state) => state.draft.form, ({profile, settings}) => {
    for (const input of inputs) input.checked = input.value === profile;
    other.hidden = profile === '' || follows(settings, settingsOf(profile), schema);
    other.replaceChildren(icon('info'), t('new.profile_changed', {name: profile}));
  });
  return el('fieldset', null, el('legend', null, t('new.profile')), el('p', {class: 'hint'}, t('new.profile_hint')),
    el('div', {class: 'profiles'}, list), other);
}

// The colours of the printer.
function iccPart(): Children {
  const refused = el('div', {role: 'alert'});
  const refuse = (why: string): void => refused.replaceChildren(el('p', {class: 'fault'}, why));
  const take = async (file: File): Promise<void> => {
    const space = iccSpace(await file.slice(0, 128).arrayBuffer()), {name} = file;
    if (space !== 'RGB') return refuse(space ? t('new.icc_space', {name, space}) : t('new.wrong_icc', {name}));
    refused.replaceChildren();
    await takeIcc(file);
  };
  const zone = dropZone({
    id: 'icc-choose', label: t('new.choose_icc'), hint: t('new.icc_hint'), accept: ['.icc', '.icm'], everywhere: true,
    take: (file) => void take(file), refused: (name) => refuse(t('new.wrong_icc', {name}))});
  onEnd(zone.end);
  return [
    el('h3', null, t('new.icc')), zone.element, refused, transferLine('icc'),
    live(({draft: {form, from}}) => [form.icc, from] as const, ([icc, from]): Children =>
      icc ? el('p', {class: 'row'}, el('strong', {class: 'file-name'}, icc.name), el('span', {class: 'quiet'}, bytes(icc.bytes)),
              el('button', {type: 'button', id: 'icc-remove', class: 'plain', onclick: removeIcc}, icon('delete'), t('new.remove_icc')))
      : from?.icc && el('p', {class: 'notice good'}, icon('check'), t('new.icc_of_job', {bytes: bytes(from.icc.bytes)})))];
}

// `made` receives what opens all settings and returns their form.
export function machineSection(schema: SettingsSchema, made: (open: () => SettingsForm) => void): Children {
  let all: SettingsForm | null = null;
  const rest = el('details', {class: 'all-settings', ontoggle: () => { if (rest.open) open(); }},
    el('summary', null, t('new.all_settings')), el('p', {class: 'hint'}, t('new.all_settings_hint')));
  const open = (): SettingsForm => {
    if (!all) {
      all = draftFields(schema, 'all');
      rest.append(all.element);
    }
    rest.open = true;
    return all;
  };
  made(open);
  return [
    live((state) => state.draft.profiles, (profiles) => profiles && cards(schema, profiles)),
    el('h3', null, t('new.main_settings')), draftFields(schema, 'machine', basic).element, iccPart(), rest];
}
