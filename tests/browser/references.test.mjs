// A reference belongs to one head: it goes with the scan, and is corrected with a trace.
import assert from 'node:assert/strict';
import {checked, dropText, jobShown, referenceField, setUp, show, startService, violations} from './drive.mjs';
import {head} from './heads.mjs';

const svg = '<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="80mm" viewBox="0 0 90 80"><circle cx="40" cy="40" r="30" fill="none" stroke="#000"/></svg>';
const jobOf = (service, scan, reference) => service.submit({
  reference, scan: [new Blob([scan]), 'head.obj'], kind: 'print', pattern: [new Blob([svg]), 'coils.svg']});
const test = setUp(async () => ({service: await startService({workers: 0})}));

async function start(page) {
  await page.getByRole('button', {name: 'Start the job'}).click();
  await page.getByRole('button', {name: 'Start anyway'}).click();
  return jobShown(page);
}

test('a new print from a job does not give its reference to another head', async ({page, service}) => {
  const first = await jobOf(service, head(), 'CASE-2000');
  await show(page, `#/new?from=${first}`);
  await page.waitForFunction(() => document.querySelector('#new-reference')?.value === 'CASE-2000');
  await dropText(page, head({shift: [3, -7, 11], turn: 17, scale: 0.97}), 'other.obj');
  await page.getByText(/The reference CASE-2000 was removed/).first().waitFor();
  assert.equal(await referenceField(page).inputValue(), '');
  await page.getByRole('button', {name: 'Undo'}).click();
  assert.equal(await referenceField(page).inputValue(), '');
  await checked(page);
  // Typed again, it is refused before anything is started.
  await referenceField(page).fill('CASE-2000');
  await referenceField(page).blur();
  await page.getByRole('alert').filter({hasText: 'This reference belongs to the head of another job'}).first().waitFor();
  await page.getByText('1 point keeps the job from starting.').waitFor();
  assert.deepEqual(await violations(page), []);
  await page.getByLabel('This is another scan of the same patient').check();
  await checked(page);
  // Another text needs its own confirmation.
  await referenceField(page).fill('CASE-2001');
  await referenceField(page).blur();
  await checked(page);
  assert.equal(await page.getByLabel('This is another scan of the same patient').count(), 0);
  const job = await service.json(`/api/v1/jobs/${await start(page)}`);
  assert.equal(job.reference, 'CASE-2001');
  assert.equal(job.derived_from, first);
  assert.deepEqual(page.faults.filter((fault) => !/422/.test(fault)), []);
});

test('another scan of the same patient keeps the reference once that is confirmed', async ({page, service}) => {
  const first = await jobOf(service, head(), 'CASE-3000');
  await show(page, `#/new?from=${first}`);
  await page.waitForFunction(() => document.querySelector('#new-reference')?.value === 'CASE-3000');
  await dropText(page, head({scale: 1.02}), 'again.obj');
  await page.getByText(/The reference CASE-3000 was removed/).first().waitFor();
  await referenceField(page).fill('CASE-3000');
  await referenceField(page).blur();
  await page.getByLabel('This is another scan of the same patient').check();
  await checked(page);
  const job = await service.json(`/api/v1/jobs/${await start(page)}`);
  assert.equal(job.reference, 'CASE-3000');
  const {lines} = await service.json(`/api/v1/jobs/${job.id}/log`);
  assert.ok(lines.some(({text}) => text === 'confirmed as another scan of the same patient'));
});

test('a reference is added and corrected after the start, and the page says by whom', async ({page, service}) => {
  const id = await jobOf(service, head({scale: 0.9}), '');
  await jobOf(service, head({scale: 0.8}), 'CASE-4000');
  await page.goto(`/#/jobs/${id}`);  // its stream of events never ends
  const save = async (text) => {
    await page.getByRole('dialog').getByLabel('Reference', {exact: true}).fill(text);
    await page.getByRole('button', {name: 'Save the reference'}).click();
  };
  await page.getByRole('button', {name: 'Add a reference'}).click();
  assert.deepEqual(await violations(page), []);
  await save('CASE-4000');  // of another head
  await page.getByRole('dialog').getByText('This reference belongs to the head of another job').waitFor();
  await save('CASE-4010');
  await page.getByRole('heading', {name: 'CASE-4010'}).waitFor();
  await page.getByRole('button', {name: 'Correct the reference'}).click();
  await save('CASE-4001');
  await page.getByRole('heading', {name: 'CASE-4001'}).waitFor();
  assert.equal(await page.evaluate(() => document.activeElement?.id), 'change-reference');
  await page.getByText(/admin \(token .*\) changed the reference from “CASE-4010” to “CASE-4001”/).waitFor();
  const job = await service.json(`/api/v1/jobs/${id}`);
  assert.deepEqual(job.reference_changes.map((change) => [change.old, change.new]), [['', 'CASE-4010'], ['CASE-4010', 'CASE-4001']]);
  assert.deepEqual(await violations(page), []);
  await page.reload();
  await page.getByRole('list', {name: 'Changes of the reference'}).getByRole('listitem').nth(1).waitFor();
});
