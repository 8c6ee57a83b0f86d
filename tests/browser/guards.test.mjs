// The mistakes that cost a sheet or worse: each has a guard that names it and loses nothing.
import assert from 'node:assert/strict';
import {checked, download, drawn, giveSample, quick, referenceField, settled, setUp, show, startFurnished} from './drive.mjs';

const test = setUp(() => startFurnished(1));

// A new print with the sample, ready but for what a test leaves open.
async function prepare(page) {
  await show(page, '#/new');
  await giveSample(page);
  await referenceField(page).fill('GUARD-1');
  await checked(page);
}
const count = async (service) => (await service.json('/api/v1/jobs?limit=100&kind=print')).jobs.length;

// Starts, and expects to be asked with this text; goes back, and finds everything as it was.
async function askedAbout({page, service}, text) {
  const jobsBefore = await count(service);
  await page.getByRole('button', {name: 'Start the job'}).click();
  const dialog = page.getByRole('dialog');
  await dialog.getByText(text).waitFor();
  await dialog.getByRole('button', {name: 'Back to the scan'}).click();
  await dialog.waitFor({state: 'detached'});
  assert.equal(await count(service), jobsBefore);
  assert.equal(await referenceField(page).inputValue(), 'GUARD-1');
  assert.match(page.url(), /#\/new/);
}

test('a job whose side nobody confirmed is not started without a question', async ({page, service}) => {
  await prepare(page);
  await askedAbout({page, service}, /Nobody has confirmed which side/);
});

test('a scan in the wrong unit is named before anything is started', async ({page, service}) => {
  await prepare(page);
  await page.getByRole('radio', {name: 'cm', exact: false}).first().check();
  await page.getByText(/In this unit the scan is not as large as a head/).first().waitFor();
  await askedAbout({page, service}, /not the size of a head/);
});

test('a scan whose left ear is on the wrong side is called a mirror image', async ({page, service}) => {
  await prepare(page);
  await page.getByRole('radio', {name: 'On the left in the picture, at +x'}).check();
  await page.getByRole('alert').filter({hasText: 'the scan is a mirror image'}).waitFor();
  await askedAbout({page, service}, /The scan may be a mirror image/);
});

test('a scan that does not fit is explained before anything is started', async ({page, jobs}) => {
  await show(page, `#/new?from=${jobs.failed}`);
  await page.getByRole('button', {name: 'Examine the scan'}).click();
  await page.getByRole('alert').getByText('Code: does-not-fit').waitFor({timeout: 60_000});
  assert.deepEqual(page.faults, []);
});

test('a print for the inner face says so on the page, on the sheet and in the name of the file', async ({page, service}) => {
  const {id} = await service.print({reference: 'FACE-1'}, {...quick, pattern: {inked_face: 'inner'}});
  await show(page, `#/jobs/${id}`);
  await page.getByText('Print on the inner face. It touches the mold. The print is mirrored for it.').waitFor();
  const svg = await (await service.ask(`/api/v1/jobs/${id}/artifacts/print.svg`)).text();
  assert.match(svg, /inner face, MIRRORED/);
  assert.match(svg, /FACE-1/);
  assert.equal((await download(page)).suggestedFilename(), 'FACE-1-inner-print.pdf');
});

test('a mirrored print knows its coils where they lie', async ({page, service}) => {
  const {id} = await service.print({reference: 'FACE-2'}, {...quick, pattern: {inked_face: 'inner'}});
  await show(page, `#/jobs/${id}?mode=with`);
  await drawn(page);
  for (const coil of ['coil-4', 'coil-12', 'coil-19']) {
    await page.locator(`#row-${coil}`).click();  // turns the view to its middle
    await settled(page);
    await page.locator('.result-view canvas').first().press('i');
    assert.match(await page.locator('.readout div').filter({hasText: 'Coil'}).first().innerText(), new RegExp(`\\b${coil}(?!\\d)`), coil);
  }
});

test('a print in steps does not say that all of it is for one face', async ({page, service}) => {
  const {id} = await service.print({reference: 'STEPS-1'}, {...quick, coils: {decouple: true, build: 'two_faces', gaps: 4}});
  await show(page, `#/jobs/${id}`);
  await page.getByText('print.pdf has 6 pages, one for each step of printing').waitFor();
  assert.equal(await page.getByText('The print is not mirrored').count(), 0);
});

test('a print with a serious warning is not called the one to print, and the same coils are compared', async ({page, service}) => {
  const {id, serious_warnings: serious} = await service.print({reference: 'OFF-1'}, {...quick, pattern: {offset_mm: [60, 0]}});
  assert.ok(serious > 0);
  await show(page, `#/jobs/${id}`);
  await page.getByText('Do not print yet', {exact: true}).waitFor();
  assert.equal(await page.getByText('Print this one').count(), 0);
  assert.equal(await page.locator('.downloads a.primary').count(), 0);
  const {coils} = await (await service.ask(`/api/v1/jobs/${id}/artifacts/report.json`)).json();
  const made = coils.filter((coil) => coil.with?.on_head), both = made.filter((coil) => coil.without?.on_head);
  assert.ok(both.length > 0 && both.length < made.length, `${both.length} of ${made.length}: a case with different coils`);
  const figure = page.locator('.key-figure').first();
  assert.match(await figure.innerText(), new RegExp(`Mean over ${made.length} coils? on the head`));
  const mean = (way) => (100 * both.reduce((sum, coil) => sum + coil[way].circularity, 0) / both.length).toFixed(1);
  assert.match(await figure.innerText(), new RegExp(`Over the ${both.length} coils? that lies? on the head with both prints: ${mean('with')} %, and ${mean('without')} % if printed as drawn`));
});

test('downloads turn grey while the drawing is moved, and come back when that is undone', async ({page, jobs}) => {
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
});

test('two tabs keep two drafts', async ({page: first}) => {
  await show(first, '#/new');
  const second = await first.context().newPage();
  await second.goto('/#/new');
  await settled(second);
  const fill = async (page, text) => {
    await referenceField(page).fill(text);
    await referenceField(page).blur();
  };
  await fill(first, 'TAB-1');
  await fill(second, 'TAB-2');
  for (const [page, text] of [[first, 'TAB-1'], [second, 'TAB-2']]) {
    await page.reload();
    await settled(page);
    assert.equal(await referenceField(page).inputValue(), text);
  }
});

test('the settings of a new print cannot be changed until the job that it starts from has arrived', async ({page, jobs}) => {
  let release;
  const held = new Promise((done) => { release = done; });
  await page.route(`**/api/v1/jobs/${jobs.print}`, async (route) => {
    await held;
    await route.continue();
  });
  await page.goto(`/#/new?from=${jobs.print}`);
  const parts = page.locator('.new-print > .stack');
  await parts.waitFor();
  assert.equal(await parts.evaluate((element) => element.inert), true);
  release();
  await page.waitForFunction(() => !document.querySelector('.new-print > .stack').inert);
});
