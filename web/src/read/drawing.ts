// The physical size of a drawing, as far as its file states one.

export interface DrawingSize {
  width: number | null;   // mm; null if the file does not say
  height: number | null;
  aspect: number | null;  // width / height
}

const unknown: DrawingSize = {width: null, height: null, aspect: null};
const millimetres: Record<string, number> = {mm: 1, cm: 10, in: 25.4, pt: 25.4 / 72, pc: 25.4 / 6, px: 25.4 / 96, '': 25.4 / 96};
const root = /<((?:[\w.-]+:)?svg)\b((?:[^>"']|"[^"]*"|'[^']*')*)>/;
const rootOf = (text: string): RegExpExecArray | null => root.exec(text.slice(0, 200_000).replace(/<!--[^]*?-->/g, ''));

function attribute(list: string, name: string): string | undefined {
  const found = new RegExp(`(?:^|\\s)${name}\\s*=\\s*(?:"([^"]*)"|'([^']*)')`).exec(list);
  return found?.[1] ?? found?.[2];
}

function length(text: string | undefined): number | null {
  const parts = /^\s*([+]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*([a-z]*)\s*$/i.exec(text ?? '');
  const unit = millimetres[parts?.[2] ?? '?'];
  const value = Number(parts?.[1]) * (unit ?? NaN);
  return value > 0 && Number.isFinite(value) ? value : null;
}

// As the service reads it: a missing side follows from the shape.
export function svgSize(text: string): DrawingSize {
  const list = rootOf(text)?.[2];
  if (list === undefined) return unknown;
  const width = length(attribute(list, 'width')), height = length(attribute(list, 'height'));
  const [, , boxWidth = 0, boxHeight = 0] = (attribute(list, 'viewBox') ?? '').trim().split(/[\s,]+/).map(Number);
  const aspect = width && height ? width / height : boxWidth > 0 && boxHeight > 0 ? boxWidth / boxHeight : null;
  return {width: width ?? (height && aspect && height * aspect), height: height ?? (width && aspect && width / aspect), aspect};
}

// An SVG that every browser draws as a picture: its root has a width and a height.
export function svgWithSize(text: string): string {
  const found = rootOf(text);
  if (!found || attribute(found[2] ?? '', 'width') || attribute(found[2] ?? '', 'height')) return text;
  const {aspect} = svgSize(text);
  return text.replace(found[0], `<${found[1]} width="800" height="${Math.round(800 / (aspect ?? 1))}"${found[2]}>`);
}

function pngSize(view: DataView): DrawingSize {
  const across = view.getUint32(16), down = view.getUint32(20);
  const aspect = across > 0 && down > 0 ? across / down : null;
  for (let at = 8; at + 21 <= view.byteLength; at += 12 + view.getUint32(at)) {
    const name = view.getUint32(at + 4);
    if (name === 0x49444154) break;  // IDAT: pHYs comes before it
    if (name === 0x70485973 && view.getUint8(at + 16) === 1) {
      const x = view.getUint32(at + 8), y = view.getUint32(at + 12);  // pixels in a metre
      if (x > 0 && y > 0) return {width: across / x * 1000, height: down / y * 1000, aspect: across / x / (down / y)};
    }
  }
  return {width: null, height: null, aspect};
}

function jpegSize(view: DataView): DrawingSize {
  let mm = 0;
  for (let at = 2; at + 9 < view.byteLength && view.getUint8(at) === 0xff;) {
    const marker = view.getUint8(at + 1);
    if (marker === 0xe0 && at + 16 <= view.byteLength && view.getUint32(at + 4) === 0x4a464946) {  // JFIF
      const density = view.getUint16(at + 12);
      if (density > 0) mm = ({1: 25.4, 2: 10} as Record<number, number>)[view.getUint8(at + 11)] ?? 0;
      mm /= density || 1;
    } else if (marker >= 0xc0 && marker <= 0xcf && marker !== 0xc4 && marker !== 0xc8 && marker !== 0xcc) {
      const down = view.getUint16(at + 5), across = view.getUint16(at + 7);
      const aspect = across > 0 && down > 0 ? across / down : null;
      return {width: across * mm || null, height: down * mm || null, aspect};
    }
    at += 2 + view.getUint16(at + 2);
  }
  return unknown;
}

// Of the first bytes of a PNG or JPEG.
export function pictureSize(bytes: ArrayBuffer): DrawingSize {
  const view = new DataView(bytes);
  if (view.byteLength > 24 && view.getUint32(0) === 0x89504e47) return pngSize(view);
  if (view.byteLength > 4 && view.getUint16(0) === 0xffd8) return jpegSize(view);
  return unknown;
}
