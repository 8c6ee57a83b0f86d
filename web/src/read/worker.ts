// Reads a scan in a thread of its own, so that the page stays responsive. One worker reads one file: ending it cancels.
import {limits, ReadError, type Fault} from './bytes';
import type {ShownMesh} from './cluster';
import {prepare, type ReadScan} from './prepare';

export type FromWorker =
  | {kind: 'progress'; share: number}
  | {kind: 'scan'; scan: ReadScan}
  | {kind: 'fault'; fault: Fault | 'failed'; where: ReadError['where']; detail: string};

const scope = globalThis as unknown as {
  onmessage: ((event: MessageEvent<File>) => void) | null;
  postMessage(message: FromWorker, transfer?: Transferable[]): void;
};
const buffers = (mesh: ShownMesh | null): Transferable[] =>
  mesh ? [mesh.positions.buffer, mesh.indices.buffer, mesh.normals.buffer] as ArrayBuffer[] : [];

async function answer(file: File): Promise<void> {
  try {
    if (file.size > limits.bytes) throw new ReadError('too_large');
    const bytes = new Uint8Array(await file.arrayBuffer());
    const scan = prepare(bytes, file.name, (share) => scope.postMessage({kind: 'progress', share}));
    scope.postMessage({kind: 'scan', scan}, [...buffers(scan.shown), ...buffers(scan.coarse)]);
  } catch (error) {
    const known = error instanceof ReadError ? error : null;
    scope.postMessage({kind: 'fault', fault: known?.fault ?? 'failed', where: known?.where ?? null,
                       detail: known?.detail ?? String(error)});
  }
}
scope.onmessage = (event) => void answer(event.data);
