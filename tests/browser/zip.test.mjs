// What comes in a zip, a model with its textures or a drawing for each layer: the page says that it cannot show it, sends it,
// and the print has its colours or its layers.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {checked, choose, drawn, drop, jobShown, leftOnRight, makeQuick, sample, setUp, show, startJob, startService, until, violations} from './drive.mjs';

const test = setUp(async () => ({service: await startService()}));

// A block with sloping sides, 110 x 150 mm below and 30 mm high, all in the one colour of its image.
function block() {
  const corners = [[0, 55, 75], [30, 40, 60]].flatMap(([z, x, y]) => [-y, y].flatMap((v) => [-x, x].map((u) => `v ${u} ${v} ${z}`)));
  const faces = ['1 3 4 2', '5 6 8 7', '1 2 6 5', '3 7 8 4', '1 5 7 3', '2 4 8 6'];
  return ['mtllib block.mtl', ...corners, 'vt 0.5 0.5', 'usemtl a', ...faces.map((face) => `f ${face.replace(/\d/g, '$&/1')}`), ''].join('\n');
}
const red = Buffer.from(
  'iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGM4IScCAAKsAPs2xCzlAAAAAElFTkSuQmCC', 'base64');

function zipped(folder, name, files) {
  for (const [file, content] of Object.entries(files)) writeFileSync(join(folder, file), content);
  execFileSync('python3', ['-m', 'zipfile', '-c', name, ...Object.keys(files)], {cwd: folder});
  return join(folder, name);
}

test('a zip is sent without being shown, and its colours are printed', async ({page, service}) => {
  await show(page, '#/new');
  await choose(page, 'Choose a scan', zipped(service.folder, 'block.zip', {'block.obj': block(), 'block.mtl': 'newmtl a\nmap_Kd red.png\n', 'red.png': red}));
  await page.getByRole('status').filter({hasText: 'block.zip is not shown here'}).waitFor();
  assert.equal((await page.getByRole('alert').allTextContents()).join(''), '');
  assert.deepEqual(await violations(page), []);
  await page.getByRole('radio', {name: 'mm', exact: false}).first().check();
  await page.locator('input[name=pattern-source][value=scan]').check();
  await makeQuick(page);
  await leftOnRight(page).check();
  // Nobody has seen this scan upright: the page asks.
  await checked(page);
  await until(async () => await page.locator('.new-step').first().locator('.step-status').innerText() === 'Needs a look', 'the findings');
  await page.getByRole('button', {name: 'Start the job'}).click();
  await page.getByRole('dialog').getByText('Which axis of the scan points up is a guess').waitFor();
  await page.getByRole('button', {name: 'Start anyway'}).click();
  const id = await jobShown(page);
  const job = await service.ended(id);
  assert.equal(job.state, 'succeeded', JSON.stringify(job.problem));
  assert.equal(job.settings.pattern.source, 'scan');
  const report = await service.json(`/api/v1/jobs/${id}/artifacts/report.json`);
  assert.ok(report.pattern.colours.full_mm2 > 5000, JSON.stringify(report.pattern.colours));
  assert.deepEqual(page.faults, []);
});

const ring = (x) => '<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="60mm" viewBox="0 0 90 60">' +
  `<circle cx="${x}" cy="30" r="18" fill="none" stroke="#000" stroke-width="3"/></svg>`;

test('a zip of drawings is sent without being shown, and each file is a layer of the print', async ({page, service}) => {
  await show(page, '#/new');
  await drop(page, sample().scan);
  await drawn(page);
  await choose(page, 'Choose a drawing', zipped(service.folder, 'rings.zip', {'head-F_Cu.svg': ring(35), 'head-B_Cu.svg': ring(55)}));
  await page.getByText('This page does not show files of this kind.').waitFor();
  assert.equal(await page.getByText('The file does not state its size').count(), 0);
  assert.deepEqual(await violations(page), []);
  await makeQuick(page);
  await leftOnRight(page).check();
  const job = await service.ended(await startJob(page));
  assert.equal(job.state, 'succeeded', JSON.stringify(job.problem));
  const {circuits, artifacts} = await service.json(`/api/v1/jobs/${job.id}/artifacts/report.json`);
  assert.equal(circuits.nets, 2);
  assert.ok(artifacts.some(({name}) => name === 'print-reverse.svg'));
  assert.deepEqual(page.faults, []);
});
