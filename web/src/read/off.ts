import {hashComment, MeshBuilder, ReadError, Words, type Progress, type ScanMesh} from './bytes';

const heads = ['OFF', 'COFF', 'NOFF', 'CNOFF', 'STOFF', 'STCNOFF'];

export const isOff = (bytes: Uint8Array): boolean => heads.includes(new Words(bytes.subarray(0, 64), hashComment).next());

export function readOff(bytes: Uint8Array, progress: Progress): ScanMesh {
  const words = new Words(bytes, hashComment), mesh = new MeshBuilder();
  words.next();
  const points = words.count(), faces = words.count();
  words.skipLine();  // the number of edges
  if (2 * (points + faces) > bytes.length) throw words.fault('header');
  for (let k = 0; k < points; ++k) {
    if (k % 65536 === 0) progress(words.at / bytes.length);
    mesh.point(words.number(), words.number(), words.number());
    words.skipLine();  // colour, normal
  }
  for (let k = 0; k < faces; ++k) {
    if (k % 65536 === 0) progress(words.at / bytes.length);
    const corners: number[] = [], count = words.count();
    if (2 * count > bytes.length) throw words.fault('number');
    for (let i = 0; i < count; ++i) {
      const index = words.numberInLine();
      if (Number.isNaN(index)) throw new ReadError('ends', {unit: 'line', at: words.line});
      if (!(index >= 0 && index < points && Number.isInteger(index))) throw words.fault('index');
      corners.push(index);
    }
    mesh.polygon(corners);
    words.skipLine();  // colour
  }
  return mesh.finish('OFF');
}
