// A scan is placed by hand: three landmarks straighten it, and drags and keys turn it.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {drawn, drop, sample, show, signIn, startBrowser, startService, until, violations} from './drive.mjs';

let service;
let browser;
before(async () => {
  browser = await startBrowser();
  service = await startService();
});
after(async () => { await browser?.close(); await service?.stop(); });

const canvasOf = (page) => page.locator('.scan-stage canvas');
const field = (page, turn) => page.locator(`#scan-section-${turn}_deg`);
const numbers = async (page) => Promise.all(['roll', 'pitch', 'yaw'].map(async (turn) => Number(await field(page, turn).inputValue())));
const settings = (page) => page.evaluate(() => JSON.parse(sessionStorage.getItem('vacuform.draft')).form.settings.scan ?? {});
async function type(page, [roll, pitch, yaw]) {
  for (const [turn, value] of Object.entries({roll, pitch, yaw})) {
    await field(page, turn).fill(String(value));
    await field(page, turn).press('Enter');
  }
}
async function open(options = {}) {
  const page = await signIn(browser, service, options);
  await show(page, '#/new');
  await drop(page, sample().scan);
  await drawn(page);
  await page.getByText('Tilt, mirror, all axes').click();
  return page;
}
// Marks what is at the centre of the view from the front and from both sides: level, with the nose in front.
async function mark(page, views = ['1', '3', '4']) {
  const canvas = canvasOf(page);
  for (const [i, name] of ['Bridge of the nose', 'Left ear', 'Right ear'].entries()) {
    await canvas.focus();
    await page.keyboard.press(views[i]);
    await page.keyboard.press('m');
    await page.getByRole('button', {name: `${name}: set`}).waitFor();
  }
}
const close = (found, wanted, within = 1) => found.forEach((value, i) =>
  assert.ok(Math.abs(value - wanted[i]) <= within, `${found}, not ${wanted}`));

test('three landmarks straighten a tilted scan, with the keys alone', async () => {
  const page = await open();
  const tilted = [12, -8, 25];
  await type(page, tilted);
  await mark(page);
  const straighten = page.getByRole('button', {name: 'Straighten the head'});
  assert.ok(await straighten.evaluate((button) => button === document.activeElement));
  await type(page, [0, 0, 0]);  // the marks stay where they are on the scan
  await straighten.focus();
  await page.keyboard.press('Enter');
  close(await numbers(page), tilted);
  const {left_side, up, front} = await settings(page);
  assert.equal(left_side, 'minus_x');
  assert.equal(front, '+y');
  assert.equal(up, '+z');
  assert.ok(await page.getByRole('radio', {name: 'On the right in the picture, at −x'}).isChecked());
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('clicks set landmarks, and swapped ears give the warning of a mirror image', async () => {
  const page = await open();
  const canvas = canvasOf(page);
  await page.getByRole('button', {name: 'Bridge of the nose: not set'}).click();
  for (const [view, name] of [['Front', 'Bridge of the nose'], ['Side +x', 'Left ear'], ['Side −x', 'Right ear']]) {
    const button = page.getByRole('button', {name: `${name}: not set`});
    assert.equal(await button.getAttribute('aria-pressed'), 'true');
    await page.getByRole('button', {name: view, exact: true}).click();
    await drawn(page);
    await canvas.click();
    await page.getByRole('button', {name: `${name}: set`}).waitFor();
  }
  await page.getByText('you swapped two places').waitFor();
  await page.getByRole('button', {name: 'Straighten the head'}).click();
  close(await numbers(page), [0, 0, 0]);
  assert.equal((await settings(page)).left_side, 'plus_x');
  await page.getByText('A face that looks at you has its left ear on the right').waitFor();

  // three places that no head has
  await page.getByRole('button', {name: 'Left ear: set'}).click();
  await page.getByRole('button', {name: "Patient's right", exact: true}).click();
  await drawn(page);
  await canvas.click();
  await page.getByText('the ears not 40 to 300 mm apart').waitFor();
  assert.equal(await page.getByRole('button', {name: 'Straighten the head'}).count(), 0);

  await page.getByRole('button', {name: 'Turn the scan'}).click();
  assert.deepEqual(await violations(page), []);

  // another file forgets them
  await drop(page, sample().scan, 'other.stl');
  await page.getByRole('button', {name: 'Left ear: not set'}).waitFor();
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a mirror image straightens like a scan, once it is mirrored', async () => {
  const page = await open();
  await type(page, [10, 5, 20]);
  await mark(page, ['1', '4', '3']);  // the ears at the other side: a mirror image
  await page.getByRole('button', {name: 'Straighten the head'}).click();
  await page.getByRole('button', {name: 'Mirror the scan'}).click();
  close(await numbers(page), [10, -5, -20]);
  assert.equal((await settings(page)).left_side, 'minus_x');
  await page.context().close();
});

test('drags and arrow keys turn the scan, one step of undo each', async () => {
  const page = await open();
  const canvas = canvasOf(page), turn = page.getByRole('button', {name: 'Turn the scan'});
  await turn.click();
  assert.equal(await turn.getAttribute('aria-pressed'), 'true');
  await page.getByRole('button', {name: 'Front', exact: true}).click();
  const drag = async (dx, dy) => {
    await canvas.scrollIntoViewIfNeeded();
    const box = await canvas.boundingBox(), [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + dx / 2, y + dy / 2, {steps: 4});
    await page.mouse.move(x + dx, y + dy, {steps: 4});
  };
  await drag(60, 4);
  const [, , during] = await numbers(page);
  assert.ok(during > 5, `yaw ${during}`);
  assert.equal((await settings(page)).yaw_deg, undefined);  // not yet in the history
  await page.mouse.up();
  assert.deepEqual(await numbers(page), [0, 0, during]);
  await until(async () => (await settings(page)).yaw_deg === during, 'the drag to count');
  await page.locator('#new-undo').click();
  assert.deepEqual(await numbers(page), [0, 0, 0]);

  // Down tilts the face down: about x from the front, with the sign that the order of turns asks for; Shift snaps.
  await page.keyboard.down('Shift');
  await drag(3, 60);
  await page.mouse.up();
  await page.keyboard.up('Shift');
  const [roll, pitch, yaw] = await numbers(page);
  assert.ok(roll < 0 && roll % 5 === 0, `roll ${roll}`);
  assert.deepEqual([pitch, yaw], [0, 0]);

  await canvas.focus();
  await page.keyboard.press('3');  // from -x
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('Shift+ArrowRight');
  await page.keyboard.press('ArrowUp');
  assert.deepEqual(await numbers(page), [roll, 5, 6]);
  await page.locator('#new-undo').click();
  await page.locator('#new-undo').click();
  assert.deepEqual(await numbers(page), [roll, 0, 5]);

  await canvas.focus();
  await page.keyboard.press('Escape');
  assert.equal(await turn.getAttribute('aria-pressed'), 'false');
  assert.ok(await canvas.evaluate((element) => element !== document.activeElement));
  await canvas.focus();
  await page.keyboard.press('ArrowRight');
  assert.deepEqual(await numbers(page), [roll, 0, 5]);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a finger turns the scan', async () => {
  const page = await open({hasTouch: true, isMobile: true, viewport: {width: 390, height: 844}});
  const canvas = canvasOf(page);
  await page.getByRole('button', {name: 'Turn the scan'}).tap();
  assert.equal(await canvas.evaluate((element) => element.style.touchAction), 'none');
  const box = await canvas.boundingBox(), [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const session = await page.context().newCDPSession(page);
  const touch = (type, dx) => session.send('Input.dispatchTouchEvent', {type, touchPoints: type === 'touchEnd' ? [] : [{x: x + dx, y}]});
  await touch('touchStart', 0);
  for (const dx of [-10, -20, -40, -60]) await touch('touchMove', dx);
  await touch('touchEnd', 0);
  await until(async () => (await settings(page)).yaw_deg < -5, 'the scan to turn');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a finding of the inspection turns the 3D view to its place', async () => {
  const page = await open();
  await page.getByLabel('The service chooses the height').uncheck();
  await page.locator('#scan-section-trim_mm').fill('5');  // far below the undercuts, and too high a mold for its window
  await page.locator('#scan-section-trim_mm').press('Enter');
  const finding = page.locator('.findings li').filter({hasText: 'y = -90'});
  await until(async () => {
    const again = page.locator('#inspect-again');
    if (await again.isVisible()) await again.click();
    return finding.isVisible();
  }, 'the finding');
  await finding.getByRole('button').first().click();
  await page.locator('.scan-stage [role=status]').filter({hasText: 'You look from the back'}).waitFor();
  assert.ok(await canvasOf(page).isVisible());
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

// How dark the picture of the canvas is on average, in its upper and its lower half.
async function darkness(picture) {
  const page = await browser.newPage();  // without a policy
  const halves = await page.evaluate(async (source) => {
    const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${source}`)).blob());
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    return [0, 1].map((half) => {
      const {data} = context.getImageData(0, half * image.height / 2, image.width, image.height / 2);
      let sum = 0;
      for (let i = 0; i < data.length; i += 4) sum += 255 - data[i];
      return sum / (data.length / 4);
    });
  }, picture.toString('base64'));
  await page.close();
  return halves;
}

test('a drawing is seen on the head at once, and moves with its offset', async () => {
  const page = await open();
  const look = async () => {
    await page.getByRole('button', {name: 'Above', exact: true}).click();
    await drawn(page);
    return darkness(await canvasOf(page).screenshot());
  };
  const bare = await look();
  await drop(page, sample().pattern);
  await page.getByText('The drawing is shown about where it comes to lie.').waitFor();
  const inked = await look();
  assert.ok(inked[0] + inked[1] > bare[0] + bare[1] + 1, `${bare} without, ${inked} with the drawing`);
  await page.getByLabel('Up (v)').fill('60');  // to the face, which is at the top of the picture
  await page.getByLabel('Up (v)').press('Enter');
  await page.waitForTimeout(300);
  const moved = await look();
  assert.ok(moved[0] - moved[1] > inked[0] - inked[1] + 1, `${inked} before, ${moved} after the move`);
  await page.getByRole('button', {name: 'Clear all'}).click();
  await page.getByRole('dialog').getByRole('button', {name: 'Clear all'}).click();
  await page.getByText('The drawing is shown about where it comes to lie.').waitFor({state: 'detached'});
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
