// The mistakes that cost a sheet or worse: each has a guard that names it and loses nothing.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {choose, drawn, drop, makeQuick, sample, settled, show, signIn, startBrowser, startFurnished} from './drive.mjs';

let service;
let jobs;
let browser;
before(async () => {
  browser = await startBrowser();
  ({service, jobs} = await startFurnished(1));
});
after(async () => { await browser?.close(); await service?.stop(); });

// A new print with the sample, ready but for what a test leaves open.
async function prepared() {
  const page = await signIn(browser, service);
  await show(page, '#/new');
  await drop(page, sample().scan);
  await drawn(page);
  await choose(page, 'Choose a drawing', sample().pattern);
  await makeQuick(page);
  await page.getByLabel('Reference', {exact: true}).fill('GUARD-1');
  await page.getByText('Checked by the service. Everything is there.').waitFor({timeout: 60_000});
  return page;
}
const count = async () => (await service.json('/api/v1/jobs?limit=100&kind=print')).jobs.length;

// Starts, and expects to be asked with this text; goes back, and finds everything as it was.
async function askedAbout(page, text) {
  const jobsBefore = await count();
  await page.getByRole('button', {name: 'Start the job'}).click();
  const dialog = page.getByRole('dialog');
  await dialog.getByText(text).waitFor();
  await dialog.getByRole('button', {name: 'Back to the scan'}).click();
  await dialog.waitFor({state: 'detached'});
  assert.equal(await count(), jobsBefore);
  assert.equal(await page.getByLabel('Reference', {exact: true}).inputValue(), 'GUARD-1');
  assert.match(page.url(), /#\/new/);
}

test('a job whose side nobody confirmed is not started without a question', async () => {
  const page = await prepared();
  await askedAbout(page, /Nobody has confirmed which side/);
  await page.context().close();
});

test('a scan in the wrong unit is named before anything is started', async () => {
  const page = await prepared();
  await page.getByRole('radio', {name: 'cm', exact: false}).first().check();
  await page.getByText(/In this unit the scan is not as large as a head/).first().waitFor();
  await askedAbout(page, /not the size of a head/);
  await page.context().close();
});

test('a scan whose left ear is on the wrong side is called a mirror image', async () => {
  const page = await prepared();
  await page.getByRole('radio', {name: 'On the left in the picture, at +x'}).check();
  await page.getByRole('alert').filter({hasText: 'the scan is a mirror image'}).waitFor();
  await askedAbout(page, /The scan may be a mirror image/);
  await page.context().close();
});

test('a print for the inner face says so on the page, on the sheet and in the name of the file', async () => {
  const id = await service.submit({reference: 'FACE-1'}, {sheet: {resolution_mm: 6}, print: {dpi: 100}, pattern: {inked_face: 'inner'}});
  assert.equal((await service.ended(id)).state, 'succeeded');
  const page = await signIn(browser, service, {acceptDownloads: true});
  await show(page, `#/jobs/${id}`);
  await page.getByText('Print on the inner face. It touches the mold. The print is mirrored for it.').waitFor();
  const svg = await (await service.ask(`/api/v1/jobs/${id}/artifacts/print.svg`)).text();
  assert.match(svg, /inner face, MIRRORED/);
  assert.match(svg, /FACE-1/);
  const [download] = await Promise.all([page.waitForEvent('download'), page.getByRole('link', {name: 'print.pdf'}).first().click()]);
  assert.equal(download.suggestedFilename(), 'FACE-1-inner-print.pdf');
  await page.context().close();
});

test('downloads turn grey while the drawing is moved, and come back when that is undone', async () => {
  const page = await signIn(browser, service);
  await show(page, `#/jobs/${jobs.print}`);
  const grey = () => page.getByRole('link', {name: 'print.pdf', disabled: true}).count();
  await page.getByRole('link', {name: 'print.pdf'}).first().waitFor();
  assert.equal(await grey(), 0);
  await page.getByText('Adjust the drawing on the part').click();
  const turn = page.getByRole('textbox', {name: /Rotation, counter-clockwise/});
  await turn.fill('10');
  await turn.blur();
  await page.getByText(/Settings have changed since this result/).first().waitFor();
  assert.equal(await grey(), 1);
  await turn.fill('0');
  await turn.blur();
  await page.getByText(/Settings have changed since this result/).first().waitFor({state: 'hidden'});
  assert.equal(await grey(), 0);
  await page.context().close();
});

test('two tabs keep two drafts', async () => {
  const first = await signIn(browser, service);
  await show(first, '#/new');
  const second = await first.context().newPage();
  await second.goto('/#/new');
  await settled(second);
  const fill = async (page, text) => {
    await page.getByLabel('Reference', {exact: true}).fill(text);
    await page.getByLabel('Reference', {exact: true}).blur();
  };
  await fill(first, 'TAB-1');
  await fill(second, 'TAB-2');
  for (const [page, text] of [[first, 'TAB-1'], [second, 'TAB-2']]) {
    await page.reload();
    await settled(page);
    assert.equal(await page.getByLabel('Reference', {exact: true}).inputValue(), text);
  }
  await first.context().close();
});
