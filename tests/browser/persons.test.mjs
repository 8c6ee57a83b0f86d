// Two people at one browser: what one prepared never reaches the other, whichever way the first one leaves.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {choose, dropText, openPage, referenceField, sample, settled, show, signIn, startBrowser, startService, until} from './drive.mjs';
import {head} from './heads.mjs';

let service, browser, tokens;
before(async () => {
  browser = await startBrowser();
  service = await startService({workers: 0});
  tokens = {a: await service.makeToken('ward-a', ['submit', 'read']), b: await service.makeToken('ward-b', ['submit', 'read'])};
});
after(async () => { await browser?.close(); await service?.stop(); });

const secret = /CASE-2000|meier|secret-coils|left ear sore/i;
const stored = (page) => page.evaluate(() => JSON.stringify({...sessionStorage, local: {...localStorage}}));
const everything = async (page) => await stored(page) + await page.content() +
  (await page.locator('input, textarea').evaluateAll((fields) => fields.map((field) => field.value).join(' ')));

// Ward A prepares a print, with everything that names the patient.
async function prepare(page) {
  await show(page, '#/new');
  await dropText(page, head(), 'meier.obj');
  await page.getByText(/meier\.obj .* is on the server/).waitFor();
  await choose(page, 'Choose a drawing', {name: 'secret-coils.svg', mimeType: 'image/svg+xml', buffer: Buffer.from(
    '<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="80mm" viewBox="0 0 90 80"><circle cx="40" cy="40" r="30" fill="none" stroke="#000"/></svg>')});
  await page.getByText('secret-coils.svg').first().waitFor();
  await referenceField(page).fill('CASE-2000');
  await page.getByLabel('Note', {exact: true}).fill('left ear sore');
  await page.getByLabel('Note', {exact: true}).blur();
  assert.match(await stored(page), /CASE-2000/);
}
async function signInAs(page, token) {
  await page.getByLabel('Token').fill(token);
  await page.getByRole('button', {name: 'Sign in'}).click();
  await page.waitForURL((url) => url.pathname !== '/sign-in');
}
async function nothingLeft(page) {
  await show(page, '#/new');
  assert.doesNotMatch(await everything(page), secret);
  assert.equal(await referenceField(page).inputValue(), '');
}
// The session ends, and only requests to this path learn of it: another one might end the page too soon.
async function endSession(page, path) {
  await page.route(({pathname}) => pathname.startsWith('/api/') && !pathname.startsWith(path), () => {});
  await page.context().clearCookies();
}
const open = async (token, options) => signIn(browser, service, options, {token});

test('after a sign-out the next person of the tab finds nothing, also with the button Back', async () => {
  const page = await open(tokens.a);
  await prepare(page);
  await page.locator('header details.menu summary').click();
  await page.getByRole('button', {name: 'Sign out'}).click();
  await page.waitForURL(/sign-in/);
  assert.doesNotMatch(await everything(page), secret);
  await page.goBack().catch(() => {});
  await until(async () => !secret.test(await everything(page).catch(() => 'CASE-2000')), 'the page to be empty');
  await page.goto('/sign-in');
  await signInAs(page, tokens.b);
  await nothingLeft(page);
  await page.context().close();
});

test('the end of a session removes the draft, and the same person begins where it was', async () => {
  const page = await open(tokens.a);
  await prepare(page);
  await endSession(page, '/api/v1/session');
  await page.evaluate(() => document.dispatchEvent(new Event('visibilitychange')));  // back at the tab
  await page.waitForURL(/sign-in/);
  await page.unrouteAll();
  assert.doesNotMatch(await everything(page), secret);
  await signInAs(page, tokens.a);
  await page.waitForURL(/#\/new/);
  await nothingLeft(page);
  await page.context().close();
});

test('what an upload is refused for ends the page too', async () => {
  const page = await open(tokens.a);
  await prepare(page);
  await endSession(page, '/api/v1/uploads');
  await dropText(page, head({scale: 1.01}), 'other.obj');
  await page.waitForURL(/sign-in/);
  assert.doesNotMatch(await everything(page), secret);
  await page.context().close();
});

test('another tab is left with the first one', async () => {
  const page = await open(tokens.a);
  await prepare(page);
  const second = await page.context().newPage();
  await second.goto('/#/jobs');
  await settled(second);
  await second.locator('header details.menu summary').click();
  await second.getByRole('button', {name: 'Sign out'}).click();
  await page.waitForURL(/sign-in/);
  assert.doesNotMatch(await everything(page), secret);
  await page.context().close();
});

test('a person who signs in over another one finds nothing, in no tab', async () => {
  const page = await open(tokens.a);
  await prepare(page);
  const second = await page.context().newPage();
  await second.goto('/sign-in');
  await signInAs(second, tokens.b);
  await settled(second);
  await page.waitForURL((url) => url.hash === '');
  await settled(page);
  assert.doesNotMatch(await everything(page), secret);
  await nothingLeft(page);
  await page.context().close();
});

test('a link signs a person in once, also over another one', async () => {
  const page = await open(tokens.a);
  await prepare(page);
  const administrator = await open(service.token);
  await show(administrator, '#/admin/tokens');
  const link = async () => {
    await administrator.getByRole('button', {name: `Sign-in link for the token ${tokens.b.split('_')[1]} of ward-b`}).click();
    const dialog = administrator.getByRole('dialog', {name: 'A sign-in link for ward-b'});
    const made = await dialog.getByLabel('Sign-in link').inputValue();
    await dialog.getByRole('button', {name: 'Close'}).click();
    return made;
  };
  const first = await link();
  await page.goto(first);
  await settled(page);
  assert.equal(new URL(page.url()).pathname, '/');  // the code is in no address that stays
  await nothingLeft(page);
  await page.locator('header details.menu summary').click();
  await page.getByText('Signed in as ward-b').waitFor();
  await page.goto(first);  // opened again
  await settled(page);
  assert.equal(new URL(page.url()).pathname, '/');
  await page.context().close();
  const stranger = await openPage(browser, service);
  await stranger.goto(first);
  await stranger.getByRole('alert').getByText('the link is wrong, was used, or has expired').waitFor();
  await stranger.getByLabel('Token', {exact: true}).waitFor();
  // on a page of another site, such as a terminal in a browser
  await stranger.goto(`data:text/html,<a href="${await link()}">open</a>`);
  await stranger.getByText('open').click();
  await stranger.getByText('It works once.').waitFor();
  await stranger.getByRole('button', {name: 'Sign in'}).press('Enter');
  await stranger.waitForURL((url) => url.pathname === '/');
  await settled(stranger);
  await stranger.context().close();
  await administrator.context().close();
});

test('a tab that was restored belongs to who signed in then', async () => {
  const page = await open(tokens.a);
  await prepare(page);
  const kept = await page.evaluate(() => ({...sessionStorage}));
  await page.context().close();
  // as a browser restores a tab: the storage of the tab is there, and another person is signed in
  const next = await openPage(browser, service);
  await next.addInitScript((items) => {
    if (window.restored || sessionStorage.length > 0) return;
    for (const [name, value] of Object.entries(items)) sessionStorage.setItem(name, value);
  }, kept);
  await next.goto('/sign-in');
  assert.match(await stored(next), secret);
  await signInAs(next, tokens.b);
  await settled(next);
  await until(async () => !secret.test(await everything(next)), 'the storage of the other person to be empty');
  await nothingLeft(next);
  await next.context().close();
});
