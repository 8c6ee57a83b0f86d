// Follows one job to its end: by server-sent events, or by polling where a stream cannot be had.
//
// The browser reconnects a stream that breaks and says by Last-Event-ID what it has. The server ends a stream after ten
// minutes, which is the same to the browser. After a sleep of the computer, and when the network is back, the stream is
// opened again: the old one may be dead without knowing it.
import {ask, jobPath, Problem} from './client';
import type {Job, ListedJob, LogLine} from './types';
import {ended} from './types';

// What changes while a job runs; an answer to polling has all of the job.
export type JobChange =
  Pick<ListedJob, 'id' | 'state' | 'stage' | 'progress' | 'stage_progress' | 'attempt' | 'started' | 'ended' | 'problem'>;

export interface Follower {
  job(change: JobChange | Job): void;
  log(line: LogLine): void;      // each line once, in order
  reached(yes: boolean): void;   // whether the server answers
  failed(problem: Problem): void;  // the job cannot be followed any more, for example since it was deleted
}

const tick = 10_000, slept = 90_000;  // ms; hidden tabs tick once a minute
const patience = 6000;  // ms for the browser to connect again
const waitSeconds = 25;

export function followJob(id: string, follower: Follower): () => void {
  let stream: EventSource | null = null;
  let polling: AbortController | null = null;
  let lastLine = 0;
  let over = false;

  function stop(): void {
    over = true;
    clearInterval(clock);
    globalThis.removeEventListener?.('online', open);
    stream?.close();
    polling?.abort();
  }
  function take(change: JobChange | Job): void {
    if (over) return;
    follower.reached(true);
    follower.job(change);
    if (ended(change.state)) stop();
  }
  function takeLine(line: LogLine): void {
    if (over || line.number <= lastLine) return;
    lastLine = line.number;
    follower.log(line);
  }

  function open(): void {
    if (over) return;
    stream?.close();
    polling?.abort();
    polling = null;
    const opened = stream = new EventSource(`${jobPath(id)}/events`);
    opened.addEventListener('open', () => follower.reached(true));
    opened.addEventListener('job', (event) => take(JSON.parse(String(event.data)) as JobChange));
    opened.addEventListener('log', (event) => takeLine(JSON.parse(String(event.data)) as LogLine));
    opened.addEventListener('error', () => {
      if (over || stream !== opened) return;
      // refused (nothing left, too many clients, signed out), or broken: then the browser connects again
      if (opened.readyState === EventSource.CLOSED) void poll();
      else setTimeout(() => {
        if (!over && stream === opened && opened.readyState !== EventSource.OPEN) follower.reached(false);
      }, patience);
    });
  }

  async function poll(): Promise<void> {
    const mine = polling = new AbortController();
    stream = null;
    for (let tag = '', pause = 0; !over && polling === mine;) {
      try {
        if (pause > 0) await new Promise((done) => setTimeout(done, pause));
        if (over || polling !== mine) return;
        const headers: Record<string, string> = tag ? {'If-None-Match': tag} : {};
        const answer = await ask(`${jobPath(id)}${tag && `?wait=${waitSeconds}`}`, {headers, signal: mine.signal});
        follower.reached(true);
        const log = await (await ask(`${jobPath(id)}/log?after=${lastLine}`, {signal: mine.signal})).json() as {lines: LogLine[]};
        for (const line of log.lines) takeLine(line);
        pause = 1000;
        tag = answer.headers.get('ETag') ?? '';
        if (answer.status !== 304) take(await answer.json() as Job);
      } catch (error) {
        if (over || polling !== mine) return;
        const status = error instanceof Problem ? error.status : 0;
        if (status >= 400 && status < 500 && status !== 429) {
          follower.failed(error as Problem);
          stop();
          return;
        }
        if (status === 0) follower.reached(false);
        pause = Math.min(30_000, Math.max(2000, pause * 2));
      }
    }
  }

  let last = Date.now();
  const clock = setInterval(() => {
    const now = Date.now();
    if (now - last > slept) open();
    last = now;
  }, tick);
  globalThis.addEventListener?.('online', open);
  open();
  return stop;
}

