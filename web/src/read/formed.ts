// Reads formed.glb, the formed sheet as docs/reference/files.md describes it. Nothing is trusted: every offset is checked.

export interface Formed {
  positions: Float32Array;    // mm, z up
  normals: Float32Array;
  texture: Float32Array;      // place on the pictures, from the left and from the top, 0 to 1
  sheet: Float32Array;        // (s, t) mm
  pattern: Float32Array;      // (u, v) mm; 0 off the chart
  contact: Float32Array;      // 0 free, 1 mold, 2 platform, 3 clamp
  chart: Float32Array;        // 1 on the chart, otherwise 0
  maps: ReadonlyMap<string, Float32Array>;  // values of the heat maps by their ids; -1 where there is no value
  indices: Uint32Array;
  printed: Blob;              // PNG: what is printed, in sheet coordinates
  drawn: Blob;                // PNG: the drawing as it is, in sheet coordinates
}

export class FormedFault extends Error {}

interface Gltf {
  accessors?: {bufferView?: number; byteOffset?: number; componentType: number; count: number; type: string}[];
  bufferViews?: {byteOffset?: number; byteLength: number; byteStride?: number}[];
  meshes?: {primitives: {
    attributes: Record<string, number>;
    indices?: number;
    extensions?: {KHR_materials_variants?: {mappings: {material: number; variants: number[]}[]}};
  }[]}[];
  materials?: {pbrMetallicRoughness?: {baseColorTexture?: {index: number}}}[];
  textures?: {source?: number}[];
  images?: {bufferView?: number; mimeType?: string}[];
  extensions?: {KHR_materials_variants?: {variants: {name: string}[]}};
}

const floats = 5126, uint32 = 5125;
const sizes: Record<string, number> = {SCALAR: 1, VEC2: 2, VEC3: 3};

function check(holds: unknown, what: string): asserts holds {
  if (!holds) throw new FormedFault(`formed.glb: ${what}`);
}

export function readFormed(file: ArrayBuffer): Formed {
  const view = new DataView(file);
  check(file.byteLength >= 28 && view.getUint32(0, true) === 0x46546c67 && view.getUint32(4, true) === 2, 'not binary glTF 2.0');
  check(view.getUint32(8, true) === file.byteLength, `${view.getUint32(8, true)} bytes announced, ${file.byteLength} received`);
  const jsonBytes = view.getUint32(12, true), start = 28 + jsonBytes;
  check(view.getUint32(16, true) === 0x4e4f534a && start <= file.byteLength, 'the JSON chunk is missing or cut off');
  const binBytes = view.getUint32(start - 8, true);
  check(view.getUint32(start - 4, true) === 0x004e4942 && start + binBytes <= file.byteLength, 'the binary chunk is missing or cut off');
  let gltf: Gltf;
  try {
    gltf = JSON.parse(new TextDecoder().decode(new Uint8Array(file, 20, jsonBytes))) as Gltf;
  } catch {
    throw new FormedFault('formed.glb: the JSON chunk is not JSON');
  }

  const bytesOf = (index: number | undefined, offset = 0, length?: number): Uint8Array => {
    const found = gltf.bufferViews?.[index ?? -1];
    check(found && !found.byteStride, `buffer view ${index} is missing or interleaved`);
    const bytes = length ?? found.byteLength - offset, from = (found.byteOffset ?? 0) + offset;
    check(bytes >= 0 && offset >= 0 && offset + bytes <= found.byteLength && from >= 0 && from + bytes <= binBytes,
          `buffer view ${index} is too short`);
    return new Uint8Array(file, start + from, bytes);
  };
  const primitive = gltf.meshes?.[0]?.primitives[0];
  check(primitive, 'the mesh is missing');
  const numbers = (name: string, index: number | undefined, type: number, size: number): Uint8Array => {
    const accessor = gltf.accessors?.[index ?? -1];
    check(accessor && accessor.componentType === type && sizes[accessor.type] === size, `${name} is missing or of another type`);
    check(Number.isInteger(accessor.count) && accessor.count >= 0, `${name} has no count`);
    return bytesOf(accessor.bufferView, accessor.byteOffset, 4 * size * accessor.count).slice();
  };
  let count = -1;
  const attribute = (name: string, size: number): Float32Array => {
    const values = new Float32Array(numbers(name, primitive.attributes[name], floats, size).buffer);
    if (count < 0) count = values.length / size;
    check(values.length === count * size, `${name} has another number of vertices`);
    return values;
  };
  const formed = {
    positions: attribute('POSITION', 3), normals: attribute('NORMAL', 3), texture: attribute('TEXCOORD_0', 2),
    sheet: attribute('_SHEET', 2), pattern: attribute('_PATTERN', 2), contact: attribute('_CONTACT', 1), chart: attribute('_CHART', 1),
    maps: new Map(Object.keys(primitive.attributes).filter((name) => /^_(?!SHEET|PATTERN|CONTACT|CHART)[A-Z]+$/.test(name))
      .map((name) => [name.slice(1).toLowerCase(), attribute(name, 1)])),
  };
  check(formed.positions.every(Number.isFinite), 'a position is not a number');
  const indices = new Uint32Array(numbers('the triangles', primitive.indices, uint32, 1).buffer);
  check(indices.length > 0 && indices.length % 3 === 0 && indices.every((i) => i < count), 'a triangle has no such vertex');

  const picture = (variant: string): Blob => {
    const at = gltf.extensions?.KHR_materials_variants?.variants.findIndex(({name}) => name === variant) ?? -1;
    const mapping = primitive.extensions?.KHR_materials_variants?.mappings.find(({variants}) => variants.includes(at));
    const texture = gltf.materials?.[mapping?.material ?? -1]?.pbrMetallicRoughness?.baseColorTexture?.index;
    const image = gltf.images?.[gltf.textures?.[texture ?? -1]?.source ?? -1];
    check(image, `the picture "${variant}" is missing`);
    return new Blob([bytesOf(image.bufferView).slice()], {type: 'image/png'});
  };
  return {...formed, indices, printed: picture('pre-distorted'), drawn: picture('printed as drawn')};
}

// The triangles of every second row and column, where the sheet is a regular grid; otherwise null.
export function coarse({sheet, indices}: Pick<Formed, 'sheet' | 'indices'>): Uint32Array | null {
  const count = sheet.length / 2, row = sheet[1] === sheet[3] ? 1 : 0;  // the coordinate that stays along a row
  let across = 1;
  while (across < count && sheet[2 * across + row] === sheet[row]) ++across;
  const rows = count / across, few: number[] = [];
  if (!Number.isInteger(rows) || indices.length !== 6 * (across - 1) * (rows - 1)) return null;
  for (let j = 0; j < rows - 1; j += 2)
    for (let i = 0; i < across - 1; i += 2) {
      const right = Math.min(i + 2, across - 1) - i, a = j * across + i, up = (Math.min(j + 2, rows - 1) - j) * across;
      few.push(a, a + right, a + right + up, a, a + right + up, a + up);
    }
  return Uint32Array.from(few);
}

// Width and height of the pictures in mm, the height negative since t goes up, and the shares at which s and t are 0.
export function picturePlace({sheet, texture}: Pick<Formed, 'sheet' | 'texture'>): [[number, number], [number, number]] {
  const axis = (k: 0 | 1): [number, number] => {
    let low = 0, high = 0;
    for (let i = 0; i < sheet.length / 2; ++i) {
      if (sheet[2 * i + k]! < sheet[2 * low + k]!) low = i;
      if (sheet[2 * i + k]! > sheet[2 * high + k]!) high = i;
    }
    const size = (sheet[2 * high + k]! - sheet[2 * low + k]!) / (texture[2 * high + k]! - texture[2 * low + k]!);
    return [size, texture[2 * low + k]! - sheet[2 * low + k]! / size];
  };
  const [s, t] = [axis(0), axis(1)];
  return [[s[0], t[0]], [s[1], t[1]]];
}
