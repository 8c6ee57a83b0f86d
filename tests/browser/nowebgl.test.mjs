// Without WebGL everything is there: fields and figures for the scan, the pictures of the server for the result.
import assert from 'node:assert/strict';
import {choose, leftOnRight, sample, setUp, show, startFurnished} from './drive.mjs';

const test = setUp(startFurnished, ['--disable-3d-apis']);

// The library for 3D says so itself when there is no WebGL.
const ofPage = (faults) => faults.filter((fault) => !/WebGL/i.test(fault));

test('a result shows the pictures of the server, its figures and its downloads', async ({page, jobs}) => {
  await show(page, `#/jobs/${jobs.print}`);
  assert.equal(await page.evaluate(() => document.createElement('canvas').getContext('webgl2')), null);
  await page.getByText('This browser shows no 3D graphics').waitFor();
  const pictures = await page.locator('main img').evaluateAll(async (images) => {
    for (const image of images) {
      image.loading = 'eager';
      await image.decode();
    }
    return images.map((image) => ({name: image.currentSrc.split('/').pop(), wide: image.naturalWidth, alt: image.alt}));
  });
  for (const name of ['preview-with.png', 'preview-without.png', 'preview-shape.png', 'preview-thickness.png'])
    assert.ok(pictures.some((picture) => picture.name === name && picture.wide > 100 && picture.alt.length > 10), `${name}: ${JSON.stringify(pictures)}`);
  assert.ok(await page.getByRole('table').filter({hasText: 'Out of round'}).getByRole('row').count() > 10);
  assert.ok(await page.getByRole('link', {name: 'print.pdf'}).first().isVisible());
  assert.deepEqual(ofPage(page.faults), []);
});

test('a scan is placed by its fields', async ({page}) => {
  await show(page, '#/new');
  await choose(page, 'Choose a scan', sample().scan);
  await page.getByText('This browser shows no 3D graphics').waitFor();
  assert.ok(await page.getByRole('radio', {name: 'mm', exact: false}).first().isChecked());
  const yaw = page.getByRole('textbox', {name: 'Turn about the vertical axis (yaw)'});
  await yaw.fill('10');
  await yaw.blur();
  await leftOnRight(page).check();
  assert.equal(await page.locator('canvas').count(), 0);
  assert.deepEqual(ofPage(page.faults), []);
});
