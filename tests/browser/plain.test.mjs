// Without scripts the plain pages show jobs: a person finds one, follows it to its end and downloads the print.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {download, setUp, startService, violations} from './drive.mjs';

const test = setUp(async () => ({service: await startService()}));

test('a job is found, followed and downloaded without scripts', {javaScriptEnabled: false}, async ({page, service}) => {
  const job = await service.submit({reference: 'CASE-7'});
  await page.waitForURL(/\/jobs$/);
  await page.reload();
  await page.getByRole('row').filter({hasText: 'CASE-7'}).getByRole('link').click();
  await page.waitForURL((url) => url.pathname === `/jobs/${job}`);
  await page.getByText('succeeded', {exact: true}).waitFor();  // the page reloads
  const bytes = readFileSync(await (await download(page)).path());
  const stored = Buffer.from(await (await service.ask(`/api/v1/jobs/${job}/artifacts/print.pdf`)).arrayBuffer());
  assert.equal(bytes.subarray(0, 5).toString(), '%PDF-');
  assert.ok(bytes.equals(stored));
  await page.getByRole('link', {name: 'Recent jobs'}).click();
  await page.waitForURL(/\/jobs$/);
  assert.deepEqual(page.faults, []);
});

test('the application leads to the plain pages without scripts', {javaScriptEnabled: false}, async ({page}) => {
  await page.waitForURL(/\/jobs$/);
  await page.getByText('Starting a print needs scripts').waitFor();
  await page.goto('/');
  await page.waitForURL(/\/jobs$/);
});

test('the list of the plain pages has no violation', async ({page}) => {
  await page.goto('/jobs');
  assert.deepEqual(await violations(page), []);
});
