// The whole way: from a dropped scan to the downloaded print.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {download, drop, giveSample, jobShown, leftOnRight, referenceField, sample, settled, setUp, show, startJob, startService} from './drive.mjs';

const test = setUp(async () => ({service: await startService()}));

test('a person makes a print from a dropped scan, and downloads it under the name of the case', async ({page, service}) => {
  await show(page, '#/jobs');
  await page.getByRole('link', {name: 'New print'}).first().click();
  await settled(page);

  await giveSample(page);
  assert.ok(await page.getByRole('radio', {name: 'mm', exact: false}).first().isChecked());
  await page.getByAltText(/^The pattern pattern\.svg laid flat/).waitFor();
  await leftOnRight(page).check();
  await page.getByText('The letters L and R stand beside the scan').waitFor();
  await referenceField(page).fill('CASE-12');
  const id = await startJob(page);
  const job = await service.ended(id);
  assert.equal(job.state, 'succeeded', JSON.stringify(job.problem));
  assert.equal(job.reference, 'CASE-12');
  assert.equal(job.settings.scan.left_side, 'minus_x');
  assert.equal(job.inputs.scan.bytes, readFileSync(sample().scan).length);

  // Without a reload the page has followed the job to its end.
  const file = await download(page);
  assert.match(await page.title(), /CASE-12/);
  assert.equal(file.suggestedFilename(), 'CASE-12-outer-print.pdf');
  const bytes = readFileSync(await file.path());
  const stored = Buffer.from(await (await service.ask(`/api/v1/jobs/${id}/artifacts/print.pdf`)).arrayBuffer());
  assert.ok(bytes.equals(stored));
  assert.equal(bytes.subarray(0, 5).toString(), '%PDF-');
  assert.deepEqual(page.faults, []);

  // In the list it stands under its reference.
  await show(page, '#/jobs');
  await page.getByRole('link', {name: /CASE-12/}).first().waitFor();
});

test('the sample job of the help page starts with one click', async ({page, service}) => {
  await show(page, '#/help');
  await page.getByRole('button', {name: 'Make the sample job'}).click();
  const id = await jobShown(page);
  const job = await service.json(`/api/v1/jobs/${id}`);
  assert.equal(job.reference, 'SAMPLE');
  assert.equal(job.inputs.scan.bytes, readFileSync(sample().scan).length);
  await page.getByRole('button', {name: 'Cancel the job'}).click();
  await service.ended(id);
  await page.getByText('Cancelled', {exact: true}).first().waitFor();
  assert.deepEqual(page.faults, []);
});

test('the settings survive a reload, and a wrong file is refused with what to do', async ({page}) => {
  await show(page, '#/new');
  await referenceField(page).fill('CASE-13');
  await referenceField(page).blur();
  await drop(page, sample().pattern, 'photo.stl');
  await page.getByRole('alert').filter({hasText: 'This scan cannot be shown'}).waitFor();
  await page.reload();
  await settled(page);
  assert.equal(await referenceField(page).inputValue(), 'CASE-13');
});
