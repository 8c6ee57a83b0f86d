// A scan as the page needs it: its facts, and meshes for the screen.
import type {Progress} from './bytes';
import {forScreen, type ShownMesh} from './cluster';
import {factsOf, type ScanFacts} from './facts';
import {readScan} from './scan';

export interface ReadScan {
  facts: ScanFacts;
  shown: ShownMesh;          // in the unit and axes of the file
  coarse: ShownMesh | null;  // for a view that moves on a slow machine; null if the other one is small
}

const mostShown = 500_000, coarseTriangles = 40_000;

export function prepare(bytes: Uint8Array, name: string, progress?: Progress): ReadScan {
  const mesh = readScan(bytes, name, progress);
  const facts = factsOf(mesh), shown = forScreen(mesh, mostShown);
  const coarse = shown.indices.length > 3 * 1.5 * coarseTriangles ? forScreen(shown, coarseTriangles) : null;
  return {facts, shown, coarse};
}
