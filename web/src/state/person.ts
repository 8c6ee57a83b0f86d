// Whose the storage of this tab is. What a person prepared here (files' names, references, drawings) belongs to the token
// that signed in. It is removed at sign-out, at the end of the session, and before anybody else sees the page.

const ownedBy = 'vacuform.token', place = 'vacuform.place';
let over = false;  // this page has been left
export const mayKeep = (): boolean => !over;

type Keeper = Pick<Storage, 'getItem' | 'setItem' | 'clear'>;

// Empties the storage unless it is that of the token. Call before anything is read from it.
export function claim(storage: Keeper, token: string): void {
  if (storage.getItem(ownedBy) === token) return;
  storage.clear();
  storage.setItem(ownedBy, token);
}

// Empties the storage, and nothing is kept any more. `at`: the address where the same token begins again; what follows "?" (a search) is not kept.
export function wipe(storage: Keeper, token = '', at = ''): void {
  over = true;
  storage.clear();
  if (!token || !at) return;
  storage.setItem(ownedBy, token);
  storage.setItem(place, at.split('?')[0] ?? '');
}

// The address where the token stood when its session ended, or empty. After claim().
export const placeOf = (storage: Keeper): string => storage.getItem(place) ?? '';
