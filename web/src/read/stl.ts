import {MeshBuilder, ReadError, Words, type Progress, type ScanMesh} from './bytes';

const facetBytes = 50, headerBytes = 84;

const counted = (bytes: Uint8Array): number => new DataView(bytes.buffer, bytes.byteOffset).getUint32(80, true);

export function isBinaryStl(bytes: Uint8Array): boolean {
  return bytes.length >= headerBytes && headerBytes + facetBytes * counted(bytes) === bytes.length;
}

// "solid" and, on a later line, "facet" or "endsolid".
export function isAsciiStl(bytes: Uint8Array): boolean {
  const words = new Words(bytes.subarray(0, 4096));
  if (words.next() !== 'solid') return false;
  for (words.skipLine(); !words.ended; words.skipLine()) {
    const word = words.next();
    if (word === 'facet' || word === 'endsolid') return true;
  }
  return false;
}

export function readBinaryStl(bytes: Uint8Array, progress: Progress): ScanMesh {
  if (!isBinaryStl(bytes)) throw new ReadError('ends', {unit: 'byte', at: bytes.length});
  const count = counted(bytes), mesh = new MeshBuilder(), view = new DataView(bytes.buffer, bytes.byteOffset);
  for (let k = 0; k < count; ++k) {
    if (k % 65536 === 0) progress(k / count);
    for (let at = headerBytes + facetBytes * k + 12, corner = 0; corner < 3; ++corner, at += 12)
      mesh.point(view.getFloat32(at, true), view.getFloat32(at + 4, true), view.getFloat32(at + 8, true));
    mesh.triangle(3 * k, 3 * k + 1, 3 * k + 2);
  }
  return mesh.finish('STL (binary)');
}

export function readAsciiStl(bytes: Uint8Array, progress: Progress): ScanMesh {
  const words = new Words(bytes), mesh = new MeshBuilder();
  let started = 0;  // the first corner of the facet that is open
  for (let ended = false; !ended || !words.ended;) {
    const word = words.next();
    if (word === 'vertex') {
      if (mesh.points % 65536 === 0) progress(words.at / bytes.length);
      mesh.point(words.number(), words.number(), words.number());
      if (mesh.points - started >= 3) mesh.triangle(started, mesh.points - 2, mesh.points - 1);
    } else if (word === 'endfacet') {
      if (mesh.points - started < 3) throw words.fault('number');
      started = mesh.points;
    } else if (word === 'solid' || word === 'endsolid') {
      words.skipLine();
      ended = word === 'endsolid';
    } else if (word === 'facet') {
      words.skipLine();  // the normal
    } else if (word === '') {
      throw new ReadError('ends', {unit: 'line', at: words.line});
    } else if (word !== 'outer' && word !== 'loop' && word !== 'endloop') {
      throw words.fault('number');
    }
  }
  return mesh.finish('STL (ASCII)');
}
