// Names and values in two columns.
import {el, type Children} from '../dom';

export type Fact = readonly [name: string, value: Children] | false | null | undefined;
export const facts = (...all: Fact[]): HTMLElement =>
  el('dl', {class: 'facts'}, all.map((fact) => fact && [el('dt', null, fact[0]), el('dd', null, fact[1])]));
