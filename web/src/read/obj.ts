import {hashComment, MeshBuilder, ReadError, Words, type Progress, type ScanMesh} from './bytes';

const others = ['mtllib', 'o', 'g', 's', 'usemtl', 'vn', 'vt', 'vp', 'l', 'p'];

export function isObj(bytes: Uint8Array): boolean {
  const words = new Words(bytes.subarray(0, 65536), hashComment);
  while (!words.ended) {
    const word = words.next();
    if (word === 'v') return true;
    if (!others.includes(word)) return false;
    words.skipLine();
  }
  return false;
}

export function readObj(bytes: Uint8Array, progress: Progress): ScanMesh {
  const words = new Words(bytes, hashComment), mesh = new MeshBuilder();
  for (let row = 0; !words.ended; ++row) {
    if (row % 65536 === 0) progress(words.at / bytes.length);
    const word = words.next();
    if (word === 'v') {
      const x = words.numberInLine(), y = words.numberInLine(), z = words.numberInLine();
      if (Number.isNaN(x + y + z)) throw words.fault('number');
      mesh.point(x, y, z);
    } else if (word === 'f') {
      const corners: number[] = [];
      for (let text = words.inLine(); text !== ''; text = words.inLine()) {
        const given = Number.parseInt(text, 10), index = given < 0 ? mesh.points + given : given - 1;
        if (!(index >= 0 && index < 2 ** 32) || !/^-?\d+(\/|$)/.test(text)) throw words.fault('index');
        corners.push(index);
      }
      if (corners.length < 3) throw new ReadError('number', {unit: 'line', at: words.line}, 'f');
      mesh.polygon(corners);
    }
    words.skipLine();
  }
  return mesh.finish('OBJ');
}
