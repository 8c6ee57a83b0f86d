// What the tests of the web application share: the real server with a real worker, Debian's Chromium, and pages that
// collect every fault. The programs are in VACUFORM_BIN.
import assert from 'node:assert/strict';
import {execFileSync, spawn} from 'node:child_process';
import {cpSync, existsSync, mkdtempSync, openSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {after, before, test} from 'node:test';
import {fileURLToPath} from 'node:url';

export const root = join(dirname(fileURLToPath(import.meta.url)), '../..');
export const web = join(root, 'web');
const fromWeb = createRequire(join(web, 'package.json'));
const {chromium} = fromWeb('playwright-core');
export const esbuild = fromWeb('esbuild');
const axeSource = () => readFileSync(fromWeb.resolve('axe-core/axe.min.js'), 'utf8');

const bin = process.env.VACUFORM_BIN ?? join(root, 'build/tests/bin');
const patience = 120_000;  // milliseconds that any one step may take on a busy machine

for (const signal of ['SIGINT', 'SIGTERM']) process.once(signal, () => process.exit(1));  // with what belongs to an exit

export const pause = (milliseconds) => new Promise((resolve) => { setTimeout(resolve, milliseconds); });

// Asks until the answer is true, and returns it.
export async function until(condition, what) {
  const end = Date.now() + patience;
  for (;;) {
    const value = await condition();
    if (value) return value;
    if (Date.now() > end) throw new Error(`after ${patience / 1000} s still waiting for ${what}`);
    await pause(50);
  }
}

// Settings that make a job in seconds.
export const quick = {sheet: {resolution_mm: 6}, print: {dpi: 100}};

// The real server on a free port with its data in a temporary folder.
// `workers`: that many real workers. `options`: more options of the server. `copyOf`: a data folder to begin with.
export async function startService({workers = 1, options = [], copyOf} = {}) {
  const folder = mkdtempSync(join(tmpdir(), 'vacuform-browser-'));
  const data = join(folder, 'data');
  if (copyOf) cpSync(copyOf, data, {recursive: true});
  const log = join(folder, 'server.log');
  const programs = [];
  const run = (program, words) => {
    const out = openSync(log, 'a');
    const child = spawn(program, words, {stdio: ['ignore', out, out], detached: true});
    child.unref();  // a test that fails early ends all the same
    programs.push(child);
    return child;
  };
  const end = (child, signal) => {
    try {
      process.kill(-child.pid, signal);  // with its children
    } catch {
      // it has ended
    }
  };
  process.once('exit', () => {
    for (const child of programs) end(child, 'SIGKILL');
    rmSync(folder, {recursive: true, force: true});
  });
  const portFile = join(folder, 'port');
  const server = run(join(bin, 'vacuform-server'), ['--listen', '127.0.0.1:0', '--port-file', portFile, '--data', data,
                                                    '--workers', String(workers), ...options]);
  const port = await until(() => {
    assert.equal(server.exitCode, null, `the server has ended:\n${readFileSync(log, 'utf8')}`);
    return existsSync(portFile) && Number(readFileSync(portFile, 'utf8'));
  }, 'the server');
  let url = `http://127.0.0.1:${port}`;
  if (process.env.VACUFORM_WEB_SERVE) {  // a folder like web/: its sources as they are now, for developing the application
    const free = await freePort();
    const serve = run(process.execPath, [join(process.env.VACUFORM_WEB_SERVE, 'serve.mjs'), '--server', url, '--port', String(free), '--out',
                                         join(folder, 'serve')]);
    url = `http://127.0.0.1:${free}`;
    await until(() => {
      assert.equal(serve.exitCode, null, `serve.mjs has ended:\n${readFileSync(log, 'utf8')}`);
      return fetch(url, {redirect: 'manual'}).then((answer) => answer.headers.has('Content-Security-Policy'), () => false);
    }, 'serve.mjs');
  }
  const token = readFileSync(join(data, 'admin-token'), 'utf8').trim();

  const service = {
    url, port: Number(new URL(url).port), folder, data, token,
    async ask(path, init = {}) {
      const answer = await fetch(url + path, {...init, headers: {Authorization: `Bearer ${token}`, ...init.headers}});
      assert.ok(answer.ok, `${init.method ?? 'GET'} ${path}: ${answer.status} ${answer.ok ? '' : await answer.text()}`);
      return answer;
    },
    json: async (path, init) => (await service.ask(path, init)).json(),
    async makeToken(owner, scopes) {
      const made = await service.json('/api/v1/tokens', {method: 'POST', body: JSON.stringify({owner, scopes}),
                                                         headers: {'Content-Type': 'application/json'}});
      return made.token;
    },
    // The id of a new job of the sample; `fields`: more fields of the form.
    async submit(fields = {}, settings = quick) {
      const {scan, pattern} = sample();
      const form = new FormData();
      if (fields.scan === undefined) form.append('scan', new Blob([readFileSync(scan)]), 'head.stl');
      if (fields.kind === undefined || fields.kind === 'print' && fields.pattern === undefined) form.append('pattern', new Blob([readFileSync(pattern)]), 'pattern.svg');
      form.append('settings', JSON.stringify(settings));
      for (const [name, value] of Object.entries(fields)) form.append(name, ...[value].flat());  // a file with its name, or a text
      return (await service.json('/api/v1/jobs', {method: 'POST', body: form})).id;
    },
    ended: (id) => until(async () => {
      const job = await service.json(`/api/v1/jobs/${id}`);
      return ['succeeded', 'failed', 'cancelled'].includes(job.state) && job;
    }, `the end of the job ${id}`),
    // A job of the sample that has succeeded.
    async print(fields, settings) {
      const job = await service.ended(await service.submit(fields, settings));
      assert.equal(job.state, 'succeeded', JSON.stringify(job.problem));
      return job;
    },
    log: () => readFileSync(log, 'utf8'),
    async stop({keep = false} = {}) {
      for (const program of programs.reverse()) {
        if (program.exitCode !== null) continue;
        const ended = new Promise((resolve) => { program.once('exit', resolve); });
        program.ref();  // or Node ends here where nothing else is left to do
        end(program, 'SIGTERM');
        await ended;
      }
      if (!keep) rmSync(folder, {recursive: true, force: true});
    },
  };
  return service;
}

async function freePort() {
  const {createServer} = await import('node:net');
  return new Promise((resolve) => {
    const listener = createServer().listen(0, '127.0.0.1', () => {
      const {port} = listener.address();
      listener.close(() => resolve(port));
    });
  });
}

let sampleFolder;
// The files of the bundled sample.
export function sample() {
  if (!sampleFolder) {
    sampleFolder = mkdtempSync(join(tmpdir(), 'vacuform-sample-'));
    execFileSync(join(bin, 'vacuform'), ['sample', '--out', sampleFolder]);
    process.on('exit', () => rmSync(sampleFolder, {recursive: true, force: true}));
  }
  return {scan: join(sampleFolder, 'head.stl'), pattern: join(sampleFolder, 'pattern.svg')};
}

// Debian's Chromium. `flags`: more of its options.
export function startBrowser(flags = []) {
  const program = [process.env.VACUFORM_CHROMIUM, '/usr/bin/chromium-headless-shell', '/usr/bin/chromium'].find(
    (path) => path && existsSync(path));
  assert.ok(program, 'Chromium is missing: install the package chromium');
  return chromium.launch({executablePath: program, args: [...(process.getuid() === 0 ? ['--no-sandbox'] : []), ...flags]});
}

// Messages of Chromium itself about drawing in software, which are no faults of the page.
const ofSoftwareDrawing = /GPU stall due to ReadPixels|Automatic fallback to software WebGL|GroupMarkerNotSet/;

// A page in a context of its own. page.faults: console errors, exceptions, reports of CSP and Trusted Types, requests
// that failed or were refused. `options`: of the context (locale, colorScheme, viewport...). `at`: another address of
// the same server.
export async function openPage(browser, service, options = {}, at = service.url) {
  const context = await browser.newContext({locale: 'en-GB', timezoneId: 'Europe/Berlin', viewport: {width: 1280, height: 800},
                                            reducedMotion: 'reduce', baseURL: at, ...options});
  context.setDefaultTimeout(30_000);
  const page = await context.newPage();
  page.faults = [];
  if (options.javaScriptEnabled !== false) {
    await context.exposeBinding('reportViolation', (_source, text) => { page.faults.push(text); });
    await context.addInitScript(() => {
      document.addEventListener('securitypolicyviolation', (event) => {
        window.reportViolation(`CSP: ${event.effectiveDirective} ${event.blockedURI} ${event.sourceFile}:${event.lineNumber} ${event.sample}`);
      });
    });
  }
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type()) && !ofSoftwareDrawing.test(message.text()))
      page.faults.push(`console: ${message.text()} (${message.location().url})`);
  });
  // With a listener, Playwright asks Chromium for file choosers now, not when a test begins to wait for one: that is too late.
  page.on('filechooser', () => {});
  page.on('pageerror', (error) => { page.faults.push(`exception: ${error.stack}`); });
  page.on('requestfailed', (request) => {
    const why = request.failure()?.errorText ?? '';
    if (why !== 'net::ERR_ABORTED') page.faults.push(`request: ${request.method()} ${request.url()} ${why}`);
  });
  return page;
}

// A page of a person who has signed in through the page for that, with an administrator's token unless told otherwise.
export async function signIn(browser, service, options = {}, {token = service.token, at = service.url} = {}) {
  const page = await openPage(browser, service, options, at);
  await enter(page, token);
  return page;
}
// Signs in through the page for that.
export async function enter(page, token) {
  await page.goto('/sign-in');
  await page.getByLabel('Token').fill(token);
  await page.getByRole('button', {name: 'Sign in'}).click();
  await page.waitForURL((url) => url.pathname !== '/sign-in');
}

// Starts Chromium and a service for the tests of a file, and ends both after them. `start` returns at least {service};
// startFurnished returns the ids of its jobs too. `flags`: of Chromium.
//
// Returns test(name, [options,] run). It calls run({page, browser, t, ...what start returned}) with a page of a person who has
// signed in, and closes the page in the end. `options`: of the page, as openPage takes them.
export function setUp(start = () => startFurnished(), flags = []) {
  const all = {};
  before(async () => {
    all.browser = await startBrowser(flags);
    Object.assign(all, await start());
  });
  after(async () => {
    await all.browser?.close();
    await all.service?.stop();
  });
  return (name, ...rest) => test(name, async (t) => {
    const run = rest.pop(), [options] = rest;
    const page = await signIn(all.browser, all.service, options, {at: all.at});
    try {
      await run({...all, page, t});
    } finally {
      await page.context().close();
    }
  });
}

// Goes to a view, such as '#/jobs', and waits until it stands.
export async function show(page, hash) {
  await page.goto('about:blank');  // so that the application starts again
  await page.goto('/' + hash);
  await settled(page).catch((error) => { throw new Error(`${hash} does not stand: ${error.message}\n${page.faults.join('\n')}`); });
}

// Until the view stands and nothing more is being loaded.
export async function settled(page) {
  await page.locator('main h1').first().waitFor();
  await page.waitForLoadState('networkidle');
}

// Drops a file on the page, as from a folder of the computer.
export async function drop(page, path, name = path.split('/').pop()) {
  await dropBytes(page, readFileSync(path), name);
}
export const dropText = (page, text, name) => dropBytes(page, Buffer.from(text), name);
async function dropBytes(page, content, name) {
  const bytes = content.toString('base64');
  const data = await page.evaluateHandle(([text, fileName]) => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], fileName));
    return transfer;
  }, [bytes, name]);
  for (const type of ['dragover', 'drop']) await page.dispatchEvent('main', type, {dataTransfer: data});
}

// Chooses a file with the button of that name.
export async function choose(page, button, path) {
  const [chooser] = await Promise.all([page.waitForEvent('filechooser'), page.getByRole('button', {name: button}).click()]);
  await chooser.setFiles(path);
}

// Clicks a link to a file, and returns the download.
export async function download(page, name = 'print.pdf') {
  const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('link', {name}).first().click()]);
  return file;
}

// The page of a new print

export const referenceField = (page) => page.getByLabel('Reference', {exact: true});
export const leftOnRight = (page) => page.getByRole('radio', {name: 'On the right in the picture, at −x'});
export const checked = (page) => page.getByText('Checked by the service.').waitFor({timeout: 60_000});

// Gives the scan and the drawing of the sample, and settings that take seconds.
export async function giveSample(page) {
  await drop(page, sample().scan);
  await drawn(page);
  await choose(page, 'Choose a drawing', sample().pattern);
  await makeQuick(page);
}

// The id of the job that the page goes to.
export async function jobShown(page) {
  await page.waitForURL(/#\/jobs\/[^/]+$/);
  return page.url().split('/').pop();
}

// Starts the job, and returns its id.
export async function startJob(page) {
  await checked(page);
  await page.getByRole('button', {name: 'Start the job'}).click();
  return jobShown(page);
}

// Opens the list of all settings, and waits for its fields: the first ones have the same names as the main settings above.
export async function openSettings(page, name = 'All settings') {
  await page.getByText(name, {exact: true}).click();
  await page.locator('.all-settings input[type=search]').waitFor();
}

// Sets two settings so that the job takes seconds.
export async function makeQuick(page) {
  await openSettings(page);
  for (const [label, value] of [['Simulation grid', '6'], ['Print resolution', '100']]) {
    const field = page.getByRole('textbox', {name: label, exact: true}).last();
    await field.fill(value);
    await field.blur();
  }
}

// The number of frames that the 3D view has drawn.
export const frames = (page) => page.locator('canvas[data-frame]').first().evaluate((canvas) => Number(canvas.dataset.frame));

// Until the 3D view has drawn and rests.
export async function drawn(page) {
  await page.waitForFunction(() => Number(document.querySelector('canvas[data-frame]')?.dataset.frame) > 0);
  let last = -1;
  await until(async () => {
    const now = await frames(page);
    const rests = now === last;
    last = now;
    await pause(150);
    return rests;
  }, 'the 3D view to rest');
}

// Draws the 3D view at one pixel per CSS pixel on every machine: the view is refined only where it can time its frames. To be
// called before the page is opened.
export const drawnModestly = (page) => page.addInitScript(() => { WebGL2RenderingContext.prototype.fenceSync = () => null; });

// Every kind of view with what it needs; `jobs`: the ids of jobs that exist.
export const viewsOf = (jobs) => ({
  'jobs': '#/jobs',
  'new print': '#/new',
  'job that succeeded': `#/jobs/${jobs.print}`,
  'job that failed': `#/jobs/${jobs.failed}`,
  'array on the part': `#/jobs/${jobs.array}?hide=print-bridges`,
  'array on the sheet': `#/jobs/${jobs.array}?tab=sheet`,
  'array to print and solder': `#/jobs/${jobs.array}?tab=build`,
  'inspection': `#/jobs/${jobs.inspection}`,
  'comparison': `#/compare/${jobs.print}/${jobs.other}`,
  'tokens': '#/admin/tokens',
  'profiles': '#/admin/profiles',
  'profile': '#/admin/profiles?edit=station-3',
  'system': '#/admin',
  'help': '#/help',
  'unknown page': '#/nowhere',
});

// One job of every kind, and a profile: the ids of the jobs.
async function furnish(service) {
  const jobs = {};
  await service.ask('/api/v1/profiles/station-3', {
    method: 'PUT', headers: {'Content-Type': 'application/json'}, body: JSON.stringify({sheet: {thickness_mm: 0.75}})});
  jobs.print = await service.submit({reference: 'CASE-7'});
  jobs.failed = await service.submit({reference: 'CASE-8'}, {...quick, machine: {window_width_mm: 100, window_height_mm: 100}});
  jobs.inspection = await service.submit({kind: 'inspection'});
  await service.ended(jobs.print);
  jobs.other = (await service.json('/api/v1/jobs', {
    method: 'POST', headers: {'Content-Type': 'application/json'},
    body: JSON.stringify({from: jobs.print, settings: {pattern: {rotate_deg: 10}}})})).id;
  jobs.array = (await service.json('/api/v1/jobs', {
    method: 'POST', headers: {'Content-Type': 'application/json'},
    body: JSON.stringify({from: jobs.print, reference: 'CASE-9', settings: {coils: {decouple: true, build: 'two_faces', gaps: 4}}})})).id;
  for (const [name, id] of Object.entries(jobs))
    assert.equal((await service.ended(id)).state, name === 'failed' ? 'failed' : 'succeeded', name);
  return jobs;
}

// A service with finished jobs of every kind: {service, jobs}. The computing is done once if VACUFORM_BROWSER_DATA names a
// folder for its outcome.
export async function startFurnished(workers = 0) {
  const kept = process.env.VACUFORM_BROWSER_DATA;
  const list = kept && join(kept, 'jobs.json');
  if (kept && existsSync(list)) {
    const service = await startService({workers, copyOf: join(kept, 'data')});
    return {service, jobs: JSON.parse(readFileSync(list, 'utf8'))};
  }
  const service = await startService({workers: Math.max(workers, 1)});
  const jobs = await furnish(service);
  if (!kept) return {service, jobs};
  await service.stop({keep: true});
  cpSync(service.data, join(kept, 'data'), {recursive: true});
  rmSync(service.folder, {recursive: true, force: true});
  writeFileSync(list, JSON.stringify(jobs));
  return startFurnished(workers);
}

// The violations that axe finds, one line each.
export async function violations(page) {
  if (!(await page.evaluate(() => 'axe' in window))) await page.evaluate(axeSource());
  const found = await page.evaluate(() => window.axe.run(document, {
    runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'], resultTypes: ['violations']}));
  return found.violations.flatMap((rule) => rule.nodes.map(
    (node) => `${rule.id}: ${node.target.join(' ')}: ${node.failureSummary.replace(/\s+/g, ' ')}`));
}
