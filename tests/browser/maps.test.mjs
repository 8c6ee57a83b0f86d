// A heat map has the same name, range and colours on the page, in its preview and in the report.
import assert from 'node:assert/strict';
import {setUp, show} from './drive.mjs';

const test = setUp();
const points = 10;

// The colours of a PNG at even places of one of its rows, without `margin` pixels at both ends.
async function colours(browser, png, margin, rowOf) {
  const page = await browser.newPage();  // without the policy of our pages
  const {width, height, data} = await page.evaluate(async (source) => {
    const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${source}`)).blob());
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    return {width: image.width, height: image.height, data: [...context.getImageData(0, 0, image.width, image.height).data]};
  }, png.toString('base64'));
  await page.close();
  return Array.from({length: points}, (_, i) => {
    const at = 4 * (rowOf(height) * width + Math.round(margin + (width - 2 * margin) * (i + 0.5) / points));
    return data.slice(at, at + 3);
  });
}

test('every map has the name, the range and the colours of its preview', async ({page, browser, service, jobs}) => {
  const file = async (name) => Buffer.from(await (await service.ask(`/api/v1/jobs/${jobs.print}/artifacts/${name}`)).arrayBuffer());
  const {maps} = JSON.parse(await file('report.json'));
  assert.deepEqual(maps.map(({id}) => id), ['shape', 'area', 'thickness', 'gap']);
  await show(page, `#/jobs/${jobs.print}`);
  for (const {id, title, low, high, step} of maps) {
    await page.locator('#result-map').selectOption(id);
    const legend = page.locator('.legend-host .legend');
    assert.ok((await legend.locator('figcaption').innerText()).startsWith(title), title);
    const marks = (await legend.locator('.legend-scale span').allInnerTexts()).map(Number);
    assert.ok(marks[0] - low > -1e-9 && marks[0] - low < step && high - marks.at(-1) > -1e-9 && high - marks.at(-1) < step, `${id}: ${marks}`);
    const onPage = await colours(browser, await legend.locator('.legend-bar').screenshot(), 0, (height) => height >> 1);
    const inPreview = await colours(browser, await file(`preview-${id}.png`), 40, (height) => height - 46);
    onPage.forEach((colour, i) => colour.forEach((part, k) =>
      assert.ok(Math.abs(part - inPreview[i][k]) <= 6, `${id} at ${i}: ${colour} on the page, ${inPreview[i]} in the preview`)));
  }
  await show(page, `#/jobs/${jobs.print}?map=nothing`);
  assert.equal(await page.locator('#result-map').inputValue(), 'print');
  assert.deepEqual(page.faults, []);
});
