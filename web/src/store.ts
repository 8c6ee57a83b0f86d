// One immutable value and those who want to know when it changes.

export interface Store<S> {
  get(): S;
  // Replaces the given members. Subscribers are told once, after the change.
  set(change: Partial<S> | ((state: S) => Partial<S>)): void;
  subscribe(listener: (state: S) => void): () => void;
}

export function createStore<S extends object>(initial: S): Store<S> {
  let state = initial;
  const listeners = new Set<(state: S) => void>();
  return {
    get: () => state,
    set(change) {
      const members = typeof change === 'function' ? change(state) : change;
      if (Object.entries(members).every(([name, value]) => state[name as keyof S] === value)) return;
      state = {...state, ...members};
      for (const listener of [...listeners]) listener(state);
    },
    subscribe(listener) {
      listeners.add(listener);
      return () => listeners.delete(listener);
    },
  };
}
