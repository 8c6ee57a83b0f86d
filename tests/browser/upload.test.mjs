// An upload survives a cut in the middle of a piece and a reload: it continues at the bytes that have arrived.
import assert from 'node:assert/strict';
import {mkdirSync, readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after} from 'node:test';
import {choose, pause, sample, settled, setUp, show, startService, until} from './drive.mjs';
import {startRelay} from './relay.mjs';

let service;
let relay;
let scan;  // 18 MB: the application sends pieces of 2 MiB
const test = setUp(async () => {
  service = await startService({workers: 0});
  scan = join(service.folder, 'ball.stl');
  writeFileSync(scan, ball(300, 200));
  relay = await startRelay(service.port);
  return {service, at: relay.url};
});
after(() => relay?.stop());

// A sphere as binary STL, with `n` * 4n triangles of 50 bytes.
function ball(n, diameter) {
  const bytes = Buffer.alloc(84 + n * 4 * n * 50);
  bytes.writeUInt32LE(n * 4 * n, 80);
  const corner = (i, j) => {
    const [up, around] = [Math.PI * i / n, Math.PI * j / n];
    return [Math.sin(up) * Math.cos(around), Math.sin(up) * Math.sin(around), Math.cos(up)].map((x) => x * diameter / 2);
  };
  let at = 84;
  for (let i = 0; i < n; ++i)
    for (let j = 0; j < 2 * n; ++j)
      for (const corners of [[[i, j], [i + 1, j], [i + 1, j + 1]], [[i, j], [i + 1, j + 1], [i, j + 1]]]) {
        corners.flatMap(([a, b]) => corner(a, b)).forEach((x, k) => { bytes.writeFloatLE(x, at + 12 + 4 * k); });
        at += 50;
      }
  return bytes;
}

// What the service has of an upload; null while a request that has lost its client still holds it.
const uploadOf = async (id) => {
  const answer = await fetch(`${service.url}/api/v1/uploads/${id}`, {headers: {Authorization: `Bearer ${service.token}`}});
  assert.ok(answer.ok || answer.status === 423, `${answer.status}`);
  return answer.ok ? answer.json() : null;
};

const uploads = async (page) => page.evaluate(async () => {
  const draft = JSON.parse(sessionStorage.getItem('vacuform.draft') ?? '{}');
  return JSON.stringify(draft).match(/\/?uploads\/([^"/]+)/)?.[1] ?? draft.scan?.upload ?? null;
});

test('after a cut and a reload the upload continues where it stopped, and the bytes are those of the file', async ({page}) => {
  const size = readFileSync(scan).length;
  await show(page, '#/new');
  relay.slow(5_000_000);
  await choose(page, 'Choose a scan', scan);
  const before = relay.sent;
  await until(() => relay.sent - before > 9_500_000, 'some pieces and a part of the next');
  relay.cut();
  await page.getByText('Waiting for the server').waitFor();

  relay.restore();
  relay.slow(400_000);
  const again = relay.sent;
  await until(() => relay.sent - again > 300_000, 'more bytes after the cut');
  await page.reload();
  await page.getByText(/^Choose ball\.stl .* again\. Its upload continues where it stopped\.$/).waitFor();
  const id = await uploads(page);
  assert.ok(id, 'the draft names the upload');
  const {offset} = await until(() => uploadOf(id), 'the state of the upload');
  assert.ok(offset > 0 && offset < size, `offset ${offset} of ${size}`);

  relay.restore();
  const rest = relay.sent;
  await choose(page, 'Choose a scan', scan);
  const done = await until(async () => {
    const upload = await uploadOf(id);
    return upload?.offset === size && upload;
  }, 'the end of the upload');
  assert.ok(done.sha256);
  assert.ok(relay.sent - rest < size - offset + 300_000, `${relay.sent - rest} bytes were sent for the rest of ${size - offset}`);
});

test('an upload that stalls for a while continues', async ({page}) => {
  await show(page, '#/new');
  relay.slow(400_000);
  await choose(page, 'Choose a scan', scan);
  const id = await until(() => uploads(page), 'the upload');
  relay.stall();
  await pause(3000);
  relay.restore();
  const size = readFileSync(scan).length;
  await until(async () => (await uploadOf(id))?.offset === size, 'the end of the upload');
  await page.getByText(/^Choose/).first().waitFor();
});

test('an upload that begins without a connection begins when there is one', async ({page}) => {
  await show(page, '#/new');
  relay.cut();
  await choose(page, 'Choose a drawing', sample().pattern);
  await page.getByText('Waiting for the server').waitFor();
  relay.restore();
  await page.getByText('The pattern has arrived.').waitFor({state: 'attached'});
  assert.deepEqual(await page.evaluate(() => Object.keys(localStorage).filter((key) => key.includes('tus'))), []);
});

test('another file is not appended to the upload of the first', async ({page}) => {
  await show(page, '#/new');
  relay.slow(400_000);
  await choose(page, 'Choose a scan', scan);
  const first = await until(() => uploads(page), 'the first upload');
  await page.reload();
  relay.restore();
  await settled(page);
  const other = join(service.folder, 'other', 'ball.stl');
  mkdirSync(join(service.folder, 'other'));
  writeFileSync(other, ball(60, 190));
  await choose(page, 'Choose a scan', other);
  const second = await until(async () => {
    const id = await uploads(page);
    return id !== first && id;
  }, 'an upload of its own');
  const size = readFileSync(other).length;
  await until(async () => (await uploadOf(second))?.offset === size, 'the end of the upload');
});
