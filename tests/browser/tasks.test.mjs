// Twelve tasks of staff, in their order of a day, by the names that people see; each goes on where the one before ended.
import assert from 'node:assert/strict';
import {checked, download, drawn, giveSample, jobShown, leftOnRight, referenceField, settled, setUp, show, startFurnished, startJob} from './drive.mjs';

const budget = 180;  // seconds for all of them
const test = setUp(() => startFurnished(1));

test('twelve tasks of staff are done within three minutes', async ({page, service, t}) => {
  const began = Date.now();
  const row = (name) => page.getByRole('link', {name, exact: true}).first();
  let job = '';

  await t.test('find the job of an order', async () => {
    await show(page, '#/jobs');
    await page.getByLabel('Reference, note or id').fill('case-7');
    await row('CASE-7').waitFor();
    await page.getByRole('link', {name: 'CASE-8', exact: true}).waitFor({state: 'detached'});
  });
  await t.test('read how round its coils come out', async () => {
    await row('CASE-7').click();
    await page.getByText('Out of round', {exact: true}).first().waitFor();
    await page.getByText(/if printed as drawn/).first().waitFor();
  });
  await t.test('look at the part from the left of the patient', async () => {
    await drawn(page);
    await page.getByRole('button', {name: /^(Patient's left|Side −x)$/}).click();
    await drawn(page);
  });
  await t.test('see where the sheet is thin', async () => {
    await page.getByLabel('What is shown').selectOption('thickness');
    await drawn(page);
    await page.getByText(/mm$/).first().waitFor();
  });
  await t.test('learn what must be true when it is printed', async () => {
    await page.getByRole('tab', {name: 'Print sheet'}).click();
    await page.getByRole('button', {name: 'When you print'}).click();
    await page.getByText(/^Measure the printed ruler with a steel ruler/).waitFor();
  });
  await t.test('download the print', async () => {
    assert.equal((await download(page)).suggestedFilename(), 'CASE-7-outer-print.pdf');
  });
  await t.test('prepare another print of the same head', async () => {
    await page.getByRole('link', {name: 'New print from this job'}).click();
    await settled(page);
    await page.getByLabel('Rotation', {exact: true}).first().fill('15');
    await referenceField(page).fill('CASE-7-B');
    await checked(page);
    await page.getByRole('button', {name: 'Start the job'}).click();
    const dialog = page.getByRole('dialog');
    await Promise.race([dialog.waitFor(), page.waitForURL(/#\/jobs\/[^/]+$/)]);
    if (await dialog.count()) await dialog.getByRole('button', {name: 'Start anyway'}).click();
    job = await jobShown(page);
    assert.equal((await service.ended(job)).state, 'succeeded');
    await page.getByRole('link', {name: 'print.pdf'}).first().waitFor({timeout: 30_000});
  });
  await t.test('compare the two', async () => {
    await show(page, '#/jobs');
    for (const name of ['CASE-7', 'CASE-7-B'])
      await page.getByRole('checkbox', {name: new RegExp(`${name}( |$)`)}).first().check();
    await page.getByRole('link', {name: 'Compare', exact: true}).or(page.getByRole('button', {name: 'Compare', exact: true})).first().click();
    await page.getByText('Both jobs have the same scan and the same drawing.').waitFor();
    await page.getByRole('rowheader', {name: 'Rotation'}).or(page.getByRole('cell', {name: 'Rotation'})).first().waitFor();
  });
  await t.test('understand why a job failed, and what to do', async () => {
    await show(page, '#/jobs?state=failed');
    await row('CASE-8').click();
    await page.getByRole('alert').getByText(/^What to do: /).waitFor();
    await page.getByRole('link', {name: 'Try again with a change'}).waitFor();
  });
  await t.test('start a print of a new head and cancel it', async () => {
    await show(page, '#/new');
    await giveSample(page);
    await leftOnRight(page).check();
    const started = await startJob(page);
    await page.getByRole('button', {name: 'Cancel the job'}).or(page.getByRole('link', {name: 'print.pdf'})).first().waitFor();
    const cancel = page.getByRole('button', {name: 'Cancel the job'});
    if (await cancel.count()) await cancel.click();
    assert.ok(['cancelled', 'succeeded'].includes((await service.ended(started)).state));
  });
  await t.test('delete a job', async () => {
    await show(page, `#/jobs/${job}`);
    await page.getByRole('button', {name: 'Delete', exact: true}).first().click();
    await page.getByRole('dialog').getByRole('button', {name: 'Delete', exact: true}).click();
    await page.waitForURL(/#\/jobs$/);
    await page.getByText('CASE-7-B', {exact: true}).waitFor({state: 'detached'});
  });
  await t.test('see whether the service is well', async () => {
    await page.getByRole('link', {name: 'Administration'}).click();
    await page.getByText(/waits for a job/).first().waitFor();
  });

  assert.deepEqual(page.faults, []);
  const seconds = (Date.now() - began) / 1000;
  assert.ok(seconds < budget, `${seconds} s of ${budget}`);
});
