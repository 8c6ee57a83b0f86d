// No view breaks the content security policy or Trusted Types, and none writes an error to the console.
import assert from 'node:assert/strict';
import {setUp, show, viewsOf} from './drive.mjs';

const test = setUp();

test('the application comes with a policy that allows only its own files', async ({page}) => {
  const answer = await page.goto('/');
  const policy = answer.headers()['content-security-policy'];
  for (const part of ["default-src 'none'", "script-src 'self'", "require-trusted-types-for 'script'", "frame-ancestors 'none'"])
    assert.ok(policy.split(/;\s*/).includes(part), `${part} is missing in: ${policy}`);
  assert.doesNotMatch(policy, /unsafe|\*|https?:/);
});

test('no view causes a report, an error or a failed request', async ({page, jobs}) => {
  const found = {};
  for (const [name, hash] of Object.entries(viewsOf(jobs))) {
    page.faults.length = 0;
    await show(page, hash);
    if (page.faults.length > 0) found[name] = [...page.faults];
  }
  assert.deepEqual(found, {});
});

test('a script in the page, a style attribute and text parsed as HTML are refused and reported', async ({page}) => {
  await show(page, '#/help');
  page.faults.length = 0;
  await page.evaluate(() => {
    const script = document.createElement('script');
    script.append('window.ranInline = true');
    document.body.append(script);
  }).catch(() => {});
  await page.evaluate(() => { document.body.setAttribute('style', 'color: red'); });
  const parsed = await page.evaluate(() => {
    try {
      document.createElement('div').innerHTML = '<b>bold</b>';
      return true;
    } catch {
      return false;
    }
  });
  assert.equal(parsed, false);
  assert.equal(await page.evaluate(() => window.ranInline), undefined);
  for (const directive of ['style-src-attr', 'require-trusted-types-for'])
    assert.ok(page.faults.some((fault) => fault.startsWith(`CSP: ${directive}`)), `${directive}: ${page.faults.join('\n')}`);
});
