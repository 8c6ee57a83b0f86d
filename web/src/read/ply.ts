import {MeshBuilder, ReadError, Words, type Progress, type ScanMesh} from './bytes';

const sizes: Record<string, number> = {
  char: 1, uchar: 1, short: 2, ushort: 2, int: 4, uint: 4, float: 4, double: 8,
  int8: 1, uint8: 1, int16: 2, uint16: 2, int32: 4, uint32: 4, float32: 4, float64: 8};

interface Property {
  name: string;
  type: string;
  count: string;  // the type of a list's length; empty for a single value
}
interface Element {
  name: string;
  rows: number;
  properties: Property[];
}

export function isPly(bytes: Uint8Array): boolean {
  return bytes[0] === 112 && bytes[1] === 108 && bytes[2] === 121 && (bytes[3] === 10 || bytes[3] === 13);
}

function readHeader(words: Words): {format: string; elements: Element[]} {
  const elements: Element[] = [];
  let format = '';
  words.next();
  for (;;) {
    if (words.ended) throw new ReadError('ends', {unit: 'line', at: words.line});
    const word = words.next();
    if (word === 'end_header') break;
    if (word === 'format') format = words.inLine();
    else if (word === 'element') {
      elements.push({name: words.inLine(), rows: words.numberInLine(), properties: []});
      const rows = elements[elements.length - 1]!.rows;
      if (!(rows >= 0 && Number.isInteger(rows)) || elements.length > 256) throw words.fault('header');
    } else if (word === 'property') {
      const element = elements[elements.length - 1];
      let type = words.inLine(), count = '';
      if (type === 'list') {
        count = words.inLine();
        type = words.inLine();
        if (!sizes[count] || /float|double/.test(count)) throw words.fault('header');
      }
      if (!element || !sizes[type] || element.properties.length > 1024) throw words.fault('header');
      element.properties.push({type, count, name: words.inLine()});
    } else if (word !== 'comment' && word !== 'obj_info') throw words.fault('header');
    words.skipLine();
  }
  words.skipLine();
  ++words.at;  // the line feed
  if (!/^(ascii|binary_(little|big)_endian)$/.test(format)) throw new ReadError('header', {unit: 'line', at: 2}, format);
  return {format, elements};
}

// Values of the body one after the other, whatever its encoding.
class Values {
  readonly #view: DataView;
  constructor(private readonly words: Words, private readonly ascii: boolean, private readonly little: boolean) {
    this.#view = new DataView(words.bytes.buffer, words.bytes.byteOffset, words.bytes.length);
  }
  get left(): number {
    return this.words.bytes.length - this.words.at;
  }
  fault(fault: 'ends' | 'index' | 'number'): ReadError {
    return this.ascii ? this.words.fault(fault) : new ReadError(fault, {unit: 'byte', at: this.words.at});
  }
  next(type: string): number {
    if (this.ascii) return this.words.number();
    const at = this.words.at, little = this.little, view = this.#view;
    if (at + sizes[type]! > view.byteLength) throw new ReadError('ends', {unit: 'byte', at: view.byteLength});
    this.words.at += sizes[type]!;
    switch (type) {
      case 'float': case 'float32': return view.getFloat32(at, little);
      case 'double': case 'float64': return view.getFloat64(at, little);
      case 'char': case 'int8': return view.getInt8(at);
      case 'uchar': case 'uint8': return view.getUint8(at);
      case 'short': case 'int16': return view.getInt16(at, little);
      case 'ushort': case 'uint16': return view.getUint16(at, little);
      case 'int': case 'int32': return view.getInt32(at, little);
      default: return view.getUint32(at, little);
    }
  }
}

export function readPly(bytes: Uint8Array, progress: Progress): ScanMesh {
  const words = new Words(bytes), mesh = new MeshBuilder();
  const {format, elements} = readHeader(words);
  const ascii = format === 'ascii', values = new Values(words, ascii, format === 'binary_little_endian');
  for (const {name, rows, properties} of elements) {
    const least = properties.reduce((sum, p) => sum + (ascii ? 2 : sizes[p.count || p.type]!), 0);
    if (least === 0) continue;
    if (rows > (values.left + 1) / least) throw new ReadError('ends', {unit: 'byte', at: bytes.length});
    const axes = properties.map((p) => name === 'vertex' && !p.count ? ['x', 'y', 'z'].indexOf(p.name) : -1);
    if (name === 'vertex' && [0, 1, 2].some((axis) => !axes.includes(axis))) throw new ReadError('header');
    const isFace = (p: Property): boolean =>
      /^vertex_ind(ices|ex)$/.test(p.name) && (name === 'face' || name === 'tristrips');
    const point = [0, 0, 0];
    for (let row = 0; row < rows; ++row) {
      if (row % 65536 === 0) progress(words.at / bytes.length);
      for (let k = 0; k < properties.length; ++k) {
        const property = properties[k]!;
        if (!property.count) {
          const value = values.next(property.type);
          if (axes[k]! >= 0) point[axes[k]!] = value;
          continue;
        }
        const length = values.next(property.count);
        if (!(length >= 0 && Number.isInteger(length)) || length > values.left) throw values.fault('ends');
        if (!isFace(property)) {
          for (let i = 0; i < length; ++i) values.next(property.type);
          continue;
        }
        let corners: number[] = [];
        const add = (): void => name === 'face' ? mesh.polygon(corners) : strip(mesh, corners);
        for (let i = 0; i < length; ++i) {
          const index = values.next(property.type);
          if (index === -1 && name === 'tristrips') {
            add();
            corners = [];
          } else if (index >= 0 && index < 2 ** 32 && Number.isInteger(index)) corners.push(index);
          else throw values.fault('index');
        }
        add();
      }
      if (name === 'vertex') mesh.point(point[0]!, point[1]!, point[2]!);
    }
  }
  return mesh.finish(`PLY (${ascii ? 'ASCII' : format === 'binary_big_endian' ? 'big-endian' : 'little-endian'})`);
}

// Every other triangle runs the other way; those that name a corner twice only join two parts.
function strip(mesh: MeshBuilder, corners: number[]): void {
  for (let k = 2; k < corners.length; ++k) {
    const a = corners[k - 2]!, b = corners[k - 1]!, c = corners[k]!;
    if (a === b || b === c || a === c) continue;
    if (k % 2 === 0) mesh.triangle(a, b, c);
    else mesh.triangle(b, a, c);
  }
}
