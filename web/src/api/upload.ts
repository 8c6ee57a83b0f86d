// Sends a large file in pieces by tus 1.0.0. It resumes where the server stands after every failure, and after a reload of
// the page when the same file is given again. tus-js-client speaks the protocol and is loaded with the first upload. This file
// decides what a failure means and when to try again.
import type {DetailedError, HttpRequest, HttpResponse, Upload as Tus} from 'tus-js-client';
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
export const pieceBytes = 2 * 1024 * 1024;
const idleLimit = 30_000;  // ms without progress after which a connection counts as dead
const longestPause = 30_000;
const forgiven = 4;        // failures in a row that are the server's answer and not the network's
const patient = [0, 423, 429, 503];  // no answer, or one that asks for patience
const passing = [...patient, 404, 408, 409, 410, 460, 500, 502, 504];  // another attempt may end otherwise

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
  ask(path(id), {method: 'DELETE', headers: {'Tus-Resumable': '1.0.0'}}).catch(() => {});  // it expires anyway
}

// Returns at once; the file is on its way until `watcher` hears that it is done or failed.
export function startUpload(source: Source, watcher: Watcher): Upload {
  const upload = new Sending(source, watcher);
  upload.resume();
  return upload;
}

class Sending implements Upload {
  #id: string | null;
  #state: TransferState = 'paused';
  #tus: Tus | null = null;
  #turn = {};         // another one whenever an attempt ends: what an older attempt still reports is ignored
  #failures = 0;      // in a row
  #answers = 0;       // of these, the server's
  #timer = 0;         // ends an idle connection or a pause
  #checksum = '';     // of the piece that is sent next
  #told = 0;          // when the progress was told last
  #samples: {time: number; sent: number}[] = [];

  constructor(private readonly source: Source, private readonly watcher: Watcher) {
    this.#id = source.id;
    globalThis.addEventListener?.('online', this.#goOn);
  }

  pause(): void {
    if (this.#state === 'done' || this.#state === 'paused') return;
    this.#halt();
    this.#state = 'paused';
    this.#tell();
  }
  resume(): void {
    if (this.#state === 'done' || this.#state === 'sending') return;
    this.#state = 'sending';
    this.#failures = this.#answers = 0;
    this.#samples = [];
    void this.#attempt();
  }
  abort(): void {
    this.#end();
    if (this.#id) removeUpload(this.#id);
  }

  #tell(sent = this.#samples.at(-1)?.sent ?? 0, problem: Problem | null = null): void {
    const time = this.#told = Date.now(), bytes = this.source.file.size, state = this.#state;
    if (state === 'sending') this.#samples = [...this.#samples.filter((sample) => time - sample.time < 8000), {time, sent}];
    const first = this.#samples[0];
    const seconds = first ? (time - first.time) / 1000 : 0;
    const speed = first && seconds > 0.5 && sent > first.sent ? (sent - first.sent) / seconds : null;
    this.watcher.progress({state, sent, bytes, speed, left: speed && (bytes - sent) / speed, problem});
  }

  // One attempt: from the offset that the server has to the end, or to the first failure.
  async #attempt(): Promise<void> {
    this.#halt();
    const turn = this.#turn, over = (): boolean => turn !== this.#turn;
    try {
      const {Upload: Client} = await import('tus-js-client');
      if (over()) return;
      const tus = this.#tus = new Client(this.source.file, {
        endpoint: uploads, chunkSize: pieceBytes, retryDelays: null, storeFingerprintForResuming: false,
        metadata: {filename: `file.${this.source.extension}`, input: this.source.input},
        fileReader: {openFile: async () => ({size: this.source.file.size, slice: (from, to) => this.#slice(from, to), close() {}})},
        onBeforeRequest: (request) => {
          if (over()) throw new Error('the attempt is over');
          this.#watch();
          if (request.getMethod() === 'PATCH' && this.#checksum) request.setHeader('Upload-Checksum', this.#checksum);
        },
        onAfterResponse: (request, response) => this.#check(request, response),
        onUploadUrlAvailable: () => {
          const id = tus.url?.split('/').pop() ?? '';
          if (id !== this.#id) this.watcher.started(this.#id = id);
        },
        onProgress: (sent) => {
          if (over()) return;
          this.#watch();
          if (Date.now() - this.#told >= 200) this.#tell(sent);
        },
        onChunkComplete: () => { this.#failures = this.#answers = 0; },
        onSuccess: () => {
          this.#end();
          this.#tell(this.source.file.size);
          this.watcher.done(this.#id ?? '');
        },
        onError: (error) => {
          const cause = (error as DetailedError).causingError;
          if (!over()) this.#recover(cause instanceof Problem ? cause : noServer(error));
        }});
      this.#told = 0;
      tus.url = this.#id && path(this.#id);
      tus.start();
    } catch (error) {
      if (!over()) this.#recover(noServer(error));  // the library cannot be loaded
    }
  }

  async #slice(from: number, to: number): Promise<{value: Blob; done: boolean}> {
    const value = this.source.file.slice(from, to);
    const bytes = await value.arrayBuffer().catch(() => {
      throw new Problem({type: 'file-changed', title: '', status: 400});  // on the disk of the person
    });
    const hash = await digest(bytes);
    this.#checksum = hash ? `sha256 ${btoa(String.fromCharCode(...hash))}` : '';
    return {value, done: to >= this.source.file.size};
  }

  #watch(): void {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#recover(noServer('')), idleLimit);
  }

  // Throws a Problem for an answer after which the attempt cannot go on.
  async #check(request: HttpRequest, response: HttpResponse): Promise<void> {
    clearTimeout(this.#timer);
    const status = response.getStatus();
    if (status >= 300) {
      const headers = ['Content-Type', 'X-Request-Id'].map((name): [string, string] => [name, response.getHeader(name) ?? '']);
      throw await problemOf(new Response(response.getBody(), {status, headers}));
    }
    if (request.getMethod() === 'HEAD' && Number(response.getHeader('Upload-Length')) !== this.source.file.size)
      throw new Problem({type: 'about:blank', title: '', status: 410});  // of another file
  }

  // Tries again at once or after a pause, or gives up.
  #recover(problem: Problem): void {
    const {status} = problem;
    this.#halt();
    this.#samples = this.#samples.slice(-1);
    if (!passing.includes(status) || (!patient.includes(status) && ++this.#answers > forgiven)) {
      this.#state = 'failed';
      this.#tell(0, problem);
      return;
    }
    if (status === 404 || status === 410) this.#id = null;  // expired or deleted: begin again
    if (++this.#failures === 1 && status === 409) {
      void this.#attempt();  // asks for the offset
      return;
    }
    this.#state = 'waiting';
    this.#tell(undefined, status > 0 ? problem : null);
    this.#timer = setTimeout(this.#goOn, Math.min(longestPause, 500 * 2 ** Math.min(this.#failures, 10)));
  }
  readonly #goOn = (): void => {
    if (this.#state !== 'waiting') return;
    this.#state = 'sending';
    void this.#attempt();
  };

  // Ends the attempt or the pause.
  #halt(): void {
    this.#turn = {};
    clearTimeout(this.#timer);
    void this.#tus?.abort();
  }
  #end(): void {
    this.#halt();
    this.#state = 'done';
    globalThis.removeEventListener?.('online', this.#goOn);
  }
}
