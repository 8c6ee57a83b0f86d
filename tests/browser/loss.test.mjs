// The 3D view survives the loss of its graphics context once; after a second loss the pictures take its place.
import assert from 'node:assert/strict';
import {drawn, frames, setUp, show, until} from './drive.mjs';

const test = setUp();

const lose = (page) => page.locator('canvas[data-frame]').first().evaluate((canvas) => {
  window.lostContext = canvas.getContext('webgl2').getExtension('WEBGL_lose_context');
  window.lostContext.loseContext();
});

// The number of different colours in a picture of the canvas, which is one if it is blank.
const colours = async (page) => {
  const picture = (await page.locator('canvas[data-frame]').first().screenshot()).toString('base64');
  return page.evaluate(async (text) => {
    const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], {type: 'image/png'}));
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = canvas.getContext('2d');
    context.drawImage(bitmap, 0, 0);
    return new Set(new Uint32Array(context.getImageData(0, 0, bitmap.width, bitmap.height).data.buffer)).size;
  }, picture);
};

test('after a lost context the view is drawn again, and after a second one the pictures stand there', async ({page, jobs}) => {
  await show(page, `#/jobs/${jobs.print}`);
  await drawn(page);
  assert.ok(await colours(page) > 100);

  const before = await frames(page);
  await lose(page);
  await page.getByText('The graphics restart').waitFor();
  await page.evaluate(() => window.lostContext.restoreContext());
  await page.getByText('The 3D view works again').waitFor();
  await until(async () => await frames(page) > before, 'a new frame');
  await drawn(page);
  assert.ok(await colours(page) > 100);

  await lose(page);
  await page.getByText('The graphics failed twice').waitFor();
  await page.getByRole('img', {name: /CASE-7/}).first().waitFor();
  assert.equal(await page.locator('canvas[data-frame]:visible').count(), 0);
});
