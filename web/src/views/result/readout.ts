// What is known of one place of the formed sheet.
import {el} from '../../dom';
import {encloses, type HeatMap, type Line} from '../../state/result';
import type {Spot} from '../../scene/sheet';
import {number, t, textIfKnown, withUnit} from '../../text';

export const coilsAt = (spot: Pick<Spot, 'sheet'>, lines: ReadonlyMap<string, Line[]>): string[] =>
  [...lines].filter(([, all]) => encloses(all, spot.sheet)).map(([id]) => id);

const pair = (place: readonly [number, number]): string => t('result.pair', {a: number(place[0], 1), b: number(place[1], 1)});

export const titleOfMap = (map: HeatMap): string => textIfKnown(`artifact.preview-${map.id}.png`) ?? map.title;
// With the digits that the range asks for.
export const valueOf = ({unit, low, high}: HeatMap, value: number): string => {
  const digits = high - low > 20 ? 0 : 2;
  return unit ? withUnit(value, unit, digits) : number(value, digits);
};

export function readings(spot: Spot, maps: readonly HeatMap[], lines: ReadonlyMap<string, Line[]>): [string, string][] {
  const coils = coilsAt(spot, lines), kinds = ['free', 'mold', 'platform', 'clamp'] as const;
  return [
    [t('result.read_coil'), coils.join(', ') || t('result.no_coil')],
    ...maps.map((map): [string, string] => {
      const value = spot.values.get(map.id) ?? null;
      return [titleOfMap(map), value === null ? '–' : valueOf(map, value)];
    }),
    [t('result.map_contact'), t(`result.contact_${kinds[spot.contact] ?? 'free'}`)],
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
