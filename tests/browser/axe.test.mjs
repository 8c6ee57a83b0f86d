// axe finds no violation in any view, in light and in dark, nor in open dialogs and error states.
import assert from 'node:assert/strict';
import {settled, setUp, show, viewsOf, violations} from './drive.mjs';

const test = setUp();

for (const [colorScheme, viewport] of [['light', {width: 1280, height: 800}], ['dark', {width: 390, height: 844}]]) {
  test(`no view has a violation in ${colorScheme} at ${viewport.width} pixels`, {colorScheme, viewport}, async ({page, jobs}) => {
    const found = {};
    for (const [name, hash] of Object.entries(viewsOf(jobs))) {
      await show(page, hash);
      const broken = await violations(page);
      if (broken.length > 0) found[name] = broken;
    }
    assert.deepEqual(found, {});
  });
}

test('open dialogs, menus and folded parts have no violation', async ({page, jobs}) => {
  await show(page, '#/jobs');
  await page.getByRole('button', {name: /^Delete/}).first().click();
  await page.getByRole('dialog').waitFor();
  assert.deepEqual(await violations(page), []);
  await page.keyboard.press('Escape');
  await page.locator('header summary').click();
  assert.deepEqual(await violations(page), []);

  await show(page, '#/admin/tokens');
  await page.getByLabel('Owner').fill('axe');
  await page.getByRole('button', {name: 'Create the token'}).click();
  await page.getByRole('dialog', {name: 'The token of axe'}).waitFor();
  assert.deepEqual(await violations(page), []);

  await show(page, `#/jobs/${jobs.print}`);
  await page.locator('main details').evaluateAll((all) => { for (const details of all) details.open = true; });
  await settled(page);
  assert.deepEqual(await violations(page), []);
});

test('error states have no violation', async ({page}) => {
  await show(page, '#/admin/tokens');
  await page.getByRole('button', {name: 'Create the token'}).click();
  await page.getByText('lower-case letters (a to z), digits and hyphens').first().waitFor();
  assert.deepEqual(await violations(page), []);

  await show(page, '#/jobs/00000000000000000000000000');
  await page.getByRole('alert').first().waitFor();
  assert.deepEqual(await violations(page), []);

  await show(page, '#/help');
  await page.route('**/api/v1/jobs?*', (route) => route.abort());
  await page.evaluate(() => { location.hash = '#/jobs'; });
  await page.getByRole('alert').first().waitFor();
  await settled(page);
  assert.deepEqual(await violations(page), []);
});
