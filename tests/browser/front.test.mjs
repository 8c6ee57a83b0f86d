// The question where the left ear is: the whole head from the front beside it, at every width, with its letters, with and
// without WebGL. And no tick before it is answered.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {dropText, leftOnRight, settled, show, signIn, startBrowser, startService, until, violations} from './drive.mjs';
import {head} from './heads.mjs';

let service;
before(async () => { service = await startService({workers: 0}); });
after(async () => { await service?.stop(); });

// How much of the outer tenth on each side of the picture is covered, within the middle of its height.
const sides = (page) => page.locator('.scan-front img').evaluate(async (image) => {
  for (let source = ''; source !== image.src;) {  // the page may replace the picture while it is decoded
    source = image.src;
    await image.decode().catch((error) => { if (source === image.src) throw error; });
  }
  const {naturalWidth: w, naturalHeight: h} = image, canvas = document.createElement('canvas');
  canvas.width = w;
  canvas.height = h;
  const pen = canvas.getContext('2d', {willReadFrequently: true});
  pen.drawImage(image, 0, 0);
  const share = (from) => {
    const {data} = pen.getImageData(from, h * 0.4, w * 0.06, h * 0.2);
    let covered = 0;
    for (let i = 3; i < data.length; i += 4) covered += data[i] > 0 ? 1 : 0;
    return covered / (data.length / 4);
  };
  const {data} = pen.getImageData(0, 0, w, h);
  let pale = 0, solid = 0;
  for (let i = 3; i < data.length; i += 4) data[i] === 255 ? ++solid : data[i] > 0 && ++pale;
  return {left: share(0), right: share(w * 0.94), pale, solid};
});
const letters = (page) => page.locator('.scan-front span').allInnerTexts();

for (const [name, flags] of [['with WebGL', []], ['without WebGL', ['--disable-3d-apis']]])
  test(`the picture shows the ear on its side, ${name}`, async () => {
    const browser = await startBrowser(flags);
    for (const viewport of [{width: 1280, height: 800}, {width: 800, height: 900}, {width: 360, height: 740}]) {
      const page = await signIn(browser, service, {viewport});
      await show(page, '#/new');
      await dropText(page, head({shift: [31, -22, 500]}), 'head.obj');
      const image = page.locator('.scan-front img');
      await until(() => image.getAttribute('src'), 'the picture');
      const there = await sides(page);
      // the ear is narrower than the head: only on its side the picture's edge is nearly empty
      assert.ok(there.right < 0.75 * there.left, JSON.stringify(there));
      assert.ok(there.solid > 10_000, JSON.stringify(there));
      assert.deepEqual(await letters(page), ['+x', '−x']);
      // beside the question: the head, its letters and the first answer are in sight together, and nothing is cut off
      await leftOnRight(page).scrollIntoViewIfNeeded();
      await page.locator('.sides').evaluate((box) => box.scrollIntoView({block: 'start'}));
      await page.evaluate(() => scrollBy(0, -80));
      const boxes = await Promise.all([image, ...await page.locator('.scan-front span').all(), leftOnRight(page)].map((one) => one.boundingBox()));
      for (const {x, y, width, height} of boxes) {
        assert.ok(x >= 0 && x + width <= viewport.width, JSON.stringify(boxes));
        assert.ok(y >= 0 && y + height <= viewport.height, JSON.stringify(boxes));
      }
      const [picture, plus, minus] = boxes;
      assert.ok(plus.x + plus.width <= picture.x && minus.x >= picture.x + picture.width, 'the letters are beside the head');
      assert.ok(picture.height >= 180, JSON.stringify(picture));
      const overlaps = await image.evaluate((element) => {
        const {left, top, width, height} = element.getBoundingClientRect();
        return [[0.5, 0.3], [0.2, 0.5], [0.8, 0.5], [0.5, 0.8]].some(([u, v]) => document.elementFromPoint(left + u * width, top + v * height) !== element);
      });
      assert.equal(overlaps, false, 'something covers the head');
      assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), true);

      await leftOnRight(page).check();
      assert.deepEqual(await letters(page), ['R', 'L']);
      for (let i = 0; i < 2; ++i) await page.getByRole('button', {name: 'Turn left by 90°'}).click();
      await until(async () => {
        const turned = await sides(page);
        return turned.left < 0.75 * turned.right;
      }, 'the ear on the other side');
      assert.deepEqual(await letters(page), ['+x', '−x']);  // asked again
      await page.evaluate(() => scrollTo(0, 0));  // nothing under the sticky header
      assert.deepEqual(await violations(page), []);
      await page.context().close();
    }
    await browser.close();
  });

test('what is cut away is pale in the picture, and the section is done only when all is answered', async () => {
  const browser = await startBrowser(), page = await signIn(browser, service);
  await show(page, '#/new');
  await dropText(page, head(), 'head.obj');
  await until(() => page.locator('.scan-front img').getAttribute('src'), 'the picture');
  await page.getByText(/head\.obj .* is on the server/).waitFor();
  const whole = await sides(page);
  const status = page.locator('.new-step').first().locator('.step-status');
  await until(async () => await status.innerText() === 'Needs a look', 'the open question');
  await page.getByRole('checkbox', {name: 'The service chooses the height'}).uncheck();
  const trim = page.getByRole('textbox', {name: 'Height of the cut above the lowest point'});
  await trim.fill('115');
  await trim.blur();
  await until(async () => {  // at half of 230 mm
    const {pale, solid} = await sides(page);
    return Math.abs(pale / (pale + solid) - 0.5) < 0.05 && pale + solid === whole.pale + whole.solid;
  }, 'the lower half to be pale');
  await leftOnRight(page).check();
  await until(async () => await status.innerText() === 'Completed', 'the end of the section');
  await page.getByRole('radio', {name: 'cm', exact: false}).first().check();
  await until(async () => await status.innerText() === 'Needs a look', 'the wrong unit');
  assert.deepEqual(page.faults, []);
  await browser.close();
});
