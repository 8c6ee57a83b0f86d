import {createHash, webcrypto} from 'node:crypto';
import assert from 'node:assert/strict';
import test from 'node:test';
import {extensionOf, markOf, pieceBytes, startUpload, type Transfer, type Upload} from '../src/api/upload';

globalThis.crypto ??= webcrypto as Crypto;  // Node.js 18 keeps it in a module

// A tus server in memory, as the service answers, and the requests of a browser to it.
class Server {
  stored = new Uint8Array(0);
  length = 0;
  id = '';
  created = 0;
  metadata = '';
  pieces = 0;
  statuses: number[] = [];      // answers to the next requests for a piece; 0: the connection breaks, -1: it stays silent
  headStatuses: number[] = [];  // answers to the next questions for the offset
  kept = 0;                     // bytes of a broken piece that arrived all the same

  // Null: the connection breaks. Undefined: no answer comes.
  async answer(method: string, path: string, headers: Headers, body: Blob | null): Promise<Response | null | undefined> {
    if (method === 'POST') {
      ++this.created;
      this.metadata = headers.get('Upload-Metadata') ?? '';
      this.length = Number(headers.get('Upload-Length'));
      this.stored = new Uint8Array(0);
      this.id = `id${this.created}`;
      return new Response('{}', {status: 201, headers: {Location: `/api/v1/uploads/${this.id}`}});
    }
    if (!path.endsWith(`/${this.id}`)) return new Response(null, {status: 404});
    if (method === 'DELETE') {
      this.id = 'deleted';
      return new Response(null, {status: 204});
    }
    const place = (): Record<string, string> => ({'Upload-Offset': String(this.stored.length), 'Upload-Length': String(this.length)});
    if (method === 'HEAD') return new Response(null, {status: this.headStatuses.shift() ?? 200, headers: place()});
    const bytes = new Uint8Array(await body!.arrayBuffer());
    assert.ok(bytes.length <= pieceBytes);
    const status = this.statuses.shift() ?? 204;
    assert.equal(headers.get('Upload-Checksum'), `sha256 ${createHash('sha256').update(bytes).digest('base64')}`);
    ++this.pieces;
    if (status === -1) return undefined;
    if (status === 0) {
      this.#add(bytes.slice(0, this.kept));
      return null;
    }
    if (status !== 204)
      return new Response(JSON.stringify({type: '/problems/x', title: 'x', status}), {status, headers: {'Content-Type': 'application/problem+json'}});
    if (Number(headers.get('Upload-Offset')) !== this.stored.length) return new Response(null, {status: 409});
    this.#add(bytes);
    return new Response(null, {status: 204, headers: place()});
  }
  #add(part: Uint8Array): void {
    const all = new Uint8Array(this.stored.length + part.length);
    all.set(this.stored);
    all.set(part, this.stored.length);
    this.stored = all;
  }
}

let server: Server;
class Request {
  readonly upload: {onprogress?: (event: {lengthComputable: boolean; loaded: number}) => void} = {};
  onload = (): void => {};
  onerror = (_: unknown): void => {};
  status = 0;
  responseText = '';
  #method = '';
  #path = '';
  #aborted = false;
  readonly #headers = new Headers();
  #answered = new Headers();
  open(method: string, path: string): void { [this.#method, this.#path] = [method, path]; }
  setRequestHeader(name: string, value: string): void { this.#headers.set(name, value); }
  getResponseHeader(name: string): string | null { return this.#answered.get(name); }
  abort(): void { this.#aborted = true; }
  async send(body: Blob | null): Promise<void> {
    const answer = await server.answer(this.#method, this.#path, this.#headers, body);
    if (this.#aborted || answer === undefined) return;
    if (answer === null) return this.onerror(new Error('the connection broke'));
    this.upload.onprogress?.({lengthComputable: true, loaded: body?.size ?? 0});
    [this.status, this.#answered, this.responseText] = [answer.status, answer.headers, await answer.text()];
    this.onload();
  }
}
Object.assign(globalThis, {
  XMLHttpRequest: Request,
  fetch: async (path: string, {method = 'GET', headers}: RequestInit) => await server.answer(method, path, new Headers(headers), null)});

const pause = (ms: number): Promise<void> => new Promise((resolve) => setTimeout(resolve, ms));
const bytesOf = (count: number): Uint8Array => Uint8Array.from({length: count}, (_, i) => i * 7 + (i >> 8));
interface Run { upload: Upload; ended: Promise<Transfer>; told: Transfer[]; started: string[] }
function run(to: Server, file: Blob, id: string | null = null): Run {
  server = to;
  const told: Transfer[] = [], started: string[] = [];
  let upload: Upload | undefined;
  const ended = new Promise<Transfer>((resolve) => {
    upload = startUpload({file, extension: 'stl', input: 'scan', id}, {
      started: (given) => started.push(given),
      progress: (transfer) => {
        told.push(transfer);
        if (transfer.state === 'failed' || transfer.state === 'done') resolve(transfer);
      },
      done: () => {},
    });
  });
  return {upload: upload as Upload, ended, told, started};
}

test('sends a file in pieces with their digests, and of its name the extension alone', async () => {
  const server = new Server(), bytes = bytesOf(pieceBytes * 2 + 5);
  const {ended, started} = run(server, new Blob([bytes]));
  assert.equal((await ended).state, 'done');
  assert.deepEqual(server.stored, bytes);
  assert.deepEqual(started, ['id1']);
  assert.equal(server.pieces, 3);
  assert.equal(server.metadata, `filename ${btoa('file.stl')},input ${btoa('scan')}`);
});

test('resumes at the offset of the server after a broken connection', async () => {
  const server = new Server(), bytes = bytesOf(50_000);
  server.statuses = [0, 503];
  server.kept = 12_345;
  const {ended, told} = run(server, new Blob([bytes]));
  assert.equal((await ended).state, 'done');
  assert.deepEqual(server.stored, bytes);
  assert.equal(server.created, 1);
  assert.ok(told.some(({state}) => state === 'waiting'));
});

test('sends a damaged piece again, and asks for the offset after a conflict', async () => {
  const server = new Server(), bytes = bytesOf(1000);
  server.statuses = [460, 409];
  const {ended} = run(server, new Blob([bytes]));
  assert.equal((await ended).state, 'done');
  assert.deepEqual(server.stored, bytes);
});

test('resumes an upload of before a reload, and begins again where it has expired', async () => {
  const server = new Server(), bytes = bytesOf(1000);
  server.id = 'before';
  server.length = 1000;
  server.stored = bytes.slice(0, 400);
  const resumed = run(server, new Blob([bytes]), 'before');
  assert.equal((await resumed.ended).state, 'done');
  assert.deepEqual([server.created, resumed.started.length], [0, 0]);
  assert.deepEqual(server.stored, bytes);
  const expired = run(server, new Blob([bytes]), 'long-ago');
  assert.equal((await expired.ended).state, 'done');
  assert.deepEqual([server.created, expired.started], [1, ['id1']]);
});

test('keeps what the server has where it is only busy when asked for the offset', async () => {
  const server = new Server(), bytes = bytesOf(1000);
  server.id = 'before';
  server.length = 1000;
  server.stored = bytes.slice(0, 400);
  server.headStatuses = [503, 423];
  const {ended} = run(server, new Blob([bytes]), 'before');
  assert.equal((await ended).state, 'done');
  assert.equal(server.created, 0);
  assert.deepEqual(server.stored, bytes);
});

test('begins again where the upload is of a file of another size', async () => {
  const server = new Server(), bytes = bytesOf(1000);
  server.id = 'before';
  server.length = 999;
  const {ended, started} = run(server, new Blob([bytes]), 'before');
  assert.equal((await ended).state, 'done');
  assert.deepEqual(started, ['id1']);
  assert.deepEqual(server.stored, bytes);
});

test('says why when the server refuses, and goes on when asked', async () => {
  const server = new Server(), bytes = bytesOf(1000);
  server.statuses = [412];
  const {ended, upload, told} = run(server, new Blob([bytes]));
  const failed = await ended;
  assert.deepEqual([failed.state, failed.problem?.status, failed.problem?.code], ['failed', 412, 'x']);
  upload.resume();
  while (told.at(-1)?.state !== 'done') await pause(5);
  assert.deepEqual(server.stored, bytes);
});

test('gives up after answers that do not help', async () => {
  const server = new Server();
  server.statuses = Array.from({length: 50}, () => 409);
  const {ended} = run(server, new Blob([bytesOf(10)]));
  assert.deepEqual([(await ended).state, server.pieces], ['failed', 5]);
});

test('a file that can no longer be read has failed', async () => {
  const file = new Blob([bytesOf(10)]);
  file.slice = () => ({arrayBuffer: () => Promise.reject(new Error('changed on the disk'))}) as unknown as Blob;
  const failed = await run(new Server(), file).ended;
  assert.deepEqual([failed.state, failed.problem?.code], ['failed', 'file-changed']);
});

test('ends a connection that has been silent for 30 s, and goes on with another one', async (t) => {
  const server = new Server(), bytes = bytesOf(1000), {setTimeout: later} = globalThis;
  server.statuses = [-1];
  t.mock.method(globalThis, 'setTimeout', (call: () => void, ms: number) => later(call, ms === 30_000 ? 200 : ms));
  const {ended, told} = run(server, new Blob([bytes]));
  assert.equal((await ended).state, 'done');
  assert.ok(told.some(({state}) => state === 'waiting'));
  assert.equal(server.pieces, 2);
  assert.deepEqual(server.stored, bytes);
});

test('pauses, resumes and aborts', async () => {
  const server = new Server(), bytes = bytesOf(pieceBytes + 1);
  const {upload, ended, told} = run(server, new Blob([bytes]));
  upload.pause();
  await pause(50);
  assert.equal(told.at(-1)?.state, 'paused');
  const sent = server.stored.length;
  assert.ok(sent < bytes.length);
  upload.resume();
  upload.pause();
  upload.resume();  // the former attempts are over: nothing is sent twice
  await ended;
  assert.deepEqual(server.stored, bytes);
  assert.deepEqual([server.created, server.pieces], [1, 2]);
  const second = run(server, new Blob([bytes]));
  await pause(1);
  second.upload.abort();
  await pause(50);
  assert.notEqual(second.told.at(-1)?.state, 'done');
});

test('the mark of a file tells it from others', async () => {
  const bytes = bytesOf(3 * 1024 * 1024);
  const mark = await markOf(new Blob([bytes]));
  assert.equal(await markOf(new Blob([bytes])), mark);
  for (const at of [0, bytes.length - 1]) {
    const other = bytes.slice();
    other[at]! ^= 1;
    assert.notEqual(await markOf(new Blob([other])), mark);
  }
  assert.notEqual(await markOf(new Blob([bytes.slice(1)])), mark);
  assert.deepEqual([extensionOf('Anna Meier.STL'), extensionOf('a'), extensionOf('a.tar.gz')], ['stl', '', 'gz']);
});
