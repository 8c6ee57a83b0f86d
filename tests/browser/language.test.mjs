// German is complete, and no view is wider than a window of 320 pixels, even with texts that are 40 % longer.
import assert from 'node:assert/strict';
import {readdirSync, readFileSync} from 'node:fs';
import {join} from 'node:path';
import {openSettings, setUp, show, signIn, viewsOf, web} from './drive.mjs';

const test = setUp();
const german = {locale: 'de-DE'};
const narrow = {viewport: {width: 320, height: 640}};

const messages = (language) => Object.assign({}, ...readdirSync(join(web, 'lang', language)).filter((name) => name.endsWith('.json'))
  .map((name) => JSON.parse(readFileSync(join(web, 'lang', language, name), 'utf8'))));

// The visible texts of the page, and those that screen readers speak. Names, numbers and code have no language.
const texts = () => {
  const found = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const text = node.textContent.trim();
    const element = node.parentElement;
    if (text && element.checkVisibility() && !element.closest('code, kbd, time, [translate="no"], [lang]:not(html)')) found.push(text);
  }
  for (const element of document.querySelectorAll('[aria-label], [title], [alt], [placeholder]'))
    for (const name of ['aria-label', 'title', 'alt', 'placeholder'])
      if (element.getAttribute(name)) found.push(element.getAttribute(name));
  return [...new Set(found)];
};

// A message with its values as a regular expression.
const patternOf = (message) => new RegExp(`^${message.split(/\{[^}]*\}/).map((part) => part.replace(/[.*+?^${}()|[\]\\]/g, '\\$&'))
  .join('.*')}$`);

test('no English text is left in German', german, async ({page, jobs}) => {
  const [english, ours] = [messages('en'), messages('de')];
  // Texts that consist of values only, or that are the same word in both languages, say nothing.
  const germanTexts = new Set(Object.values(ours));
  const foreign = Object.entries(english).filter(([key, text]) => ours[key] !== text && !germanTexts.has(text) &&
    text.replace(/\{[^}]*\}/g, '').trim().length > 3).map(([key, text]) => [key, patternOf(text)]);
  const left = {};
  for (const [name, hash] of Object.entries(viewsOf(jobs))) {
    await show(page, hash);
    assert.equal(await page.evaluate(() => document.documentElement.lang), 'de');
    const shown = await page.evaluate(texts);
    assert.ok(shown.length > 5, name);
    const found = shown.flatMap((text) => foreign.filter(([, pattern]) => pattern.test(text)).map(([key]) => `${key}: ${text}`));
    if (found.length > 0) left[name] = found;
  }
  assert.deepEqual(left, {});
});

// `place` explains the problem in German. The sentence of the service stands next to it, marked as English; no other word of
// it is there.
async function explains(place, text, {title, what, fix}) {
  await place.getByText(text).first().waitFor();
  const [exact, rest] = await place.evaluate((element) => {
    const copy = element.cloneNode(true);
    const marked = [...copy.querySelectorAll('[lang=en]')];
    for (const one of marked) one.remove();
    return [marked.map((one) => one.textContent).join(), copy.textContent];
  });
  assert.ok(exact.includes(what), exact);
  for (const english of [title, what, fix]) assert.ok(!rest.includes(english), rest);
}

test('German pages explain why a job failed, next to the exact sentence of the service', german, async ({page, service, jobs}) => {
  const {problem} = await service.json(`/api/v1/jobs/${jobs.failed}`);
  assert.match(problem.type, /does-not-fit$/);
  await show(page, `#/jobs/${jobs.failed}`);
  const box = page.getByRole('alert');
  await explains(box, 'Die Form passt nicht zur Folie oder zur Maschine', problem);
  await box.getByText(/^Genaue Meldung \(Englisch\): /).waitFor();
  await box.getByText(`Wo: ${problem.where}`).waitFor();
  await show(page, '#/jobs?state=failed');
  await explains(page.getByRole('listitem').filter({hasText: 'CASE-8'}), 'Die Form passt nicht zur Folie oder zur Maschine', problem);
});

// What the service answers to a request that it refuses.
async function refusal(page, path, act) {
  const [answer] = await Promise.all([page.waitForResponse((one) => one.url().endsWith(path) && !one.ok()), act()]);
  return answer.json();
}

test('German pages explain a refused setting', german, async ({page, jobs}) => {
  await show(page, `#/new?from=${jobs.print}`);
  await openSettings(page, 'Alle Einstellungen');
  const width = page.getByRole('textbox', {name: 'Breite der Folie', exact: true}).last();
  const problem = await refusal(page, '/api/v1/validate', async () => {
    await width.fill('100');
    await width.blur();
  });
  assert.match(problem.type, /bad-settings$/);
  await page.getByRole('button', {name: 'Auftrag starten'}).click();
  await explains(page.getByRole('alert').filter({hasText: 'Es gibt ein Problem'}), 'Eine Einstellung stimmt nicht', problem);
});

test('German pages explain a refused submission', german, async ({browser, service}) => {
  const page = await signIn(browser, service, german, {token: await service.makeToken('reader', ['read'])});
  await show(page, '#/help');
  const problem = await refusal(page, '/api/v1/jobs', () => page.getByRole('button', {name: 'Beispielauftrag erstellen'}).click());
  assert.match(problem.type, /forbidden$/);
  await explains(page.getByRole('alert'), 'Ihr Token erlaubt das nicht', problem);
  await page.context().close();
});

test('numbers in German have a comma', german, async ({page, jobs}) => {
  await show(page, `#/jobs/${jobs.print}`);
  const shown = (await page.evaluate(texts)).join('\n');
  assert.match(shown, /\d,\d/);
});

const accents = {a: 'á', e: 'é', i: 'í', o: 'ó', u: 'ú', A: 'Á', E: 'É', O: 'Ó', U: 'Ú', n: 'ñ', c: 'ç'};
// [Ñéw príñt ~~~]: accents, 40 % longer, in brackets; values stay as they are.
function pseudo(text) {
  const accented = text.split(/(\{[^}]*\})/).map((part) => part.startsWith('{') ? part
    : part.replace(/[aeiouAEOUnc]/g, (letter) => accents[letter] ?? letter)).join('');
  const words = 'lorem ipsum dolor sit amet '.repeat(Math.ceil(text.length * 0.4 / 27)).slice(0, Math.ceil(text.length * 0.4)).trim();
  return `⟦${accented} ${words}⟧`;
}

// Replaces the English messages on their way to the page, wherever the built files hold them.
async function withPseudoTexts(context) {
  const english = new Set(Object.values(messages('en')));
  const literal = /"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*'|`(?:[^`\\$]|\\.)*`/g;
  await context.route('**/app/*.js', async (route) => {
    const answer = await route.fetch();
    const body = await answer.text();
    let count = 0;
    const changed = body.replace(literal, (whole) => {
      const text = Function(`return ${whole}`)();
      if (!english.has(text)) return whole;
      ++count;
      return JSON.stringify(pseudo(text));
    });
    await route.fulfill({response: answer, body: count > 100 ? changed : body});  // other files have the same words as names
  });
}

test('no view scrolls sideways at 320 pixels with texts that are 40 % longer, and every text comes from the messages', narrow,
  async ({page, jobs}) => {
  await withPseudoTexts(page.context());
  // What the service itself says: problems, warnings, names of files, jobs and coils.
  const served = [];
  page.on('response', (answer) => {
    if (/\/(api|problems)\//.test(answer.url()) && /json/.test(answer.headers()['content-type'] ?? '')) served.push(answer.text().catch(() => ''));
  });
  const wide = {};
  const bare = {};
  for (const [name, hash] of Object.entries(viewsOf(jobs))) {
    await show(page, hash);
    const shown = await page.evaluate(texts);
    assert.ok(shown.some((text) => text.startsWith('⟦')), name);
    const beyond = await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth ? [] :
      [...document.querySelectorAll('body *')].filter((element) => element.checkVisibility() &&
        element.getBoundingClientRect().right > innerWidth + 1 && !element.closest('.wide, nav ul'))
        .map((element) => element.outerHTML.slice(0, 100)).slice(0, 5));
    if (beyond.length > 0) wide[name] = beyond;
    const said = (await Promise.all(served)).flatMap(strings).join('\n').toLowerCase();
    const words = shown.filter((text) => /[a-z]{3}/i.test(text) && !/[⟦⟧]/.test(text) && !known.test(text) &&
      !said.includes(text.toLowerCase()));
    if (words.length > 0) bare[name] = words;
  }
  assert.deepEqual(wide, {});
  assert.deepEqual(bare, {});
});

// All strings of a JSON text, the names of members included.
function strings(text) {
  const found = [];
  try {
    JSON.parse(text, (key, value) => {
      found.push(key);
      if (typeof value === 'string') found.push(value);
      return value;
    });
  } catch {
    // an answer that was cut off when the page went on
  }
  return found;
}

// Times, durations, names that are the same in every language, and what people and the service have named.
const known = /^(?:· )?(\d+ \w{3,4} \d{4}, .*|(\d+ h )?\d+ min|CASE-\d|admin|local-workers|station-3|English|Deutsch|API|[\w.-]+\.(png|pdf|svg|ply|obj|mtl|stl|json|html|glb|zip))$/;
