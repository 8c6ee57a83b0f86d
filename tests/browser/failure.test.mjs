// A print that failed says so, and shows where as far as the server kept its files.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {drawn, quick, settled, show, signIn, startBrowser, startService, violations} from './drive.mjs';

let service;
let job;
before(async () => {
  service = await startService();
  // After the scan was read: steps of time so long that the net of springs blows up, within a second.
  const id = await service.submit({reference: 'FAIL-1'}, {...quick, forming: {model: 'mass_spring', integrator: 'verlet', time_step_ms: 50}});
  job = await service.ended(id);
  assert.equal(job.state, 'failed');
  assert.match(job.problem.type, /forming-failed$/);
});
after(async () => { await service?.stop(); });

const has = (name) => job.artifacts.some((file) => file.name === name);
const files = 'the server keeps no files of a failed print yet';

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

test('it shows the mold in the machine, and the place', async (t) => {
  if (!has('mold.stl')) return t.skip(files);
  const findings = await service.json(`/api/v1/jobs/${job.id}/artifacts/findings.json`);
  await opened([], async (page) => {
    await page.getByRole('application', {name: 'The mold in the machine'}).waitFor();
    await drawn(page);
    assert.equal(await page.getByRole('button', {name: 'Show the place'}).count(), findings.problem.place_mm ? 1 : 0);
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

test('without WebGL it shows the pictures that the server kept', async (t) => {
  if (!has('findings.json')) return t.skip(files);
  await opened(['--disable-3d-apis'], async (page) => {
    await page.getByRole('heading', {name: 'Warnings'}).waitFor();
    const pictures = job.artifacts.filter((file) => file.name.startsWith('preview-'));
    assert.equal(await page.locator('main .pictures img').count(), pictures.length);
  });
});
