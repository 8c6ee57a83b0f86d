// An array of loops: the coupling of every two, its layers one by one, what to print and to solder.
import assert from 'node:assert/strict';
import {drawn, drawnModestly, settled, setUp, show, until} from './drive.mjs';

const test = setUp();

const file = async (service, id, name) => (await service.ask(`/api/v1/jobs/${id}/artifacts/${name}`)).text();
const minus = (text) => Number(text.replace('−', '-'));

// Of the pixels of the 3D view, how many are of each ink or of the mark around a coil, and where they are on average.
async function inks(page) {
  await drawn(page);
  const png = (await page.locator('.result-view canvas').first().screenshot()).toString('base64');
  const other = await page.context().browser().newPage();  // without the policy of our pages
  const found = await other.evaluate(async (source) => {
    const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${source}`)).blob());
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    const {data} = context.getImageData(0, 0, image.width, image.height), count = {dark: 0, blue: 0, orange: 0, mark: 0}, sum = {};
    for (let i = 0; i < data.length; i += 4) {
      const [r, g, b] = data.subarray(i, i + 3);
      const ink = r < 45 && Math.abs(r - g) < 8 && Math.abs(r - b) < 8 ? 'dark' : b > 70 && b > 1.7 * g && b > 3 * r && r > 10 ? 'blue'
        : r > 80 && r > 1.8 * g && g > 3 * b ? 'orange' : r < 6 && Math.abs(g - 94) < 12 && Math.abs(b - 184) < 16 ? 'mark' : '';
      if (!ink) continue;
      ++count[ink];
      const [x, y] = sum[ink] ?? [0, 0];
      sum[ink] = [x + i / 4 % image.width, y + Math.floor(i / 4 / image.width)];
    }
    const middle = Object.fromEntries(Object.entries(sum).map(([ink, [x, y]]) => [ink, [x / count[ink], y / count[ink]]]));
    return {...count, middle};
  }, png);
  await other.close();
  return found;
}

test('a cell of the coupling table is the k of the report and selects its two loops everywhere', async ({page, service, jobs}) => {
  const {couplings: {coils, k}} = JSON.parse(await file(service, jobs.array, 'report.json'));
  await drawnModestly(page);
  await show(page, `#/jobs/${jobs.array}?mode=with`);
  const before = await inks(page);
  const grid = page.getByRole('grid', {name: 'Coupling of every two loops'});
  assert.equal(await grid.getByRole('row').count(), coils.length + 1);
  assert.deepEqual(await grid.getByRole('columnheader').allInnerTexts(), coils);
  for (const [a, b] of [[1, 0], [0, 1], [5, 3], [coils.length - 1, 2]]) {
    const thousandths = String(Math.round(1000 * k[a][b]) + 0).replace('-', '−');
    const cell = grid.getByRole('gridcell', {name: `${coils[a]} and ${coils[b]}: ${thousandths} thousandths, k = ${k[a][b].toFixed(4).replace('-', '−')}`, exact: true});
    assert.equal(await cell.innerText(), thousandths);
  }
  await grid.getByRole('gridcell', {name: new RegExp(`^${coils[5]} and ${coils[3]}:`)}).click();
  assert.deepEqual((await page.locator('.coil-table tr[aria-selected=true] th button').allInnerTexts()).sort(), [coils[3], coils[5]].sort());
  assert.equal(await grid.locator('[aria-selected=true]').count(), 2, 'the pair stands twice in the table');
  await page.locator('.coupling-reading').getByText(`${coils[5]} and ${coils[3]}: k = `).waitFor();
  const pair = await inks(page);
  assert.ok(pair.mark > before.mark + 800, `marked pixels: ${before.mark}, then ${pair.mark}`);
  await until(() => page.url().includes(`coil=${coils[5]}&and=${coils[3]}`), 'the pair in the address');

  await page.reload();
  await settled(page);
  assert.equal(await grid.locator('[aria-selected=true]').count(), 2);
  // One loop alone is another selection.
  await page.locator(`#row-${coils[3]}`).click();
  assert.equal(await grid.locator('[aria-selected=true]').count(), 0);
  assert.deepEqual(await page.locator('.coil-table tr[aria-selected=true] th button').allInnerTexts(), [coils[3]]);
  assert.deepEqual(page.faults, []);
});

test('a loop that gaps and bridges interrupt is known where it lies, on either face', async ({page, service, jobs}) => {
  const {circuits: {coils}} = JSON.parse(await file(service, jobs.array, 'report.json'));
  await show(page, `#/jobs/${jobs.array}?mode=with`);
  await drawn(page);
  for (const face of ['outer', 'inner']) {
    for (const {id} of coils.filter((coil) => coil.face === face).slice(0, 3)) {
      await page.locator(`#row-${id}`).click();  // turns the view to its middle
      await settled(page);
      await page.locator('.result-view canvas').first().press('i');
      assert.match(await page.locator('.readout div').filter({hasText: 'Coil'}).first().innerText(), new RegExp(`\\b${id}(?!\\d)`), id);
    }
  }
  assert.deepEqual(page.faults, []);
});

test('the coupling table is read and used with the keyboard', async ({page, service, jobs}) => {
  const {couplings: {coils}} = JSON.parse(await file(service, jobs.array, 'report.json'));
  await show(page, `#/jobs/${jobs.array}`);
  const grid = page.getByRole('grid');
  assert.equal(await grid.locator('[tabindex="0"]').count(), 1, 'Tab stops once');
  await grid.getByRole('gridcell', {name: new RegExp(`^${coils[1]} and ${coils[0]}:`)}).focus();
  const reading = page.locator('.coupling-reading');
  for (const [key, a, b] of [['ArrowRight', 1, 2], ['ArrowDown', 3, 2], ['ArrowLeft', 3, 1], ['Home', 3, 0], ['ArrowUp', 2, 0]]) {
    await page.keyboard.press(key);
    assert.match(await reading.innerText(), new RegExp(`^${coils[a]} and ${coils[b]}: k = `), key);
    assert.ok(await page.evaluate(() => document.activeElement.getAttribute('aria-label')).then((label) => label.startsWith(`${coils[a]} and ${coils[b]}`)), key);
  }
  await page.keyboard.press('Enter');
  assert.equal(await grid.locator('[aria-selected=true]').count(), 2);
  assert.ok(await page.evaluate(() => document.activeElement.getAttribute('role') === 'gridcell'), 'the focus stays');
  await page.keyboard.press(' ');
  assert.equal(await grid.locator('[aria-selected=true]').count(), 0);
  assert.deepEqual(page.faults, []);
});

test('a layer is hidden on the part and on the sheet, the others stay, and a reload keeps it', async ({page, jobs}) => {
  await drawnModestly(page);
  await show(page, `#/jobs/${jobs.array}?mode=with`);
  const all = await inks(page);
  assert.ok(all.dark > 300 && all.blue > 300, JSON.stringify(all));
  const box = (panel, name) => page.locator(`#panel-${panel}`).getByRole('checkbox', {name});
  const inner = /^Step \d: conductive ink, inner face$/;
  await box('part', inner).uncheck();
  await until(() => page.url().includes('hide=print-reverse'), 'the layer in the address');
  const outer = await inks(page);
  assert.ok(outer.blue < all.blue / 20, `blue: ${all.blue}, then ${outer.blue}`);
  assert.ok(outer.dark > 0.9 * all.dark, `dark: ${all.dark}, then ${outer.dark}`);

  await page.getByRole('tab', {name: 'Print sheet'}).click();
  const groups = page.locator('.sheet-layers > [data-layer]'), shown = (name) => page.locator(`.sheet-layers > [data-layer=${name}]`);
  // of a layer, on the sheet
  const place = (name) => shown(name).evaluate((group) => {
    const [layer, sheet] = [group, group.ownerSVGElement].map((one) => one.getBoundingClientRect());
    return [layer.left - sheet.left, layer.top - sheet.top, layer.width, layer.height].map((pixels) => Math.round(10 * pixels));
  });
  await groups.first().waitFor({state: 'attached'});
  assert.equal(await groups.count(), await page.locator('#panel-sheet').getByRole('checkbox').count());
  assert.equal(await box('sheet', inner).isChecked(), false);
  assert.equal(await shown('print-reverse').isVisible(), false);
  const first = await place('print');
  await box('sheet', inner).check();
  assert.ok(await shown('print-reverse').isVisible());
  assert.deepEqual(await place('print'), first);
  // The face that the marks belong to: the others do not move, and are not mirrored.
  const reverse = await place('print-reverse');
  await box('sheet', /^Step 1: conductive ink, outer face$/).uncheck();
  assert.equal(await shown('print').isVisible(), false);
  assert.deepEqual(await place('print-reverse'), reverse);

  await page.reload();
  await settled(page);
  await groups.first().waitFor({state: 'attached'});
  assert.equal(await shown('print').isVisible(), false);
  assert.deepEqual(await place('print-reverse'), reverse);
  await page.getByRole('tab', {name: 'Formed part'}).click();
  assert.equal(await box('part', /^Step 1:/).isChecked(), false);
  const kept = await inks(page);
  assert.ok(kept.blue > 0.9 * all.blue && kept.dark < all.dark, `${JSON.stringify(all)}, then ${JSON.stringify(kept)}`);
  assert.deepEqual(page.faults, []);
});

test('what is drawn of the layers lies where the print has it on the part', async ({page, jobs}) => {
  await drawnModestly(page);
  await show(page, `#/jobs/${jobs.array}?mode=with`);
  const all = await inks(page);
  // A layer with little ink is left out: the picture of the file is replaced by one that is drawn here.
  await page.locator('#panel-part').getByRole('checkbox', {name: /dielectric ink, inner face$/}).uncheck();
  const drawnHere = await inks(page);
  for (const ink of ['dark', 'blue', 'orange']) {
    assert.ok(Math.abs(drawnHere[ink] - all[ink]) < 0.3 * all[ink] + 30, `${ink}: ${all[ink]} of the file, ${drawnHere[ink]} drawn`);
    drawnHere.middle[ink].forEach((at, k) => assert.ok(Math.abs(at - all.middle[ink][k]) < 4, `${ink}: at ${all.middle[ink]}, drawn at ${drawnHere.middle[ink]}`));
  }
  await page.locator('#panel-part').getByRole('checkbox', {name: /dielectric ink, inner face$/}).check();
  assert.deepEqual(await inks(page), all);
});

test('the work list has the steps of the print and the rows of coils.csv, and shows a gap on the part', async ({page, service, jobs}) => {
  await show(page, `#/jobs/${jobs.array}?tab=build`);
  const {artifacts} = await service.json(`/api/v1/jobs/${jobs.array}`);
  const steps = await page.locator('.build-steps > li').allInnerTexts(), printed = steps.filter((step) => step.startsWith('Step '));
  const pages = artifacts.map(({name}) => name).filter((name) => /^print.*\.svg$/.test(name));
  assert.equal(printed.length, pages.length);
  for (const name of pages) {  // the legend of each page says the same
    const [, number, count, ink] = /step (\d) of (\d): ([a-z, ]+)/.exec(await file(service, jobs.array, name));
    const face = /inner face|outer face/.exec((await file(service, jobs.array, name)).split('mark-legend')[1])[0];
    assert.equal(Number(count), pages.length);
    const step = printed[number - 1];
    assert.ok(step.startsWith(`Step ${number}: ${ink.trim()}, ${face}`), `${name}: ${step}`);
    assert.match(step, new RegExp(`Page ${number} of print\\.pdf`));
    assert.ok(step.includes(name.replace(name === 'print.svg' ? /$/ : '.svg', name === 'print.svg' ? '' : '.pdf')), step);
    assert.equal(/Mirrored/.test(step), face === 'inner face');
    assert.match(step, /Let it dry/);
  }
  const turned = steps.findIndex((step) => step.startsWith('Turn the sheet over'));
  assert.ok(turned > 0 && /inner face/.test(steps[turned + 1]) && /outer face/.test(steps[turned - 1]));
  assert.match(steps.at(-1), /^Solder/);

  const rows = (await file(service, jobs.array, 'coils.csv')).trim().split('\r\n').slice(1).map((line) => line.split(','));
  const table = page.getByRole('table', {name: 'What to solder'}), shown = table.locator('tbody tr');
  assert.equal(await shown.count(), rows.length);
  const cells = await shown.evaluateAll((all) => all.map((row) => [...row.cells].map((cell) => cell.textContent)));
  for (const [number, loop, , kind, wanted, value, , x, y, z] of rows) {
    const row = cells.find((one) => one[1] === number);
    assert.equal(row[2], loop);
    assert.equal(row[4].startsWith('Port'), kind === 'port', number);
    assert.deepEqual(row.slice(5, 10).map((text) => minus(text === '–' ? '0' : text.replaceAll(',', ''))), [value, wanted, x, y, z].map(Number), number);
  }
  const {circuits: {electrical}} = JSON.parse(await file(service, jobs.array, 'report.json'));
  await page.getByText(`Values at ${electrical.frequency_mhz} MHz.`).waitFor();

  await table.getByRole('button', {name: 'Show gap 3 on the part', exact: true}).click();
  assert.equal(await page.getByRole('tab', {name: 'Formed part'}).getAttribute('aria-selected'), 'true');
  await page.locator('.readout dd').first().waitFor();
  // The place that is read is where the number of the gap is printed.
  const read = await page.locator('.readout div').filter({hasText: 'On the flat sheet, mm'}).locator('dd').innerText();
  const [x, y] = /translate\(([-\d.]+),([-\d.]+)\)[^>]*>3</.exec((await file(service, jobs.array, 'print.svg')).split('mark-gap-numbers')[1]).slice(1).map(Number);
  const [s, up] = read.split(';').map(Number);
  assert.ok(Math.hypot(s - x, up + y) < 6, `${read}, and the number at ${x}; ${-y}`);
  assert.deepEqual(page.faults, []);
});

test('the work list is printed alone, without buttons, with boxes to tick and the name of the job', {colorScheme: 'dark'}, async ({page, jobs}) => {
  await show(page, `#/jobs/${jobs.array}?tab=build`);
  await page.evaluate(() => { window.print = () => { window.printed = true; }; });
  await page.getByRole('button', {name: 'Print the work list'}).click();
  assert.ok(await page.evaluate(() => window.printed));
  await page.emulateMedia({media: 'print'});
  const paper = page.locator('.on-paper');
  assert.ok(await paper.isVisible());
  assert.equal(await page.locator('vf-shell').isVisible(), false);
  const text = await paper.innerText();
  assert.match(text, /CASE-9/);
  assert.match(text, /Step 1: conductive ink/);
  assert.match(text, /Capacitor/);
  assert.equal(await paper.locator('button:visible').count(), 0);
  assert.ok(await paper.locator('.tick-box:visible').count() > 10);
  // No text has a colour of the dark theme.
  const light = await paper.locator('*').evaluateAll((all) => all.filter((one) => Math.max(...getComputedStyle(one).color.match(/\d+/g).slice(0, 3)) > 130)
    .map((one) => one.outerHTML.slice(0, 80)));
  assert.deepEqual(light, []);
  await page.evaluate(() => dispatchEvent(new Event('afterprint')));
  await page.emulateMedia({media: 'screen'});
  assert.equal(await paper.count(), 0);
  assert.ok(await page.locator('vf-shell').isVisible());
  assert.deepEqual(page.faults, []);
});

test('how loops are parted is chosen by pictures with words, and the choice is in the draft', async ({page}) => {
  await show(page, '#/new');
  const group = page.getByRole('group', {name: 'Crossings'}).first(), radios = group.getByRole('radio');
  assert.equal(await radios.count(), 3);
  assert.equal(await group.locator('svg.choice-picture').count(), 3);
  assert.ok(await group.getByRole('radio', {name: 'One layer'}).isChecked());
  for (const radio of await radios.all())
    assert.ok((await radio.evaluate((input) => document.getElementById(input.getAttribute('aria-describedby')).textContent)).length > 20);
  await group.getByRole('radio', {name: 'One layer'}).focus();
  await page.keyboard.press('ArrowRight');
  assert.ok(await group.getByRole('radio', {name: 'Two faces of the sheet'}).isChecked());
  await group.locator('svg.choice-picture').last().click();
  assert.ok(await group.getByRole('radio', {name: 'Bridges'}).isChecked());
  await page.reload();
  await settled(page);
  assert.ok(await group.getByRole('radio', {name: 'Bridges'}).isChecked());
  await group.getByRole('button', {name: /^Reset/}).click();
  assert.ok(await group.getByRole('radio', {name: 'One layer'}).isChecked());
  assert.deepEqual(page.faults, []);
});

test('a print of one layer has no list of layers', async ({page, jobs}) => {
  await show(page, `#/jobs/${jobs.print}?hide=print`);
  await drawn(page);
  assert.equal(await page.getByText('Layers of the print', {exact: true}).count(), 0);
  assert.ok((await inks(page)).dark > 100, 'and nothing of it is hidden');
});
