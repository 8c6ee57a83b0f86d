// The physical size of a drawing, as far as its file states one.

export interface DrawingSize {
  width: number | null;   // mm; null if the file does not say
  height: number | null;
  aspect: number | null;  // width / height
  px?: [number, number];  // its sides in pixels, if pattern.dpi decides how long these are
  dpi?: number;           // pixels an inch that the program counts that wrote the file
  program?: string;
}

const unknown: DrawingSize = {width: null, height: null, aspect: null};
const millimetres: Record<string, number> = {mm: 1, cm: 10, in: 25.4, pt: 25.4 / 72, pc: 25.4 / 6, q: 0.25};
const root = /<((?:[\w.-]+:)?svg)\b((?:[^>"']|"[^"]*"|'[^']*')*)>/;
const rootOf = (text: string): RegExpExecArray | null => root.exec(text.slice(0, 200_000).replace(/<!--[^]*?-->/g, ''));

function attribute(list: string, name: string): string | undefined {
  const found = new RegExp(`(?:^|\\s)${name}\\s*=\\s*(?:"([^"]*)"|'([^']*)')`).exec(list);
  return found?.[1] ?? found?.[2];
}

interface Side {value: number; mm: number | null}  // mm of its unit; null for px and for no unit
function side(text: string | undefined): Side | null {
  const parts = /^\s*([+]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*([a-z]*)\s*$/i.exec(text ?? '');
  const value = Number(parts?.[1]), unit = (parts?.[2] ?? '').toLowerCase();
  if (!(value > 0) || !Number.isFinite(value)) return null;
  if (unit === '' || unit === 'px') return {value, mm: null};
  const mm = millimetres[unit];
  return mm === undefined ? null : {value, mm};
}

// Pixels of the programs that are known to count them in one way; not where two of them wrote the file.
function counted(text: string, list: string): {dpi: number; program: string} | null {
  const start = text.slice(0, root.exec(text)?.index ?? 0);
  const illustrator = /<!--\s*Generator: Adobe Illustrator[ ,]/.test(start);
  const version = /^\s*(\d+)(?:\.(\d+))?/.exec(attribute(list, 'inkscape:version') ?? '');
  if (illustrator === (version !== null)) return null;
  if (!version) return {dpi: 72, program: 'Adobe Illustrator'};
  const old = Number(version[1]) === 0 && Number(version[2] ?? 0) < 92;
  return {dpi: old ? 90 : 96, program: `Inkscape ${version[0].trim()}`};
}

// As the service reads it: a missing side follows from the shape.
export function svgSize(text: string): DrawingSize {
  const list = rootOf(text)?.[2];
  if (list === undefined) return unknown;
  const width = side(attribute(list, 'width')), height = side(attribute(list, 'height'));
  const [, , boxWidth = 0, boxHeight = 0] = (attribute(list, 'viewBox') ?? '').trim().split(/[\s,]+/).map(Number);
  const box = boxWidth > 0 && boxHeight > 0 ? boxWidth / boxHeight : null, by = counted(text, list);
  const sized = (dpi: number): DrawingSize => {
    const mm = ({value, mm: unit}: Side): number => value * (unit ?? 25.4 / dpi), w = width && mm(width), h = height && mm(height);
    const aspect = w && h ? w / h : box;
    return {width: w ?? (h && aspect && h * aspect), height: h ?? (w && aspect && w / aspect), aspect};
  };
  if (!width && !height) {
    // Illustrator counts a viewBox as it counts pixels.
    if (!box) return unknown;
    const px: [number, number] = [boxWidth, boxHeight];
    return by?.dpi === 72 ? {width: boxWidth * 25.4 / 72, height: boxHeight * 25.4 / 72, aspect: box, px, ...by} : {...unknown, aspect: box, px};
  }
  if (![width, height].some((each) => each?.mm === null)) return sized(96);
  const some = sized(by?.dpi ?? 96), mixed = [width, height].some((each) => each && each.mm !== null);
  const px: [number, number] | undefined = !mixed && some.width && some.height
    ? [some.width * (by?.dpi ?? 96) / 25.4, some.height * (by?.dpi ?? 96) / 25.4] : undefined;
  const known = {...some, ...by, ...px && {px}};
  return by ? known : {...known, width: null, height: null, aspect: mixed ? box : some.aspect};
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
      if (x > 0 && y > 0) return {width: across / x * 1000, height: down / y * 1000, aspect: across / x / (down / y), px: [across, down]};
    }
  }
  return {width: null, height: null, aspect, px: [across, down]};
}

// Millimetres of a pixel's width by the Exif data at `at`; 0 if they do not say.
function exifPixel(view: DataView, at: number, end: number): number {
  const little = view.getUint16(at) === 0x4949, short = (place: number): number => view.getUint16(place, little);
  const directory = at + view.getUint32(at + 4, little);
  let width = 0, unit = 2;
  for (let i = 0, entry = directory + 2; directory + 2 <= end && i < short(directory) && entry + 12 <= end; ++i, entry += 12) {
    if (short(entry) === 0x128) unit = short(entry + 8);
    const value = at + view.getUint32(entry + 8, little);
    if (short(entry) === 0x11a && value + 8 <= end) width = view.getUint32(value + 4, little) / view.getUint32(value, little);
  }
  const mm = ({2: 25.4, 3: 10} as Record<number, number>)[unit] ?? 0;
  return width > 0 && Number.isFinite(width) ? width * mm : 0;
}

function jpegSize(view: DataView): DrawingSize {
  let mm = 0, exif = 0;
  for (let at = 2; at + 9 < view.byteLength && view.getUint8(at) === 0xff;) {
    const marker = view.getUint8(at + 1);
    if (marker === 0xe0 && at + 16 <= view.byteLength && view.getUint32(at + 4) === 0x4a464946) {  // JFIF
      const density = view.getUint16(at + 12);
      if (density > 0) mm = ({1: 25.4, 2: 10} as Record<number, number>)[view.getUint8(at + 11)] ?? 0;
      mm /= density || 1;
    } else if (marker === 0xe1 && at + 18 <= view.byteLength && view.getUint32(at + 4) === 0x45786966) {  // Exif
      exif = exifPixel(view, at + 10, Math.min(view.byteLength, at + 2 + view.getUint16(at + 2)));
    } else if (marker >= 0xc0 && marker <= 0xcf && marker !== 0xc4 && marker !== 0xc8 && marker !== 0xcc) {
      const down = view.getUint16(at + 5), across = view.getUint16(at + 7);
      const aspect = across > 0 && down > 0 ? across / down : null;
      if (mm && exif && Math.abs(exif - mm) > 0.01 * mm) mm = 0;  // the service asks which of them is right
      else mm ||= exif;
      return {width: across * mm || null, height: down * mm || null, aspect, px: [across, down]};
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
