// The ICC profile of the printer: from the page to the job and to the next print; a profile of another kind is refused.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {createHash} from 'node:crypto';
import {writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {choose, giveSample, leftOnRight, root, setUp, settled, show, startJob, startService} from './drive.mjs';

const test = setUp(async () => ({service: await startService()}));

// A profile for 'RGB ' or 'CMYK' in a file of that name.
function profile(service, name, space) {
  const bytes = execFileSync('python3', ['-c', 'import hostile, sys; sys.stdout.buffer.write(hostile.icc(sys.argv[1].encode()))', space],
                             {env: {...process.env, PYTHONPATH: join(root, 'tests/integration'), PYTHONDONTWRITEBYTECODE: '1'}});
  const path = join(service.folder, name);
  writeFileSync(path, bytes);
  return {path, bytes: bytes.length, sha256: createHash('sha256').update(bytes).digest('hex')};
}

test('an ICC profile goes with the job, outlives a reload, and is used again', async ({page, service}) => {
  const rgb = profile(service, 'printer.icc', 'RGB ');
  await show(page, '#/new');
  await giveSample(page);
  await choose(page, 'Choose an ICC profile', rgb.path);
  await page.getByRole('button', {name: 'Remove the ICC profile'}).waitFor();
  const arrived = page.getByRole('definition').filter({hasText: 'printer.icc'});
  await arrived.waitFor();
  await page.reload();
  await settled(page);
  await arrived.waitFor();
  await leftOnRight(page).check();
  const id = await startJob(page);
  const job = await service.ended(id);
  assert.equal(job.state, 'succeeded', JSON.stringify(job.problem));
  assert.equal(job.inputs.icc.sha256, rgb.sha256);

  await show(page, `#/new?from=${id}`);
  await page.getByText('The ICC profile of that job is used').waitFor();
  const again = await service.ended(await startJob(page));
  assert.equal(again.inputs.icc.sha256, rgb.sha256);
  assert.deepEqual(page.faults, []);
});

test('an ICC profile can be removed, and undo brings it back', async ({page, service}) => {
  const {path} = profile(service, 'printer.icc', 'RGB ');
  let uploads = 0;
  page.on('request', (request) => { if (request.method() === 'POST' && request.url().endsWith('/uploads')) ++uploads; });
  await show(page, '#/new');
  await choose(page, 'Choose an ICC profile', path);
  const remove = page.getByRole('button', {name: 'Remove the ICC profile'});
  await page.getByText('The ICC profile has arrived.').waitFor({state: 'attached'});
  await remove.click();
  await remove.waitFor({state: 'detached'});
  await page.getByRole('button', {name: 'Undo'}).click();
  await remove.waitFor();
  assert.equal(uploads, 1);
  assert.deepEqual(page.faults, []);
});

test('a file that is no RGB profile is refused with what to do', async ({page, service}) => {
  await show(page, '#/new');
  const alert = page.getByRole('alert');
  await choose(page, 'Choose an ICC profile', profile(service, 'press.icc', 'CMYK').path);
  await alert.getByText('press.icc is a profile for CMYK. The print needs one for RGB.').waitFor();
  const other = join(service.folder, 'text.icc');
  writeFileSync(other, 'hello');
  await choose(page, 'Choose an ICC profile', other);
  await alert.getByText('text.icc is not an ICC profile').waitFor();
  assert.equal(await page.getByRole('button', {name: 'Remove the ICC profile'}).count(), 0);
  await choose(page, 'Choose an ICC profile', profile(service, 'printer.icc', 'RGB ').path);
  await page.getByRole('button', {name: 'Remove the ICC profile'}).waitFor();
  assert.equal(await alert.getByText('text.icc').count(), 0);
  assert.deepEqual(page.faults, []);
});
