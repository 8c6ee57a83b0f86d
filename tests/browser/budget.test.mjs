// Size and speed: 200 kB up to the first view; for 200,000 triangles drawn in software the first frame within 1.5 s and a frame
// of the slider within 200 ms. The best of several runs counts, because other programs share the machine. On a slow machine
// the first frame may take as long as a page that does nothing but load and draw these triangles would allow: see `bare`.
import assert from 'node:assert/strict';
import {createServer, request} from 'node:http';
import {choose, drawn, enter, openPage, sample, setUp, settled, show, startFurnished, until} from './drive.mjs';
import {largeSheet} from './large-sheet.mjs';

// A page without any library that draws the file `formed.glb`. The application does much more: it may take `allowed` times as long.
const allowed = 2;
const bare = `<!doctype html><canvas width="800" height="600"></canvas><script type="module">
  const file = await (await fetch('/artifacts/formed.glb')).arrayBuffer();
  const view = new DataView(file), start = 28 + view.getUint32(12, true);
  const {accessors, bufferViews, meshes} = JSON.parse(new TextDecoder().decode(new Uint8Array(file, 20, start - 28)));
  const {attributes, indices} = meshes[0].primitives[0], canvas = document.querySelector('canvas');
  const gl = canvas.getContext('webgl2', {antialias: false, alpha: false}), program = gl.createProgram();
  for (const [type, text] of [
    [gl.VERTEX_SHADER, 'in vec3 at; out vec3 place; void main() { place = at / 200.0; gl_Position = vec4(place, 1); }'],
    [gl.FRAGMENT_SHADER, 'precision highp float; in vec3 place; out vec4 colour; void main() { colour = vec4(fract(place), 1); }']]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, '#version 300 es\\n' + text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  gl.useProgram(program);
  gl.enable(gl.DEPTH_TEST);
  const load = (target, {bufferView, byteOffset = 0, count}, numbers) => {
    gl.bindBuffer(target, gl.createBuffer());
    gl.bufferData(target, new Uint8Array(file, start + bufferViews[bufferView].byteOffset + byteOffset, 4 * numbers * count), gl.STATIC_DRAW);
  };
  load(gl.ARRAY_BUFFER, accessors[attributes.POSITION], 3);
  load(gl.ELEMENT_ARRAY_BUFFER, accessors[indices], 1);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
  requestAnimationFrame(() => {
    gl.drawElements(gl.TRIANGLES, accessors[indices].count, gl.UNSIGNED_INT, 0);
    canvas.dataset.drawn = String(gl.getError() === 0 && gl.getProgramParameter(program, gl.LINK_STATUS));
    canvas.dataset.frame = '1';
  });
</script>`;

// In front of the service: every formed.glb is a large sheet, which arrives as fast as the file of a job would.
async function startWithLargeSheets() {
  const all = await startFurnished();
  const sheet = largeSheet(317);  // 2 * 317 * 317 triangles
  const listener = createServer((asked, answer) => {
    if (asked.url.endsWith('/artifacts/formed.glb')) {
      answer.writeHead(200, {'Content-Type': 'model/gltf-binary', 'Content-Length': sheet.length}).end(sheet);
      return;
    }
    if (asked.url === '/bare') {
      answer.writeHead(200, {'Content-Type': 'text/html'}).end(bare);
      return;
    }
    const {method, headers} = asked;
    asked.pipe(request(new URL(asked.url, all.service.url), {method, headers}, (given) => {
      answer.writeHead(given.statusCode, given.headers);
      given.pipe(answer);
    }).on('error', () => { answer.destroy(); }));
  });
  listener.on('connection', (socket) => { socket.unref(); });
  await new Promise((done) => { listener.listen(0, '127.0.0.1', done); });
  listener.unref();
  return {...all, at: `http://127.0.0.1:${listener.address().port}`};
}

const testPage = setUp(startWithLargeSheets);

testPage('up to the first view after signing in, at most 200 kB arrive besides the pictures of jobs', async ({browser, service}) => {
  const page = await openPage(browser, service, {locale: 'de-DE'});  // its texts are longer than the English ones
  try {
    const arrived = [];
    page.on('requestfinished', (request) => {
      if (request.url().includes('/artifacts/')) return;
      arrived.push(request.sizes().then(({responseBodySize, responseHeadersSize}) => [request.url(), responseBodySize + responseHeadersSize]));
    });
    await enter(page, service.token);
    await settled(page);
    const sizes = Object.fromEntries(await Promise.all(arrived));
    const all = Object.values(sizes).reduce((sum, size) => sum + size, 0);
    console.log(`${all} bytes up to the first view`);
    assert.ok(Object.keys(sizes).some((url) => url.includes('/app/de-')), 'the texts in German');
    assert.ok(all <= 200_000, `${all} bytes: ${JSON.stringify(sizes)}`);
  } finally {
    await page.context().close();
  }
});

testPage('pages without 3D and uploads load neither library', async ({page, jobs}) => {
  let scripts = [];
  page.on('response', (answer) => {
    if (answer.url().includes('/app/') && answer.url().endsWith('.js')) scripts.push(answer.text().catch(() => ''));
  });
  // Names that no build can shorten: a function of WebGL, a version of tus.
  const has = async (name) => (await Promise.all(scripts)).some((text) => text.includes(name));
  const with3d = () => has('getShaderPrecisionFormat'), withUploads = () => has('ietf-draft-05');
  for (const hash of ['#/jobs', '#/help', '#/admin']) {
    scripts = [];
    await show(page, hash);
    assert.ok(scripts.length > 0);
    assert.deepEqual([await with3d(), await withUploads()], [false, false], hash);
  }
  await show(page, `#/jobs/${jobs.print}`);
  assert.deepEqual([await with3d(), await withUploads()], [true, false]);
  await show(page, '#/new');
  await choose(page, 'Choose a drawing', sample().pattern);
  await until(withUploads, 'the library for uploads');
});

// Milliseconds until a page has drawn its first frame.
async function firstFrame(page, path) {
  await page.goto('about:blank');
  await page.goto(path, {waitUntil: 'commit'});
  await page.waitForFunction(() => Number(document.querySelector('canvas[data-frame]')?.dataset.frame) > 0, null, {polling: 20});
  return page.evaluate(() => performance.now());
}

testPage('200,000 triangles are shown within 1.5 s, and follow the slider within 200 ms', async ({page, jobs}) => {
  const first = [], peer = [];
  for (let run = 0; run < 3; ++run) {
    peer.push(await firstFrame(page, '/bare'));
    assert.equal(await page.locator('canvas').getAttribute('data-drawn'), 'true');
    first.push(await firstFrame(page, `/#/jobs/${jobs.print}`));
  }
  await drawn(page);
  await page.getByRole('radio', {name: 'Split'}).or(page.getByRole('button', {name: 'Split'})).first().click();
  await drawn(page);
  const slider = page.getByRole('slider', {name: /Divider/});
  const slide = await slider.evaluate(async (input) => {
    const canvas = document.querySelector('canvas[data-frame]');
    const times = [];
    for (let i = 1; i <= 12; ++i) {
      const frame = canvas.dataset.frame;
      const begin = performance.now();
      input.value = String(Number(input.min || 0) + (Number(input.max || 100) - Number(input.min || 0)) * i / 13);
      input.dispatchEvent(new Event('input', {bubbles: true}));
      while (canvas.dataset.frame === frame) await new Promise((next) => { requestAnimationFrame(next); });
      const gl = canvas.getContext('webgl2');
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));  // waits until it is drawn
      times.push(performance.now() - begin);
    }
    return times;
  });
  const shown = (times) => times.map((time) => time.toFixed(0)).join(' ');
  console.log(`first frame ${shown(first)} ms, of the bare page ${shown(peer)} ms, slider ${shown(slide)} ms`);
  assert.ok(Math.min(...first) <= Math.max(1500, allowed * Math.min(...peer)), `first frame: ${shown(first)} ms, of the bare page ${shown(peer)} ms`);
  assert.ok(Math.min(...slide) <= 200, `slider: ${shown(slide)} ms`);
});
