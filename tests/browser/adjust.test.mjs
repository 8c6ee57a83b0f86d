// Pairs of points: what is picked on the part is what the server gets, and the print goes where the pairs say.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {after, before, test} from 'node:test';
import {drawn, quick, sample, show, signIn, startBrowser, startService} from './drive.mjs';

// Coils so far apart that with pairs no neighbour moves them: each lies where the chart has it.
const centres = {a: [-40, 0], b: [40, 0], c: [0, 40]};  // u, v
const drawing = `<svg xmlns="http://www.w3.org/2000/svg" width="120mm" height="120mm" viewBox="-60 -60 120 120">${
  Object.entries(centres).map(([id, [u, v]]) => `<g id="${id}"><circle cx="${u}" cy="${-v}" r="6" fill="none" stroke="#000" stroke-width="2"/></g>`).join('')}
  <path d="M-59 0A59 59 0 0 1 0 -59" fill="none" stroke="#000" stroke-width="0.1"/></svg>`;

let service;
let browser;
let first;
before(async () => {
  browser = await startBrowser();
  service = await startService();
  const form = new FormData();
  form.append('scan', new Blob([readFileSync(sample().scan)]), 'head.stl');
  form.append('pattern', new Blob([drawing]), 'pattern.svg');
  form.append('settings', JSON.stringify({...quick, pattern: {offset_mm: [4, -6], rotate_deg: 15}}));
  first = (await service.json('/api/v1/jobs', {method: 'POST', body: form})).id;
  assert.equal((await service.ended(first)).state, 'succeeded');
});
after(async () => { await browser?.close(); await service?.stop(); });

const coilsOf = async (id) => {
  const report = await service.json(`/api/v1/jobs/${id}/artifacts/report.json`);
  return Object.fromEntries(report.coils.map(({id: name, with: made}) => [name, made.centre_mm]));
};
const apart = (a, b) => Math.hypot(...a.map((value, k) => value - b[k]));

// Looks straight at a place, which then is the centre of the view.
async function lookAt(page, id, [x, y, z]) {
  const azimuth = Math.atan2(-x, y) * 180 / Math.PI, elevation = Math.atan2(z - 40, Math.hypot(x, y)) * 180 / Math.PI;
  await page.evaluate((hash) => { location.hash = hash; }, `#/jobs/${id}?view=${[azimuth, elevation, 3, x, y, z].join('_')}`);
  await drawn(page);
}
async function open(id) {
  const page = await signIn(browser, service);
  await show(page, `#/jobs/${id}`);
  await drawn(page);
  await page.getByText('Adjust the drawing on the part').click();
  return page;
}
const items = (page) => page.locator('.pairs > li');
async function addPair(page, id, from, to, pick = () => page.keyboard.press('m')) {
  await page.getByRole('button', {name: 'Add a pair'}).click();
  await page.getByText(/^Click a point of the drawing/).waitFor();
  await lookAt(page, id, from);
  await pick();
  await page.getByText(/^Now click the place/).waitFor();
  await lookAt(page, id, to);
  await pick();
}
async function apply(page, from = first) {
  await page.getByRole('button', {name: 'Apply: make the new print'}).click();
  await page.waitForURL((url) => /#\/jobs\/[^/?]+/.test(url.hash) && !url.hash.includes(from));
  const id = /#\/jobs\/([^/?]+)/.exec(page.url())[1];
  const job = await service.ended(id);
  assert.equal(job.state, 'succeeded', JSON.stringify(job.problem));
  return job;
}

let placed;  // the job that two pairs placed
test('the print goes where the pairs say', async () => {
  const coils = await coilsOf(first), page = await open(first);
  // a goes to the place of b, and c to the place of a: the drawing is turned by about half
  await addPair(page, first, coils.a, coils.b);
  await page.getByText('Preview of the moved drawing').waitFor();
  assert.equal(await items(page).count(), 1);
  await page.getByText('The pairs below place the drawing.').waitFor();
  assert.equal(await page.getByRole('textbox', {name: 'Offset to +x'}).inputValue(), '0');
  assert.equal(await page.getByRole('textbox', {name: /^Rotation/}).inputValue(), '15');

  const one = await apply(page), [row] = one.settings.pattern.points;
  assert.ok(apart(row.slice(0, 2), centres.a) < 1, `${row} is not the centre of a, ${centres.a}`);
  assert.ok(apart(row.slice(2), coils.b) < 1.5, `${row} is not the place of b, ${coils.b}`);
  const moved = await coilsOf(one.id);
  assert.ok(apart(moved.a, row.slice(2)) < 1, `a is at ${moved.a}, not at ${row.slice(2)}`);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('two pairs turn the drawing, and undo, redo and reset know them', async () => {
  const coils = await coilsOf(first), page = await open(first);
  await addPair(page, first, coils.a, coils.b);
  await items(page).first().waitFor();
  // The preview now has a at the place of b. The point of the drawing at the place of c goes to the place of a.
  await addPair(page, first, coils.c, coils.a);
  await items(page).nth(1).waitFor();
  assert.equal(await page.getByRole('textbox', {name: /^Rotation/}).inputValue(), '0');
  await items(page).first().getByText(/\(0(\.0)? mm off\)/).waitFor();
  const count = (number) => page.waitForFunction((n) => document.querySelectorAll('.pairs > li').length === n, number);
  await page.getByRole('button', {name: 'Undo'}).click();
  await count(1);
  await page.getByRole('button', {name: 'Reset'}).click();
  await count(0);
  assert.equal(await page.getByRole('textbox', {name: 'Offset to +x'}).inputValue(), '4');
  await page.getByRole('button', {name: 'Undo'}).click();
  await page.getByRole('button', {name: 'Undo'}).click();
  await count(0);
  await page.getByRole('button', {name: 'Redo'}).click();
  await count(1);
  await addPair(page, first, coils.c, coils.a);
  await count(2);

  placed = await apply(page);
  const [one, two] = placed.settings.pattern.points, moved = await coilsOf(placed.id);
  assert.ok(apart(moved.a, one.slice(2)) < 1, `a is at ${moved.a}, not at ${one.slice(2)}`);
  // from above, the drawing is turned as the way from the first to the second point is
  const angle = ([x, y], [toX, toY]) => Math.atan2(toY - y, toX - x) * 180 / Math.PI;
  const turn = angle(one.slice(2), two.slice(2)) - angle(one, two), expected = angle(centres.a, centres.c) + turn;
  const off = (angle(moved.a, moved.c) - expected + 1260) % 360 - 180;
  assert.ok(Math.abs(off) < 6, `${off} degrees off`);
  await page.context().close();
});

test('a job that points have placed shows them, and lets them be changed', async () => {
  const page = await open(placed.id), coils = await coilsOf(placed.id);
  assert.equal(await items(page).count(), 2);
  await page.locator('.pair-badges span').first().waitFor();
  assert.ok(await page.getByRole('button', {name: 'Apply: make the new print'}).isDisabled());
  await items(page).nth(1).getByRole('button', {name: 'Remove'}).click();
  assert.equal(await items(page).count(), 1);
  await page.getByText('Preview of the moved drawing').waitFor();
  // Off the head there is nothing to pick.
  await page.getByRole('button', {name: 'Add a pair'}).click();
  await lookAt(page, placed.id, [140, 0, 0]);
  await page.keyboard.press('m');
  await page.getByText('The drawing does not reach this place.').waitFor();
  await page.keyboard.press('Escape');
  await page.getByText('The drawing does not reach this place.').waitFor({state: 'detached'});
  // The drawing lies as before, so b stays where it is.
  await addPair(page, placed.id, coils.b, coils.b, () => page.locator('canvas').first().click());
  await items(page).nth(1).waitFor();
  const job = await apply(page, placed.id), [kept, added] = job.settings.pattern.points;
  assert.deepEqual(kept, placed.settings.pattern.points[0]);
  assert.ok(apart(added.slice(0, 2), centres.b) < 1, `${added} is not the centre of b`);
  const moved = await coilsOf(job.id);
  for (const name of ['a', 'b', 'c']) assert.ok(apart(moved[name], coils[name]) < 1, `${name} is at ${moved[name]}, not at ${coils[name]}`);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
