// A print that failed says why, and shows where.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {drawn, settled, show, signIn, startBrowser, startService, violations} from './drive.mjs';

// A tower with walls so steep and high that the sheet tears beside it.
function tower() {
  const corners = [0, 240].flatMap((z) => [-10, 10].flatMap((y) => [-10, 10].map((x) => `v ${x} ${y} ${z}`)));
  return [...corners, 'f 1 3 4 2', 'f 5 6 8 7', 'f 1 2 6 5', 'f 3 7 8 4', 'f 1 5 7 3', 'f 2 4 8 6'].join('\n');
}

let service;
let job;
before(async () => {
  service = await startService();
  const id = await service.submit({reference: 'FAIL-1', scan: [new Blob([tower()]), 'tower.obj']}, {
    scan: {units: 'mm', up: '+z'}, sheet: {resolution_mm: 4}, forming: {law: 'neo_hookean'}});
  job = await service.ended(id);
  assert.equal(job.state, 'failed');
  assert.match(job.problem.type, /forming-failed$/);
});
after(async () => { await service?.stop(); });

async function opened(flags, run) {
  const browser = await startBrowser(flags);
  try {
    const page = await signIn(browser, service);
    await show(page, `#/jobs/${job.id}`);
    await run(page);
    assert.deepEqual(page.faults.filter((fault) => flags.length === 0 || !/WebGL/i.test(fault)), []);
  } finally {
    await browser.close();
  }
}

test('a failed print says what happened and what to do', () => opened([], async (page) => {
  await page.getByRole('heading', {name: job.problem.title}).waitFor();
  await page.getByText(job.problem.what).waitFor();
  await page.getByRole('link', {name: 'Try again with a change'}).click();
  await page.waitForURL(/#\/new/);
  await settled(page);
}));

test('it shows the mold in the machine, and the place', async () => {
  await opened([], async (page) => {
    await page.getByRole('application', {name: 'The mold in the machine'}).waitFor();
    await drawn(page);
    await page.getByRole('button', {name: 'Show the place'}).waitFor();
    const below = page.getByRole('button', {name: 'Below', exact: true});
    for (const button of await page.getByRole('button', {name: /^Show (the place|me)/}).all()) {
      await below.click();
      await drawn(page);
      await button.click();
      await drawn(page);
      assert.equal(await below.getAttribute('aria-pressed'), 'false', 'the view has turned to the place');
    }
    assert.deepEqual(await violations(page), []);
  });
});

test('without WebGL it shows the pictures that the server kept', async () => {
  await opened(['--disable-3d-apis'], async (page) => {
    await page.getByRole('heading', {name: 'Warnings'}).waitFor();
    const pictures = job.artifacts.filter((file) => file.name.startsWith('preview-'));
    assert.equal(await page.locator('main .pictures img').count(), pictures.length);
  });
});
