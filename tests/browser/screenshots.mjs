// Makes the pictures of the application in docs/: a job of the sample at two sizes, light and dark.
// VACUFORM_BIN=build/tests/bin node tests/browser/screenshots.mjs
import {join} from 'node:path';
import {root, show, signIn, startBrowser, startService} from './drive.mjs';

const service = await startService();
const browser = await startBrowser();
try {
  const {id} = await service.print({reference: 'CASE-12'}, {sheet: {resolution_mm: 3}, print: {dpi: 150}, scan: {left_side: 'minus_x'},
                                                            coils: {decouple: true}});
  for (const colorScheme of ['light', 'dark'])
    for (const [suffix, viewport] of [['', {width: 1280, height: 800}], ['-phone', {width: 390, height: 844}]]) {
      const page = await signIn(browser, service, {colorScheme, viewport});
      await show(page, `#/jobs/${id}`);
      await page.locator('canvas[data-quality="full"], canvas[data-quality="modest"]').first().waitFor();
      await page.locator('canvas').first().evaluate((canvas) => canvas.scrollIntoView({block: 'center'}));
      await page.waitForTimeout(1500);  // the view comes to rest
      await page.screenshot({path: join(root, `docs/app-job-${colorScheme}${suffix}.png`)});
      await page.context().close();
    }
} finally {
  await browser.close();
  await service.stop();
}
