// The whole way: from a dropped scan to the downloaded print.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {after, before, test} from 'node:test';
import {choose, drawn, drop, makeQuick, sample, settled, show, signIn, startBrowser, startService} from './drive.mjs';

let service;
let browser;
before(async () => {
  browser = await startBrowser();
  service = await startService();
});
after(async () => { await browser?.close(); await service?.stop(); });

test('a person makes a print from a dropped scan, and downloads it under the name of the case', async () => {
  const {scan, pattern} = sample();
  const page = await signIn(browser, service, {acceptDownloads: true});
  await show(page, '#/jobs');
  await page.getByRole('link', {name: 'New print'}).first().click();
  await settled(page);

  await drop(page, scan);
  await drawn(page);
  assert.ok(await page.getByRole('radio', {name: 'mm', exact: false}).first().isChecked());
  await page.getByRole('radio', {name: 'On the right in the picture, at −x'}).check();
  await page.getByText('The letters L and R stand beside the scan').waitFor();

  await choose(page, 'Choose a drawing', pattern);
  await page.getByAltText(/^The pattern pattern\.svg laid flat/).waitFor();
  await makeQuick(page);
  await page.getByLabel('Reference', {exact: true}).fill('CASE-12');
  await page.getByText('Checked by the service. Everything is there.').waitFor({timeout: 60_000});
  await page.getByRole('button', {name: 'Start the job'}).click();

  await page.waitForURL(/#\/jobs\/[^/]+$/);
  const id = page.url().split('/').pop();
  const job = await service.ended(id);
  assert.equal(job.state, 'succeeded', JSON.stringify(job.problem));
  assert.equal(job.reference, 'CASE-12');
  assert.equal(job.settings.scan.left_side, 'minus_x');
  assert.equal(job.inputs.scan.bytes, readFileSync(scan).length);

  // Without a reload the page has followed the job to its end.
  const link = page.getByRole('link', {name: 'print.pdf'}).first();
  await link.waitFor({timeout: 30_000});
  assert.match(await page.title(), /CASE-12/);
  const [download] = await Promise.all([page.waitForEvent('download'), link.click()]);
  assert.match(download.suggestedFilename(), /^CASE-12-outer-print\.pdf$/);
  const bytes = readFileSync(await download.path());
  const stored = Buffer.from(await (await service.ask(`/api/v1/jobs/${id}/artifacts/print.pdf`)).arrayBuffer());
  assert.ok(bytes.equals(stored));
  assert.equal(bytes.subarray(0, 5).toString(), '%PDF-');
  assert.deepEqual(page.faults, []);

  // In the list it stands under its reference.
  await show(page, '#/jobs');
  await page.getByRole('link', {name: /CASE-12/}).first().waitFor();
  await page.context().close();
});

test('the sample job of the help page starts with one click', async () => {
  const page = await signIn(browser, service);
  await show(page, '#/help');
  await page.getByRole('button', {name: 'Make the sample job'}).click();
  await page.waitForURL(/#\/jobs\/[^/]+$/);
  const id = page.url().split('/').pop();
  const job = await service.json(`/api/v1/jobs/${id}`);
  assert.equal(job.reference, 'SAMPLE');
  assert.equal(job.inputs.scan.bytes, readFileSync(sample().scan).length);
  await page.getByRole('button', {name: 'Cancel the job'}).click();
  await service.ended(id);
  await page.getByText('Cancelled', {exact: true}).first().waitFor();
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('the settings survive a reload, and a wrong file is refused with what to do', async () => {
  const page = await signIn(browser, service);
  await show(page, '#/new');
  await page.getByLabel('Reference', {exact: true}).fill('CASE-13');
  await page.getByLabel('Reference', {exact: true}).blur();
  await drop(page, sample().pattern, 'photo.stl');
  await page.getByRole('alert').filter({hasText: 'This scan cannot be shown'}).waitFor();
  await page.reload();
  await settled(page);
  assert.equal(await page.getByLabel('Reference', {exact: true}).inputValue(), 'CASE-13');
  await page.context().close();
});
