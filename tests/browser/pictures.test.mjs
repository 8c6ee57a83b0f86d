// The 3D view draws what it drew before: pictures of the canvas, compared pixel by pixel with those in expected/.
// VACUFORM_UPDATE_PICTURES=1 writes them again: look at them before you commit them. VACUFORM_KEEP_PICTURES=FOLDER keeps those
// that differ.
import assert from 'node:assert/strict';
import {existsSync, mkdirSync, readFileSync, writeFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {drawn, drawnModestly, setUp, show} from './drive.mjs';

const folder = join(dirname(fileURLToPath(import.meta.url)), 'expected');
const most = 0.001;  // the share of pixels that may differ, and by how many of 255 levels before one counts
const levels = 16;
const test = setUp();

// The share of pixels that differ; and how many different colours the first picture has, since an empty one has few.
async function compared(browser, picture, expected) {
  const page = await browser.newPage();
  const answer = await page.evaluate(async ([sources, least]) => {
    const [a, b] = await Promise.all(sources.map(async (source) => {
      const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${source}`)).blob());
      const canvas = new OffscreenCanvas(image.width, image.height);
      const context = canvas.getContext('2d');
      context.drawImage(image, 0, 0);
      return {size: `${image.width} x ${image.height}`, data: context.getImageData(0, 0, image.width, image.height).data};
    }));
    if (a.size !== b.size) return {sizes: [a.size, b.size]};
    let different = 0;
    const colours = new Set();
    for (let i = 0; i < a.data.length; i += 4) {
      if ([0, 1, 2].some((k) => Math.abs(a.data[i + k] - b.data[i + k]) > least)) ++different;
      colours.add((a.data[i] << 16) | (a.data[i + 1] << 8) | a.data[i + 2]);
    }
    return {share: different / (a.data.length / 4), colours: colours.size};
  }, [[picture, expected].map((bytes) => bytes.toString('base64')), levels]);
  await page.close();
  return answer;
}

async function picture(page, name) {
  await drawn(page);
  const bytes = await page.locator('canvas[data-frame]').first().screenshot();
  const path = join(folder, `${name}.png`);
  if (process.env.VACUFORM_UPDATE_PICTURES) {
    mkdirSync(folder, {recursive: true});
    writeFileSync(path, bytes);
    return;
  }
  assert.ok(existsSync(path), `${path} is missing`);
  const {sizes, share, colours} = await compared(page.context().browser(), bytes, readFileSync(path));
  if (process.env.VACUFORM_KEEP_PICTURES && (sizes || share > most)) writeFileSync(join(process.env.VACUFORM_KEEP_PICTURES, `${name}.png`), bytes);
  assert.equal(sizes, undefined, `${name}: ${sizes}`);
  assert.ok(colours > 50, `${name} shows ${colours} colours alone`);
  assert.ok(share <= most, `${name}: ${(100 * share).toFixed(2)} % of the pixels differ`);
}

test('the formed part looks as before, with its print and with its maps', async ({page, jobs}) => {
  await drawnModestly(page);
  await show(page, `#/jobs/${jobs.print}`);
  await page.getByRole('button', {name: 'Pre-distorted', exact: true}).click();
  await page.getByRole('button', {name: 'Above', exact: true}).click();
  await picture(page, 'print-above');
  await page.getByLabel('What is shown').selectOption('thickness');
  await page.getByRole('button', {name: 'Front', exact: true}).click();
  await picture(page, 'thickness-front');
  assert.deepEqual(page.faults, []);
});

test('every map has a picture of its own', async ({page, jobs}) => {
  await show(page, `#/jobs/${jobs.print}`);
  await page.getByRole('button', {name: 'Pre-distorted', exact: true}).click();
  const choice = page.getByLabel('What is shown'), maps = await choice.locator('option').allTextContents();
  assert.equal(maps.length, 6);
  const pictures = new Set();
  for (const label of maps) {
    await choice.selectOption({label});
    await drawn(page);
    pictures.add((await page.locator('canvas[data-frame]').first().screenshot()).toString('base64'));
  }
  assert.equal(pictures.size, maps.length);
  assert.deepEqual(page.faults, []);
});
