// Without scripts the plain pages do the whole job.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {download, sample, setUp, startService} from './drive.mjs';

const test = setUp(async () => ({service: await startService()}));

test('a job goes from the form to the downloaded print without scripts', {javaScriptEnabled: false}, async ({page, service}) => {
  await page.waitForURL(/\/jobs$/);
  const {scan, pattern} = sample();
  await page.getByLabel('Scan of the head').setInputFiles(scan);
  await page.getByLabel('Pattern', {exact: true}).setInputFiles(pattern);
  const folded = page.locator('details:not([open]) > summary');
  while (await folded.count() > 0) await folded.first().click();
  await page.locator('[name="sheet.resolution_mm"]').fill('6');
  await page.locator('[name="print.dpi"]').fill('100');
  await page.getByRole('button', {name: 'Start the job'}).click();
  await page.waitForURL(/\/jobs\/[^/]+$/);
  const job = page.url().split('/').pop();
  await service.ended(job);
  await page.reload();
  await page.getByText('succeeded', {exact: true}).waitFor();
  const bytes = readFileSync(await (await download(page)).path());
  const stored = Buffer.from(await (await service.ask(`/api/v1/jobs/${job}/artifacts/print.pdf`)).arrayBuffer());
  assert.equal(bytes.subarray(0, 5).toString(), '%PDF-');
  assert.ok(bytes.equals(stored));
  assert.deepEqual(page.faults, []);
});

test('the application leads to the plain pages without scripts', {javaScriptEnabled: false}, async ({page}) => {
  await page.waitForURL(/\/jobs$/);
  await page.getByRole('button', {name: 'Start the job'}).waitFor();
  await page.goto('/');
  await page.waitForURL(/\/jobs$/);
});
