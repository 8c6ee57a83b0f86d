// Everything works with the keyboard: Tab reaches all that can be used, never stays, and always shows where it is.
import assert from 'node:assert/strict';
import {checked, jobShown, leftOnRight, sample, setUp, show, viewsOf} from './drive.mjs';

const test = setUp();

// Numbers all that Tab should reach, and says what each is.
const numberAll = () => {
  const all = [...document.querySelectorAll('a[href], button, input, select, textarea, summary, [tabindex]')].filter((element) =>
    element.tabIndex >= 0 && !element.disabled && element.type !== 'hidden' && !element.closest('[inert]') &&
    element.checkVisibility({visibilityProperty: true}));
  const groups = new Set();
  const reachable = all.filter((element) => {
    if (element.type !== 'radio') return true;
    const checked = element.form?.querySelector(`input[type=radio][name="${element.name}"]:checked`) ??
      document.querySelector(`input[type=radio][name="${element.name}"]:checked`);
    if (checked) return checked === element;
    if (groups.has(element.name)) return false;
    groups.add(element.name);
    return true;
  });
  reachable.forEach((element, i) => { element.reachable = i; });
  return reachable.map((element) => `${element.tagName.toLowerCase()} "${(element.getAttribute('aria-label') ??
    element.labels?.[0]?.textContent ?? element.textContent ?? '').trim().slice(0, 60)}"`);
};

// Where the focus is: its number, and what is wrong with how it is shown.
const look = () => {
  const element = document.activeElement;
  if (!element || element === document.body) return {number: -1, name: 'the page', fault: ''};
  const style = getComputedStyle(element);
  const ring = (style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 2) || style.boxShadow !== 'none';
  // Its middle, or the middle of one of its quarters, is in the window and above everything else.
  const box = element.getBoundingClientRect();
  const uncovered = [[0.5, 0.5], [0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]].some(([across, down]) => {
    const top = document.elementFromPoint(box.left + box.width * across, box.top + box.height * down);
    return top && (element.contains(top) || top.contains(element) || top.closest('label')?.control === element);
  });
  const name = `${element.tagName.toLowerCase()} "${(element.getAttribute('aria-label') ?? element.labels?.[0]?.textContent ??
    element.textContent ?? '').trim().slice(0, 60)}"`;
  return {number: element.reachable ?? -2, name,
          fault: !ring ? 'shows no ring' : !uncovered ? 'is covered, or outside of the window' : ''};
};

const noRing = 'shows no ring';
// Whether the focused element looks different without the focus: a slider shows the ring on its thumb.
async function looksDifferent(page) {
  const element = (await page.evaluateHandle(() => document.activeElement)).asElement();
  const focused = await element.screenshot();
  await element.evaluate((one) => one.blur());
  const blurred = await element.screenshot();
  await element.focus();
  return !focused.equals(blurred);
}

const mostStops = 5;  // a field for a date has day, month, year and a button

async function walk(page) {
  const names = await page.evaluate(numberAll);
  const visited = new Set();
  const faults = new Set();
  let last = '';
  let repeats = 0;
  for (let press = 0; press < 2 * names.length + 30; ++press) {
    await page.keyboard.press('Tab');
    const {number, name, fault} = await page.evaluate(look);
    if (fault && !(fault === noRing && await looksDifferent(page))) faults.add(`${name} ${fault}`);
    const place = `${number} ${name}`;
    repeats = place === last ? repeats + 1 : 0;
    last = place;
    if (repeats >= mostStops) {
      faults.add(`${name} keeps the focus`);
      break;
    }
    if (number >= 0) visited.add(number);
    if (visited.size === names.length) break;
  }
  const missed = names.filter((_, i) => !visited.has(i)).map((name) => `${name} is not reached`);
  return [...faults, ...missed];
}

for (const [name, viewport] of [['a wide', {width: 1280, height: 800}], ['a narrow', {width: 390, height: 844}]]) {
  test(`Tab reaches everything in every view of ${name} window, and shows where it is`, {viewport}, async ({page, jobs}) => {
    const found = {};
    for (const [view, hash] of Object.entries(viewsOf(jobs))) {
      await show(page, hash);
      await page.evaluate(() => document.activeElement?.blur());
      const faults = await walk(page);
      if (faults.length > 0) found[view] = faults;
    }
    assert.deepEqual(found, {});
  });
}

test('the first Tab offers to skip to the content', async ({page}) => {
  await show(page, '#/help');
  await page.keyboard.press('Tab');
  const skip = page.getByRole('link', {name: 'Skip to the content'});
  assert.ok(await skip.evaluate((link) => link === document.activeElement && link.getBoundingClientRect().top >= 0));
  await page.keyboard.press('Enter');
  assert.equal(await page.evaluate(() => document.activeElement.id), 'main');
});

test('a dialog takes the focus, Escape closes it, and the focus returns', async ({page}) => {
  await show(page, '#/jobs');
  const button = page.getByRole('button', {name: /^Delete/}).first();
  await button.focus();
  await page.keyboard.press('Enter');
  const dialog = page.getByRole('dialog');
  await dialog.waitFor();
  assert.ok(await dialog.evaluate((element) => element.contains(document.activeElement)));
  await page.keyboard.press('Escape');
  await dialog.waitFor({state: 'detached'});
  assert.ok(await button.evaluate((element) => element === document.activeElement));
});

// Presses Tab until an element with that text has the focus.
async function tabTo(page, text) {
  for (let press = 0; press < 300; ++press) {
    await page.keyboard.press('Tab');
    const name = await page.evaluate(() => {
      const element = document.activeElement;
      return element.labels?.[0]?.textContent || element.getAttribute('aria-label') || element.textContent || '';
    });
    if (text.test(name.trim())) return;
  }
  assert.fail(`Tab does not reach ${text}`);
}

test('a job is prepared and started with the keyboard alone', async ({page, service}) => {
  const {scan, pattern} = sample();
  const chooseByKey = async (file) => {
    const [chooser] = await Promise.all([page.waitForEvent('filechooser'), page.keyboard.press('Enter')]);
    await chooser.setFiles(file);
  };
  await show(page, '#/new');
  await tabTo(page, /^Choose a scan$/);
  await chooseByKey(scan);
  await leftOnRight(page).waitFor();
  await tabTo(page, /^(Not checked yet|On the (right|left) in the picture)/);
  for (let i = 0; i < 3 && !(await leftOnRight(page).isChecked()); ++i)
    await page.keyboard.press('ArrowDown');
  await tabTo(page, /^Choose a drawing$/);
  await chooseByKey(pattern);
  await page.getByAltText(/^The pattern pattern\.svg laid flat/).waitFor();
  await tabTo(page, /^Reference$/);
  await page.keyboard.type('CASE-14');
  await checked(page);
  await tabTo(page, /^Start the job$/);
  await page.keyboard.press('Enter');
  const job = await service.json(`/api/v1/jobs/${await jobShown(page)}`);
  assert.equal(job.reference, 'CASE-14');
  assert.equal(job.settings.scan.left_side, 'minus_x');
});
