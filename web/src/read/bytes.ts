// What the readers of scans share: the fault that they throw, arrays that grow, words and numbers of a text.

export type Fault =
  | 'empty' | 'too_large' | 'unknown' | 'foreign' | 'damaged'  // the file as a whole
  | 'header' | 'ends' | 'number' | 'index' | 'no_triangles' | 'too_many' | 'far'  // its content
  | 'compressed' | 'outside' | 'sparse';  // GLB

// A file that cannot be read. `where`: the byte, line or element, counted from 1 (bytes from 0).
export class ReadError extends Error {
  constructor(readonly fault: Fault, readonly where: {unit: 'byte' | 'line' | 'accessor' | 'node'; at: number} | null = null,
              readonly detail = '') {
    super(fault);
  }
}

export const limits = {bytes: 256e6, triangles: 5e6, coordinate: 1e7};

export interface Mesh {
  positions: Float32Array;  // xyz
  indices: Uint32Array;     // three of a triangle
}
export interface ScanMesh extends Mesh {
  format: string;
  yUp: boolean;  // the format itself says that +y is up and +z is the front
}
export type Progress = (share: number) => void;

export class MeshBuilder {
  #points = new Float32Array(3 * 1024);
  #corners = new Uint32Array(3 * 1024);
  points = 0;
  triangles = 0;

  point(x: number, y: number, z: number): void {
    if (!(Math.abs(x) <= limits.coordinate && Math.abs(y) <= limits.coordinate && Math.abs(z) <= limits.coordinate))
      throw new ReadError('far', null, [x, y, z].join(' '));
    let at = 3 * this.points++;
    if (at + 3 > this.#points.length) {
      const more = new Float32Array(2 * this.#points.length);
      more.set(this.#points);
      this.#points = more;
    }
    this.#points[at++] = x;
    this.#points[at++] = y;
    this.#points[at] = z;
  }
  triangle(a: number, b: number, c: number): void {
    let at = 3 * this.triangles++;
    if (this.triangles > limits.triangles) throw new ReadError('too_many');
    if (at + 3 > this.#corners.length) {
      const more = new Uint32Array(2 * this.#corners.length);
      more.set(this.#corners);
      this.#corners = more;
    }
    this.#corners[at++] = a;
    this.#corners[at++] = b;
    this.#corners[at] = c;
  }
  // A polygon as a fan. Its corners are checked at the end.
  polygon(corners: number[]): void {
    for (let k = 2; k < corners.length; ++k) this.triangle(corners[0]!, corners[k - 1]!, corners[k]!);
  }
  // Throws if there is no triangle, or if one has a corner that does not exist.
  finish(format: string, yUp = false): ScanMesh {
    if (this.triangles === 0) throw new ReadError('no_triangles');
    const indices = this.#corners.slice(0, 3 * this.triangles);
    for (let i = 0; i < indices.length; ++i)
      if (indices[i]! >= this.points) throw new ReadError('index', null, String(indices[i]! + 1));
    return {positions: this.#points.slice(0, 3 * this.points), indices, format, yUp};
  }
}

const newline = 10, hash = 35;
const isSpace = (byte: number | undefined): boolean => byte === 32 || (byte !== undefined && byte >= 9 && byte <= 13);

// Words of a text in bytes, line by line. A number is read without a string, since a scan has millions of them.
export class Words {
  at = 0;
  line = 1;
  #begin = 0;  // of the last word
  constructor(readonly bytes: Uint8Array, private readonly comment = 0) {}

  get ended(): boolean {
    this.#skip(true);
    return this.at >= this.bytes.length;
  }
  // Goes to the next word; false at the end of the line (or of the text).
  #skip(overLines: boolean): boolean {
    const bytes = this.bytes;
    for (; this.at < bytes.length; ++this.at) {
      const byte = bytes[this.at]!;
      if (byte === this.comment && this.comment) {
        while (this.at < bytes.length && bytes[this.at] !== newline) ++this.at;
        --this.at;
      } else if (byte === newline) {
        if (!overLines) return false;
        ++this.line;
      } else if (!isSpace(byte)) return true;
    }
    return false;
  }
  // The next word, also of another line; empty at the end.
  next(): string {
    this.#skip(true);
    return this.#word();
  }
  // The next word of this line; empty at its end.
  inLine(): string {
    return this.#skip(false) ? this.#word() : '';
  }
  #word(): string {
    const begin = this.#begin = this.at, bytes = this.bytes;
    let text = '';
    while (this.at < bytes.length && !isSpace(bytes[this.at]) && this.at - begin < 200)
      text += String.fromCharCode(bytes[this.at++]!);
    return text;
  }
  skipLine(): void {
    while (this.at < this.bytes.length && this.bytes[this.at] !== newline) ++this.at;
  }
  // The next number, also of another line. Throws if the word is not a number.
  number(): number {
    if (!this.#skip(true)) throw new ReadError('ends', {unit: 'line', at: this.line});
    return this.#number();
  }
  // The next number of this line, NaN at its end.
  numberInLine(): number {
    return this.#skip(false) ? this.#number() : NaN;
  }
  #number(): number {
    const bytes = this.bytes, begin = this.#begin = this.at;
    let at = begin, value = 0, digits = 0, decimals = 0;
    const sign = bytes[at] === 45 ? -1 : 1;
    if (bytes[at] === 45 || bytes[at] === 43) ++at;
    for (let point = false; ; ++at) {
      const byte = bytes[at]!;
      if (byte >= 48 && byte <= 57) {
        value = 10 * value + byte - 48;
        ++digits;
        if (point) ++decimals;
      } else if (byte === 46 && !point) point = true;
      else break;
    }
    this.at = at;
    if (digits > 0 && digits <= 15 && (at >= bytes.length || isSpace(bytes[at]))) return sign * value / 10 ** decimals;
    this.at = begin;  // an exponent, more digits than a double holds, or no number
    const word = this.#word(), number = Number(word);
    if (word === '' || Number.isNaN(number)) throw new ReadError('number', {unit: 'line', at: this.line}, word.slice(0, 40));
    return number;
  }
  // The next whole number of at least 0, also of another line.
  count(): number {
    const value = this.number();
    if (!(value >= 0 && Number.isInteger(value))) throw this.fault('number');
    return value;
  }
  fault(fault: Fault): ReadError {
    const word = new TextDecoder().decode(this.bytes.subarray(this.#begin, Math.min(this.at, this.#begin + 40)));
    return new ReadError(fault, {unit: 'line', at: this.line}, word);
  }
}
export const hashComment = hash;
