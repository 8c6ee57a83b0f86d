// Starts the worker that reads scans. The only script that this page starts by its address.
import type {ReadScan} from '../read/prepare';
import type {FromWorker} from '../read/worker';

interface TrustedTypes {
  createPolicy(name: string, rules: {createScriptURL(url: string): string}): {createScriptURL(url: string): string};
}
const address = document.querySelector<HTMLMetaElement>('meta[name="read-worker"]')?.content ?? '';
const rules = {
  createScriptURL(url: string): string {
    if (url !== address) throw new TypeError(`not a worker of this page: ${url}`);
    return url;
  },
};
const policy = (globalThis as {trustedTypes?: TrustedTypes}).trustedTypes?.createPolicy('vacuform', rules) ?? rules;

// Why a scan cannot be read; see read/bytes.ts.
export class ScanFault extends Error {
  constructor(readonly body: Extract<FromWorker, {kind: 'fault'}>) {
    super(body.fault);
  }
}

// Throws ScanFault, or the reason of `signal` when that ends it.
export function readScanFile(file: File, progress: (share: number) => void, signal: AbortSignal): Promise<ReadScan> {
  return new Promise((resolve, reject) => {
    const worker = new Worker(policy.createScriptURL(address), {type: 'module'});
    const end = (): void => {
      worker.terminate();
      signal.removeEventListener('abort', stop);
    };
    const stop = (): void => {
      end();
      reject(signal.reason as Error);
    };
    signal.addEventListener('abort', stop);
    const fail = (detail: string): void => {
      end();
      reject(new ScanFault({kind: 'fault', fault: 'failed', where: null, detail}));
    };
    worker.onerror = (event) => fail(event.message ?? '');
    worker.onmessage = ({data}: MessageEvent<FromWorker>) => {
      if (data.kind === 'progress') {
        progress(data.share);
        return;
      }
      end();
      if (data.kind === 'scan') resolve(data.scan);
      else reject(new ScanFault(data));
    };
    worker.postMessage(file);
  });
}
