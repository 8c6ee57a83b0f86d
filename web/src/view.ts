// The base of the views: custom elements in the light DOM, built once, with parts that follow the state.
import {el, replace, type Children} from './dom';
import {store, type State} from './state';

type End = () => void;
let scope: End[] | null = null;  // of the view or part that is being built

// Runs when the view or part that is being built ends.
export function onEnd(end: End): void {
  if (!scope) throw new Error('onEnd outside of a view');
  scope.push(end);
}

function runIn<T>(ends: End[], build: () => T): T {
  const outer = scope;
  scope = ends;
  try {
    return build();
  } finally {
    scope = outer;
  }
}

function finish(ends: End[]): void {
  for (const end of ends.splice(0).reverse()) end();
}

const same = (a: unknown, b: unknown): boolean =>
  Object.is(a, b) ||
  (Array.isArray(a) && Array.isArray(b) && a.length === b.length && a.every((item, i) => Object.is(item, b[i])));

// Children that are built from a piece of the state, and again whenever that piece changes. `select` gives a member of the
// state, or a list of members; they are compared by identity.
export function live<T>(select: (state: State) => T, build: (value: T) => Children): HTMLElement {
  const host = el('div', {class: 'live'});
  const ends: End[] = [];
  let value: T | undefined;
  let first = true;
  const update = (state: State): void => {
    const now = select(state);
    if (!first && same(now, value)) return;
    first = false;
    value = now;
    finish(ends);
    replace(host, runIn(ends, () => build(now)));
  };
  onEnd(() => finish(ends));
  onEnd(store.subscribe(update));
  update(store.get());
  return host;
}

// Calls at once and whenever that piece of the state changes.
export function follow<T>(select: (state: State) => T, apply: (value: T) => void): void {
  let value = select(store.get());
  apply(value);
  onEnd(store.subscribe((state) => {
    const now = select(state);
    if (same(now, value)) return;
    value = now;
    apply(now);
  }));
}

export abstract class View extends HTMLElement {
  readonly #ends: End[] = [];

  connectedCallback(): void {
    replace(this, runIn(this.#ends, () => this.build()));
  }
  disconnectedCallback(): void {
    finish(this.#ends);
  }
  protected abstract build(): Children;
}
