// Requests to the API of this server. Every failure is a Problem.
import type {
  Job, JobPage, LogLine, Plan, ProblemBody, Profile, Session, SettingsSchema, TokenInfo} from './types';

export class Problem extends Error {
  constructor(readonly body: ProblemBody, readonly requestId = '') {
    super(body.what ?? body.title);
  }
  get code(): string {
    return this.body.type.split('/').pop() ?? '';
  }
  get status(): number {
    return this.body.status;
  }
}

// The server cannot be reached: not an answer of it. Code "no-server", status 0.
export const noServer = (error: unknown): Problem => new Problem({type: 'no-server', title: '', status: 0, what: String(error)});

// A problem that findings.json names by its code.
export type FoundProblem = Pick<ProblemBody, 'what' | 'where' | 'fix'> & {code: string};
export const foundProblem = ({code, ...found}: FoundProblem): Problem => new Problem({...found, type: code, title: '', status: 422});

let signedOut = (): void => {};
// What to do when the session has ended.
export function onSignedOut(handler: () => void): void {
  signedOut = handler;
}

export async function ask(path: string, init: RequestInit = {}): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(path, {credentials: 'same-origin', redirect: 'error', ...init});
  } catch (error) {
    if (init.signal?.aborted) throw error;
    throw noServer(error);
  }
  if (response.ok || response.status === 304) return response;
  throw await problemOf(response);
}

// Of any answer that is one. Ends the session of the page if the server has ended it.
export async function problemOf(response: Response): Promise<Problem> {
  if (response.status === 401) signedOut();
  const id = response.headers.get('X-Request-Id') ?? '';
  try {
    if (response.headers.get('Content-Type')?.includes('json'))
      return new Problem(await response.json() as ProblemBody, id);
  } catch {
    // an answer that is not what its header says is treated like one of a proxy, below
  }
  return new Problem({type: 'about:blank', title: response.statusText, status: response.status}, id);
}

const read = async <T>(path: string, signal?: AbortSignal): Promise<T> =>
  await (await ask(path, signal ? {signal} : {})).json() as T;
const send = async (method: string, path: string, body?: unknown, headers: Record<string, string> = {}): Promise<Response> =>
  ask(path, body === undefined
                ? {method, headers}
                : {method, headers: {'Content-Type': 'application/json', ...headers}, body: JSON.stringify(body)});

export const hex = (bytes: Iterable<number>): string => [...bytes].map((byte) => byte.toString(16).padStart(2, '0')).join('');
export const randomKey = (): string => hex(crypto.getRandomValues(new Uint8Array(16)));

const v1 = '/api/v1';
export const jobPath = (id: string): string => `${v1}/jobs/${encodeURIComponent(id)}`;
export const artifactPath = (id: string, name: string): string => `${jobPath(id)}/artifacts/${encodeURIComponent(name)}`;

export interface JobQuery {
  limit?: number;
  cursor?: string;
  state?: string;
  kind?: string;
  owner?: string;
  text?: string;
  created_after?: string;
  created_before?: string;
}

export const api = {
  session: (): Promise<Session> => read(`${v1}/session`),
  jobs: (query: JobQuery, signal?: AbortSignal): Promise<JobPage> => {
    const given = Object.entries(query).filter(([, value]) => value !== undefined && value !== '');
    return read(`${v1}/jobs?${new URLSearchParams(given.map(([name, value]) => [name, String(value)]))}`, signal);
  },
  job: (id: string, signal?: AbortSignal): Promise<Job> => read(jobPath(id), signal),
  log: (id: string, after = 0): Promise<{lines: LogLine[]; next: number; ended: boolean}> =>
    read(`${jobPath(id)}/log?after=${after}&limit=1000`),
  cancel: async (id: string): Promise<Job> => await (await ask(`${jobPath(id)}/cancel`, {method: 'POST'})).json() as Job,
  // `version`: of the job that the person saw.
  setReference: async (id: string, reference: string, rescan: boolean, version: number): Promise<Job> =>
    await (await send('PATCH', jobPath(id), {reference, ...(rescan && {rescan})}, {'If-Match': `"${version}"`})).json() as Job,
  remove: async (id: string): Promise<void> => void await send('DELETE', jobPath(id)),
  artifact: async (id: string, name: string, signal?: AbortSignal): Promise<Response> =>
    ask(artifactPath(id, name), signal ? {signal} : {}),
  artifactJson: <T>(id: string, name: string, signal?: AbortSignal): Promise<T> => read(artifactPath(id, name), signal),
  // `key`: one randomKey() makes one job, however often it is sent.
  create: async (form: FormData, key: string): Promise<Job> =>
    await (await ask(`${v1}/jobs`, {method: 'POST', body: form, headers: {'Idempotency-Key': key}})).json() as Job,
  validate: async (form: FormData, signal?: AbortSignal): Promise<Plan> =>
    await (await ask(`${v1}/validate`, {method: 'POST', body: form, ...(signal && {signal})})).json() as Plan,
  schema: (): Promise<SettingsSchema> => read(`${v1}/settings-schema`),
  limits: (): Promise<Record<string, unknown>> => read(`${v1}/limits`),
  profiles: (): Promise<{profiles: Profile[]; next: string | null}> => read(`${v1}/profiles?limit=100`),
  // `condition`: {'If-None-Match': '*'} creates and never replaces; {'If-Match': ETag} replaces only what was read.
  putProfile: (name: string, settings: unknown, condition: Record<string, string> = {}): Promise<Response> =>
    send('PUT', `${v1}/profiles/${encodeURIComponent(name)}`, settings, condition),
  profile: async (name: string): Promise<{profile: Profile; etag: string}> => {
    const response = await ask(`${v1}/profiles/${encodeURIComponent(name)}`);
    return {profile: await response.json() as Profile, etag: response.headers.get('ETag') ?? ''};
  },
  setDefaultProfile: (name: string, isDefault: boolean): Promise<Response> =>
    send(isDefault ? 'PUT' : 'DELETE', `${v1}/profiles/${encodeURIComponent(name)}/default`),
  removeProfile: (name: string): Promise<Response> => send('DELETE', `${v1}/profiles/${encodeURIComponent(name)}`),
  tokens: (): Promise<{tokens: TokenInfo[]}> => read(`${v1}/tokens`),
  createToken: async (body: {owner: string; scopes: string[]; days?: number}): Promise<TokenInfo & {token: string}> =>
    await (await send('POST', `${v1}/tokens`, body)).json() as TokenInfo & {token: string},
  createSignInLink: async (id: string): Promise<{path: string}> =>
    await (await send('POST', `${v1}/tokens/${encodeURIComponent(id)}/link`)).json() as {path: string},
  revokeToken: (id: string): Promise<Response> => send('DELETE', `${v1}/tokens/${encodeURIComponent(id)}`),
  service: <T>(): Promise<T> => read(`${v1}/service`),
};
