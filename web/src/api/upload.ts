// Sends a large file in pieces by tus 1.0.0. It resumes where the server stands after every failure, and after a reload of
// the page when the same file is given again.
import {ask, hex, noServer, Problem, problemOf} from './client';

export type TransferState = 'sending' | 'paused' | 'waiting' | 'done' | 'failed';
export interface Transfer {
  state: TransferState;     // waiting: the server does not answer; the next attempt comes on its own
  sent: number;             // bytes
  bytes: number;
  speed: number | null;     // bytes in a second; null before it is known
  left: number | null;      // seconds
  problem: Problem | null;  // of a failed one, or why the server has it wait
}
export interface Upload {
  pause(): void;
  resume(): void;           // also after a failure
  abort(): void;            // deletes what the server has
}
export interface Watcher {
  started(id: string): void;  // the server has a place for the file; another one if the former has expired
  progress(transfer: Transfer): void;
  done(id: string): void;
}
export interface Source {
  file: Blob;
  extension: string;        // all that is sent of the name
  input: 'scan' | 'pattern' | 'icc';
  id: string | null;        // of an unfinished upload of the same file
}

const uploads = '/api/v1/uploads';
const path = (id: string): string => `${uploads}/${encodeURIComponent(id)}`;
const version = {'Tus-Resumable': '1.0.0'};
export const pieceBytes = 2 * 1024 * 1024;
const idleLimit = 30_000;  // ms without progress after which a connection counts as dead
const longestPause = 30_000;
const forgiven = 4;        // failures in a row that are the server's answer and not the network's

// Sends one piece. Status 0: no answer.
export type SendPiece = (path: string, headers: Record<string, string>, body: Blob, progress: (sent: number) => void,
                         signal: AbortSignal) => Promise<Response | null>;

export const sendByXhr: SendPiece = (url, headers, body, progress, signal) => new Promise((resolve) => {
  const request = new XMLHttpRequest();
  let idle = 0;
  const watch = (): void => {
    clearTimeout(idle);
    idle = setTimeout(() => request.abort(), idleLimit);
  };
  const stop = (): void => request.abort();
  const end = (response: Response | null): void => {
    clearTimeout(idle);
    signal.removeEventListener('abort', stop);
    resolve(response);
  };
  request.open('PATCH', url);
  for (const [name, value] of Object.entries(headers)) request.setRequestHeader(name, value);
  request.upload.onprogress = (event) => { watch(); progress(event.loaded); };
  request.onload = () => {
    const answered = new Headers();
    for (const line of request.getAllResponseHeaders().trim().split(/[\r\n]+/)) {
      const at = line.indexOf(':');
      if (at > 0) answered.append(line.slice(0, at), line.slice(at + 1).trim());
    }
    end(new Response(request.status === 204 ? null : request.responseText, {status: request.status, headers: answered}));
  };
  request.onerror = request.onabort = () => end(null);
  signal.addEventListener('abort', stop);
  watch();
  request.send(body);
});

async function digest(bytes: ArrayBuffer): Promise<Uint8Array | null> {
  return globalThis.crypto?.subtle ? new Uint8Array(await crypto.subtle.digest('SHA-256', bytes)) : null;
}

// Tells whether a file is the same as before: a digest of its size, its beginning and its end.
export async function markOf(file: Blob): Promise<string> {
  const mebi = 1024 * 1024;
  const ends = new Blob([file.slice(0, mebi), file.slice(Math.max(mebi, file.size - mebi))]);
  const hash = await digest(await ends.arrayBuffer());
  return `${file.size}-${hex(hash ?? [])}`;
}

export const extensionOf = (name: string): string =>
  /\.([A-Za-z0-9]{1,8})$/.exec(name)?.[1]?.toLowerCase() ?? '';

export function removeUpload(id: string): void {
  ask(path(id), {method: 'DELETE', headers: version}).catch(() => {});  // it expires anyway
}

export function startUpload(source: Source, watcher: Watcher, send: SendPiece = sendByXhr, now = (): number => Date.now()): Upload {
  const {file} = source;
  let id = source.id;
  let offset: number | null = id ? null : 0;  // null: ask the server
  let state: TransferState = 'sending';
  let failures = 0, answers = 0;
  let running = false, over = false;
  let cut = new AbortController();
  let wake = (): void => {};
  let samples: {time: number; sent: number}[] = [];

  function tell(sent: number, problem: Problem | null = null): void {
    const time = now();
    if (state === 'sending') samples = [...samples.filter((sample) => time - sample.time < 8000), {time, sent}];
    const first = samples[0];
    const seconds = first ? (time - first.time) / 1000 : 0;
    const speed = first && seconds > 0.5 && sent > first.sent ? (sent - first.sent) / seconds : null;
    watcher.progress({state, sent, bytes: file.size, speed, left: speed && (file.size - sent) / speed, problem});
  }

  async function create(): Promise<void> {
    const metadata = `filename ${btoa(`file.${source.extension}`)},input ${btoa(source.input)}`;
    const answer = await ask(uploads, {
      method: 'POST', headers: {...version, 'Upload-Length': String(file.size), 'Upload-Metadata': metadata}, signal: cut.signal});
    id = answer.headers.get('Location')?.split('/').pop() ?? '';
    offset = 0;
    watcher.started(id);
  }

  async function askOffset(known: string): Promise<void> {
    const answer = await ask(path(known), {method: 'HEAD', headers: version, cache: 'no-store', signal: cut.signal});
    offset = Number(answer.headers.get('Upload-Offset'));
    if (Number(answer.headers.get('Upload-Length')) !== file.size) id = null;  // of another file
  }

  async function piece(known: string, from: number): Promise<void> {
    const body = file.slice(from, from + pieceBytes);
    const headers: Record<string, string> = {
      ...version, 'Upload-Offset': String(from), 'Content-Type': 'application/offset+octet-stream'};
    const bytes = await body.arrayBuffer().catch(() => {
      throw new Problem({type: 'file-changed', title: '', status: 400});  // on the disk of the person
    });
    const hash = await digest(bytes);
    if (hash) headers['Upload-Checksum'] = `sha256 ${btoa(String.fromCharCode(...hash))}`;
    let told = 0;
    offset = null;
    const answer = await send(path(known), headers, body, (sent) => {
      if (cut.signal.aborted || now() - told < 200) return;
      told = now();
      tell(from + sent);
    }, cut.signal);
    if (!answer) throw noServer('');
    if (!answer.ok) throw await problemOf(answer);
    offset = Number(answer.headers.get('Upload-Offset'));
    if (offset > from) failures = answers = 0;
  }

  // What to do after a failure: true to go on.
  async function recover(problem: Problem): Promise<boolean> {
    const {status} = problem;
    offset = null;
    const mine = status >= 400 && status !== 423 && status !== 429 && status !== 503;
    if (mine && ++answers > forgiven) return false;
    if (status === 404 || status === 410) id = null;                 // expired or deleted: begin again
    else if (status === 409) { /* ask for the offset at once */ }
    else if (status !== 460 && status !== 408 && mine && status !== 500 && status !== 502 && status !== 504) return false;
    if (++failures > 1 || status !== 409) {
      state = 'waiting';
      tell(samples.at(-1)?.sent ?? 0, status > 0 ? problem : null);
      const pause = Math.min(longestPause, 500 * 2 ** Math.min(failures, 10));
      await new Promise<void>((resolve) => {
        const timer = setTimeout(resolve, pause);
        wake = () => { clearTimeout(timer); resolve(); };
      });
      if (state === 'waiting') state = 'sending';
    }
    return true;
  }

  async function run(): Promise<void> {
    if (running) return;
    running = true;
    while (!over && state === 'sending') {
      try {
        if (!id) await create();
        else if (offset === null) await askOffset(id);
        if (!id || offset === null) continue;
        tell(offset);
        if (offset >= file.size) {
          state = 'done';
          tell(file.size);
          over = true;
          watcher.done(id);
        } else {
          await piece(id, offset);
        }
      } catch (error) {
        if (over || state !== 'sending') break;  // paused
        samples = samples.slice(-1);
        const problem = error instanceof Problem ? error : noServer(error);
        if (!await recover(problem)) {
          state = 'failed';
          tell(0, problem);
        }
      }
    }
    running = false;
    if (over) globalThis.removeEventListener?.('online', online);
    else if (state === 'sending') void run();  // resumed while the last request ended
  }

  function halt(next: TransferState): void {
    state = next;
    cut.abort();
    cut = new AbortController();
    offset = null;
    wake();
  }
  const online = (): void => wake();
  globalThis.addEventListener?.('online', online);
  void run();
  return {
    pause() {
      if (over || state === 'paused') return;
      halt('paused');
      tell(samples.at(-1)?.sent ?? 0);
    },
    resume() {
      if (over || state === 'sending') return;
      state = 'sending';
      failures = answers = 0;
      samples = [];
      wake();
      void run();
    },
    abort() {
      over = true;
      halt('paused');
      globalThis.removeEventListener?.('online', online);
      if (id) removeUpload(id);
    },
  };
}
