// Whose the storage of a tab is: what one person prepared never reaches the next.
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {claim, mayKeep, placeOf, wipe} from '../src/state/person';

class Tab {
  readonly items = new Map<string, string>();
  getItem(key: string): string | null { return this.items.get(key) ?? null; }
  setItem(key: string, value: string): void { this.items.set(key, value); }
  clear(): void { this.items.clear(); }
}
const leftBehind = (): Tab => {
  const tab = new Tab();
  claim(tab, 'token-a');
  for (const key of ['vacuform.draft', 'vacuform.draft.before', 'vacuform.pattern.7-ab', 'vacuform.scan']) tab.setItem(key, 'CASE-2000 head.stl');
  return tab;
};

test('the same token finds its draft, another one finds nothing', () => {
  const tab = leftBehind();
  claim(tab, 'token-a');
  assert.equal(tab.items.size, 5);
  claim(tab, 'token-b');
  assert.deepEqual([...tab.items], [['vacuform.token', 'token-b']]);
  claim(tab, 'token-a');
  assert.deepEqual([...tab.items], [['vacuform.token', 'token-a']]);
});

test('a storage of nobody is emptied before anybody reads it', () => {
  const tab = new Tab();
  tab.setItem('vacuform.draft', 'CASE-2000');
  claim(tab, 'token-a');
  assert.equal(tab.getItem('vacuform.draft'), null);
});

test('the end of a session leaves the place without its search, for the same token alone', () => {
  assert.equal(mayKeep(), true);
  const tab = leftBehind();
  wipe(tab, 'token-a', '#/jobs?text=CASE-2000');
  assert.equal(mayKeep(), false);
  assert.deepEqual([...tab.items.values()].sort(), ['#/jobs', 'token-a']);
  claim(tab, 'token-a');
  assert.equal(placeOf(tab), '#/jobs');
  wipe(tab, 'token-a', '#/jobs/01abc');
  claim(tab, 'token-b');
  assert.equal(placeOf(tab), '');
});

test('signing out leaves nothing', () => {
  const tab = leftBehind();
  wipe(tab);
  assert.equal(tab.items.size, 0);
});
