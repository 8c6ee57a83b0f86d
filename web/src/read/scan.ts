// Reads a scan: STL, OBJ, PLY, OFF or GLB, told by its bytes, otherwise by the end of its name. Throws ReadError.
import {limits, ReadError, type Progress, type ScanMesh} from './bytes';
import {isGlb, readGlb} from './glb';
import {isObj, readObj} from './obj';
import {isOff, readOff} from './off';
import {isPly, readPly} from './ply';
import {isAsciiStl, isBinaryStl, readAsciiStl, readBinaryStl} from './stl';

const foreign: [string, RegExp][] = [
  ['ZIP', /^PK\x03\x04/], ['gzip', /^\x1f\x8b/], ['FBX', /^Kaydara FBX/], ['PNG', /^\x89PNG/], ['JPEG', /^\xff\xd8\xff/],
  ['PDF', /^%PDF/], ['STEP', /^ISO-10303-21/], ['VTK', /^# vtk DataFile/], ['DICOM', /^[^]{128}DICM/],
  ['NIfTI', /^[^]{344}n[+i]1/], ['glTF', /^\s*\{[^]*"asset"/], ['XML', /^\s*(<\?xml|<COLLADA|<svg)/], ['HTML', /^\s*<(!DOCTYPE|html)/i]];

export function readScan(bytes: Uint8Array, name: string, progress: Progress = () => {}): ScanMesh {
  if (bytes.length === 0) throw new ReadError('empty');
  if (bytes.length > limits.bytes) throw new ReadError('too_large');
  const extension = /\.(\w+)$/.exec(name)?.[1]?.toLowerCase();
  try {
    if (isGlb(bytes)) return readGlb(bytes, progress);
    if (isPly(bytes)) return readPly(bytes, progress);
    if (isBinaryStl(bytes)) return readBinaryStl(bytes, progress);
    if (isAsciiStl(bytes)) return readAsciiStl(bytes, progress);
    if (isOff(bytes)) return readOff(bytes, progress);
    if (isObj(bytes)) return readObj(bytes, progress);
    const head = String.fromCharCode(...bytes.subarray(0, 512));
    const kind = foreign.find(([, pattern]) => pattern.test(head));
    if (kind) throw new ReadError('foreign', null, kind[0]);
    if (extension === 'stl') return readBinaryStl(bytes, progress);
    if (extension === 'obj') return readObj(bytes, progress);
  } catch (error) {
    // the bytes were changed on their way, which explains the fault better than its place
    throw error instanceof ReadError && error.fault !== 'foreign' && wasCopiedAsText(bytes) ? new ReadError('damaged') : error;
  }
  throw new ReadError('unknown');
}

// Bytes that are no text and were treated as such: replaced by U+FFFD, or every line feed became CR LF.
function wasCopiedAsText(bytes: Uint8Array): boolean {
  let replaced = 0, high = 0, zeros = 0, feeds = 0, returns = 0;
  for (let i = 0; i < bytes.length; ++i) {
    const byte = bytes[i]!;
    if (byte >= 128) ++high;
    else if (byte === 0) ++zeros;
    else if (byte === 10 && bytes[i - 1] === 13) ++returns;
    if (byte === 10) ++feeds;
    if (byte === 0xEF && bytes[i + 1] === 0xBF && bytes[i + 2] === 0xBD) ++replaced;
  }
  return (replaced >= 16 && 6 * replaced > high) || (zeros > 16 && feeds >= 16 && returns === feeds);
}
