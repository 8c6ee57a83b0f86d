// What is known of one place of the formed sheet.
import {el} from '../../dom';
import {encloses, type Line} from '../../state/result';
import type {Spot} from '../../scene/sheet';
import {number, t, withUnit} from '../../text';

export const coilsAt = (spot: Pick<Spot, 'sheet'>, lines: ReadonlyMap<string, Line[]>): string[] =>
  [...lines].filter(([, all]) => encloses(all, spot.sheet)).map(([id]) => id);

const pair = (place: readonly [number, number]): string => t('result.pair', {a: number(place[0], 1), b: number(place[1], 1)});

export function readings(spot: Spot, lines: ReadonlyMap<string, Line[]>): [string, string][] {
  const coils = coilsAt(spot, lines), kinds = ['free', 'mold', 'platform', 'clamp'] as const;
  return [
    [t('result.read_coil'), coils.join(', ') || t('result.no_coil')],
    [t('result.map_thickness'), withUnit(spot.thickness, 'mm', 2)],
    [t('result.map_shape'), spot.shape === null ? t('result.off_chart') : number(spot.shape, 2)],
    [t('result.map_area'), spot.area === null ? t('result.off_chart') : number(spot.area, 2)],
    [t('result.map_temperature'), withUnit(spot.temperature, '°C', 0)],
    [t('result.map_contact'), t(`result.contact_${kinds[spot.contact] ?? 'free'}`)],
    [t('result.map_air'), spot.gap === null ? '–' : withUnit(spot.gap, 'mm', 1)],
    ...(spot.position === null ? [] : [[t('result.map_position'), withUnit(spot.position, 'mm', 2)],
                                       [t('result.map_colour'), number(spot.colour ?? 0, 1)]] satisfies [string, string][]),
    [t('result.read_sheet'), pair(spot.sheet)],
    [t('result.read_pattern'), spot.pattern ? pair(spot.pattern) : t('result.off_chart')],
  ];
}

export function readout(): {element: HTMLElement; show(rows: [string, string][]): void} {
  const element = el('dl', {class: 'readout'});
  const hint = el('p', {class: 'small quiet'}, t('result.read_hint'));
  return {
    element: el('section', {class: 'card'}, el('h3', null, t('result.readout')), hint, element),
    show(rows) {
      hint.hidden = true;
      element.replaceChildren(...rows.map(([name, value]) => el('div', null, el('dt', null, name), el('dd', null, value))));
    },
  };
}
