// Follows a job over a stream and a server that the test plays.
import assert from 'node:assert/strict';
import {afterEach, beforeEach, mock, test} from 'node:test';
import {followJob, type Follower} from '../src/api/events';

class FakeStream extends EventTarget {
  static readonly CONNECTING = 0;
  static readonly OPEN = 1;
  static readonly CLOSED = 2;
  static all: FakeStream[] = [];
  readyState = FakeStream.CONNECTING;
  constructor(readonly url: string) {
    super();
    FakeStream.all.push(this);
  }
  close(): void {
    this.readyState = FakeStream.CLOSED;
  }
  open(): void {
    this.readyState = FakeStream.OPEN;
    this.dispatchEvent(new Event('open'));
  }
  send(type: string, data: unknown): void {
    this.dispatchEvent(Object.assign(new Event(type), {data: JSON.stringify(data)}));
  }
  fail(readyState: number): void {
    this.readyState = readyState;
    this.dispatchEvent(new Event('error'));
  }
}

const job = (state: string, progress = 0) => ({id: 'j', state, stage: 'scan', progress, stage_progress: 0, attempt: 1, started: null, ended: null});
const line = (number: number) => ({number, time: '2026-11-23T00:00:00Z', text: `line ${number}`});

let heard: string[] = [];
const follower: Follower = {
  job: (change) => heard.push(change.state),
  log: (one) => heard.push(one.text),
  reached: (yes) => heard.push(yes ? 'online' : 'offline'),
  failed: (problem) => heard.push(`failed ${problem.status}`),
};
const said = (): string[] => heard.filter((one) => one !== 'online');

interface Answer {
  status: number;
  body?: unknown;
  etag?: string;
}
let asked: {path: string; tag: string | null}[] = [];
// What the server answers to questions for the job; questions for the log get the given lines.
function serve(answers: (Answer | Error)[], lines: unknown[] = []): void {
  mock.method(globalThis, 'fetch', (path: string, init: RequestInit) => {
    asked.push({path, tag: new Headers(init.headers).get('If-None-Match')});
    if (path.includes('/log')) return Promise.resolve(new Response(JSON.stringify({lines})));
    const answer = answers.length > 1 ? answers.shift() : answers[0];
    if (answer === undefined || answer instanceof Error) return Promise.reject(answer ?? new Error('nothing is served'));
    return Promise.resolve(new Response(answer.body === undefined ? null : JSON.stringify(answer.body), {
      status: answer.status, headers: {'Content-Type': 'application/json', ...(answer.etag && {ETag: answer.etag})}}));
  });
}

// A clock of the test: timers run when the test lets time pass. (The mock timers of Node 18 and 20 differ.)
interface Timer {
  at: number;
  run(): void;
  every: number;  // 0: once
}
const timers = new Map<number, Timer>();
let now = 0, lastTimer = 0;
const settle = async (): Promise<void> => {
  for (let i = 0; i < 5; ++i) await new Promise<void>((done) => setImmediate(done));
};
// `asleep`: time passes, and no timer runs before its end.
async function pass(ms: number, asleep = false): Promise<void> {
  await settle();
  const end = now + ms;
  if (asleep) now = end;
  for (;;) {
    const [next] = [...timers].filter(([, timer]) => timer.at <= end).sort(([, a], [, b]) => a.at - b.at);
    if (!next) break;
    const [id, timer] = next;
    now = Math.max(now, timer.at);
    if (timer.every > 0) timer.at = now + timer.every;
    else timers.delete(id);
    timer.run();
    await settle();
  }
  now = end;
}
const start = (run: () => void, ms: number, every: number): number => {
  timers.set(++lastTimer, {at: now + ms, run, every});
  return lastTimer;
};

beforeEach(() => {
  heard = [];
  asked = [];
  FakeStream.all = [];
  timers.clear();
  now = 1e12;
  Object.assign(globalThis, {EventSource: FakeStream});
  mock.method(Date, 'now', () => now);
  mock.method(globalThis, 'setTimeout', (run: () => void, ms: number) => start(run, ms, 0));
  mock.method(globalThis, 'setInterval', (run: () => void, ms: number) => start(run, ms, ms));
  mock.method(globalThis, 'clearInterval', (id: number) => timers.delete(id));
});
afterEach(() => mock.restoreAll());
const stream = (): FakeStream => FakeStream.all.at(-1) ?? assert.fail('no stream');

test('a stream tells states and lines until the job ends', () => {
  followJob('a/b', follower);
  assert.equal(stream().url, '/api/v1/jobs/a%2Fb/events');
  stream().open();
  stream().send('log', line(1));
  stream().send('job', job('running', 0.4));
  stream().send('job', job('succeeded', 1));
  assert.deepEqual(said(), ['line 1', 'running', 'succeeded']);
  assert.equal(stream().readyState, FakeStream.CLOSED);
  stream().send('job', job('running'));
  assert.equal(said().length, 3);
});

test('a line that comes again is not told again', () => {
  followJob('j', follower);
  for (const number of [1, 2, 1, 2, 3]) stream().send('log', line(number));
  assert.deepEqual(said(), ['line 1', 'line 2', 'line 3']);
});

test('the end of a stream is left to the browser, which connects again', async () => {
  serve([]);
  const stop = followJob('j', follower);
  stream().open();
  stream().fail(FakeStream.CONNECTING);
  stream().open();
  await pass(7000);
  assert.equal(FakeStream.all.length, 1);
  assert.equal(asked.length, 0);
  assert.deepEqual(said(), []);
  stop();
});

test('a server that stays away is told as offline', async () => {
  const stop = followJob('j', follower);
  stream().fail(FakeStream.CONNECTING);
  assert.deepEqual(said(), []);
  await pass(7000);
  assert.deepEqual(said(), ['offline']);
  stop();
});

test('a refused stream is replaced by polling with the tag of the last answer', async () => {
  serve([{status: 200, body: job('running'), etag: '"1"'}, {status: 304, etag: '"1"'}, {status: 200, body: job('succeeded', 1), etag: '"2"'}], [line(1)]);
  followJob('j', follower);
  stream().fail(FakeStream.CLOSED);
  await pass(0);
  assert.deepEqual(said(), ['line 1', 'running']);
  await pass(1000);
  await pass(1000);
  await pass(1000);
  assert.deepEqual(said(), ['line 1', 'running', 'succeeded']);
  const questions = asked.filter(({path}) => !path.includes('/log'));
  assert.deepEqual(questions.map(({tag}) => tag), [null, '"1"', '"1"']);
  assert.match(questions[1]?.path ?? '', /\?wait=\d+$/);
});

test('polling goes on when the server is away for a while', async () => {
  serve([new Error('no network'), {status: 503, body: {type: 'busy', title: '', status: 503}}, {status: 200, body: job('failed'), etag: '"2"'}]);
  followJob('j', follower);
  stream().fail(FakeStream.CLOSED);
  for (let i = 0; i < 6; ++i) await pass(30_000);
  assert.deepEqual(said(), ['offline', 'failed']);
});

test('a job that is gone ends the following', async () => {
  serve([{status: 404, body: {type: '/problems/not-found', title: 'gone', status: 404}}]);
  followJob('j', follower);
  stream().fail(FakeStream.CLOSED);
  await pass(0);
  await pass(60_000);
  assert.deepEqual(said(), ['failed 404']);
  assert.equal(asked.length, 1);
});

test('after a sleep the stream is opened again', async () => {
  const stop = followJob('j', follower);
  stream().send('log', line(1));
  await pass(60_000);
  assert.equal(FakeStream.all.length, 1);
  await pass(3_600_000, true);
  assert.equal(FakeStream.all.length, 2);
  assert.equal(FakeStream.all[0]?.readyState, FakeStream.CLOSED);
  stream().send('log', line(1));
  stream().send('log', line(2));
  assert.deepEqual(said(), ['line 1', 'line 2']);
  stop();
});

test('nothing is told after the end', async () => {
  serve([{status: 200, body: job('running'), etag: '"1"'}]);
  const stop = followJob('j', follower);
  stream().fail(FakeStream.CLOSED);
  stop();
  await pass(5000);
  assert.deepEqual(said(), []);
});
