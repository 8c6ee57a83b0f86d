// A heat map has the same name, range and colours on the page, in its preview and in the report.
import assert from 'node:assert/strict';
import {setUp, show} from './drive.mjs';

const test = setUp();
const points = 10;

// The colours of a PNG at even places of one of its rows, without `margin` pixels at both ends. `row`: 'middle', or pixels
// above the lower edge.
async function colours(browser, png, margin, row) {
  const page = await browser.newPage();  // without the policy of our pages
  const found = await page.evaluate(async ({source, margin, row, points}) => {
    const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${source}`)).blob());
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    const y = row === 'middle' ? image.height >> 1 : image.height - row;
    return Array.from({length: points}, (_, i) =>
      [...context.getImageData(Math.round(margin + (image.width - 2 * margin) * (i + 0.5) / points), y, 1, 1).data].slice(0, 3));
  }, {source: png.toString('base64'), margin, row, points});
  await page.close();
  return found;
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
    const onPage = await colours(browser, await legend.locator('.legend-bar').screenshot(), 0, 'middle');
    const inPreview = await colours(browser, await file(`preview-${id}.png`), 40, 46);
    onPage.forEach((colour, i) => colour.forEach((part, k) =>
      assert.ok(Math.abs(part - inPreview[i][k]) <= 6, `${id} at ${i}: ${colour} on the page, ${inPreview[i]} in the preview`)));
  }
  await show(page, `#/jobs/${jobs.print}?map=nothing`);
  assert.equal(await page.locator('#result-map').inputValue(), 'print');
  assert.deepEqual(page.faults, []);
});
