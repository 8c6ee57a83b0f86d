import {webcrypto} from 'node:crypto';
import assert from 'node:assert/strict';
import test from 'node:test';
import {extensionOf, markOf, pieceBytes, startUpload, type SendPiece, type Transfer, type Upload} from '../src/api/upload';

globalThis.crypto ??= webcrypto as Crypto;  // Node.js 18 keeps it in a module

// A tus server in memory, as the service answers.
class Server {
  stored = new Uint8Array(0);
  length = 0;
  id = '';
  created = 0;
  metadata = '';
  checksums: string[] = [];
  statuses: number[] = [];   // answers to the next requests for a piece; 0: the connection breaks
  kept = 0;                  // bytes of a broken piece that arrived all the same

  fetch = async (path: string, init: RequestInit = {}): Promise<Response> => {
    const headers = new Headers(init.headers);
    if (init.method === 'POST') {
      ++this.created;
      this.metadata = headers.get('Upload-Metadata') ?? '';
      this.length = Number(headers.get('Upload-Length'));
      this.stored = new Uint8Array(0);
      this.id = `id${this.created}`;
      return new Response('{}', {status: 201, headers: {Location: `/api/v1/uploads/${this.id}`}});
    }
    if (!path.endsWith(`/${this.id}`)) return new Response(null, {status: 404});
    if (init.method === 'DELETE') {
      this.id = 'deleted';
      return new Response(null, {status: 204});
    }
    return new Response(null, {status: 200, headers: {'Upload-Offset': String(this.stored.length), 'Upload-Length': String(this.length)}});
  };

  send: SendPiece = async (path, headers, body, progress, signal) => {
    const bytes = new Uint8Array(await body.arrayBuffer());
    assert.ok(bytes.length <= pieceBytes);
    if (signal.aborted) return null;
    const status = this.statuses.shift() ?? 204;
    this.checksums.push(headers['Upload-Checksum'] ?? '');
    progress(bytes.length);
    const add = (part: Uint8Array): void => {
      const all = new Uint8Array(this.stored.length + part.length);
      all.set(this.stored);
      all.set(part, this.stored.length);
      this.stored = all;
    };
    if (status === 0) {
      add(bytes.slice(0, this.kept));
      return null;
    }
    if (status !== 204) return new Response(JSON.stringify({type: '/problems/x', title: 'x', status}), {status, headers: {'Content-Type': 'application/problem+json'}});
    if (!path.endsWith(`/${this.id}`)) return new Response(null, {status: 404});
    if (Number(headers['Upload-Offset']) !== this.stored.length) return new Response(null, {status: 409});
    add(bytes);
    return new Response(null, {status: 204, headers: {'Upload-Offset': String(this.stored.length)}});
  };
}

const bytesOf = (count: number): Uint8Array => Uint8Array.from({length: count}, (_, i) => i * 7 + (i >> 8));
interface Run { upload: Upload; ended: Promise<Transfer>; told: Transfer[]; started: string[] }
function run(server: Server, file: Blob, id: string | null = null): Run {
  globalThis.fetch = server.fetch as typeof fetch;
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
    }, server.send);
  });
  return {upload: upload as Upload, ended, told, started};
}

test('sends a file in pieces with their digests, and of its name the extension alone', async () => {
  const server = new Server(), bytes = bytesOf(pieceBytes * 2 + 5);
  const {ended, started} = run(server, new Blob([bytes]));
  assert.equal((await ended).state, 'done');
  assert.deepEqual(server.stored, bytes);
  assert.deepEqual(started, ['id1']);
  assert.equal(server.checksums.length, 3);
  assert.match(server.checksums[0] ?? '', /^sha256 [A-Za-z0-9+/]{43}=$/);
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
  assert.deepEqual([failed.state, failed.problem?.status], ['failed', 412]);
  upload.resume();
  while (told.at(-1)?.state !== 'done') await new Promise((resolve) => setTimeout(resolve, 5));
  assert.deepEqual(server.stored, bytes);
});

test('gives up after answers that do not help', async () => {
  const server = new Server();
  server.statuses = Array.from({length: 50}, () => 409);
  const {ended} = run(server, new Blob([bytesOf(10)]));
  assert.deepEqual([(await ended).state, server.checksums.length], ['failed', 5]);
});

test('pauses, resumes and aborts', async () => {
  const server = new Server(), bytes = bytesOf(pieceBytes + 1);
  const {upload, ended, told} = run(server, new Blob([bytes]));
  upload.pause();
  await new Promise((resolve) => setTimeout(resolve, 50));
  assert.equal(told.at(-1)?.state, 'paused');
  const sent = server.stored.length;
  assert.ok(sent < bytes.length);
  upload.resume();
  await ended;
  assert.deepEqual(server.stored, bytes);
  const second = run(server, new Blob([bytes]));
  await new Promise((resolve) => setTimeout(resolve, 1));
  second.upload.abort();
  await new Promise((resolve) => setTimeout(resolve, 50));
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
