// The formed sheet in 3D: the print on it, heat maps, and what is marked on it.
import {BufferAttribute, BufferGeometry, CanvasTexture, Color, DataTexture, DoubleSide, GLSL3, type Group, LinearFilter, Matrix3, Mesh,
        NoColorSpace, ShaderMaterial, type Texture, Vector3} from 'three';
import {coarse, picturePlace, type Formed} from '../read/formed';
import type {Flat, HeatMap} from '../state/result';
import {colourAt, noValue, touches, touchesNot} from './colour';
import {drawnInk, picture, toSheet, type Paint} from './ink';
import {Surface, type Point} from './measure';
import {having, nearest, under, type Spot} from './pick';
import {fragmentShader, kinds, vertexShader} from './sheet.glsl';
import {letters} from './machine';
import {release, type LeftSide, type Viewer} from './viewer';

export {createViewer, NoWebGl, type Viewer} from './viewer';
export type {Spot} from './pick';

export interface Shown {
  map: 'print' | 'contact' | HeatMap;
  isolines: boolean;
  cut: number;                // share of the width that is printed as drawn, from the left
  sideBySide: boolean;
  place: readonly number[] | null;  // rows of a 3 x 3 matrix from the drawing (mm) to the pictures: shows the drawing there
}

export interface Sheet {
  readonly picture: {size: [number, number]; origin: [number, number]};  // where the sheet lies on the pictures, see picturePlace
  show(what: Shown): void;
  // Draws on the sheet, in millimetres of sheet coordinates, t up. `onPrint`: not where it is shown as printed as drawn.
  draw(paint: Paint, onPrint: boolean): void;
  ink(paint: Paint | null): void;  // what is printed, drawn in the same way; null: all of the print
  under(event?: {clientX: number; clientY: number}): Spot | null;  // without an event: at the centre of the view
  nearest(place: Point, onChart?: boolean): Spot;
  having(name: 'sheet' | 'pattern', value: Flat): Spot | null;  // on the chart
  chart(): {drawn: Flat[]; sheet: Flat[]};  // of its vertices
  onScreen(spot: Spot): {x: number; y: number} | null;  // CSS pixels in the frame; null: on the far side, or there are two views
  // The shortest way over the surface: its length and where it runs on the sheet.
  way(a: Spot, b: Spot): {length: number; sheet: [number, number][]} | null;
  turnTo(place: Point): void;  // so that one looks at it straight on
}

const overlaySize = 1024;

function ramp(map: HeatMap): DataTexture {
  const bytes = new Uint8Array(256 * 4);
  for (let i = 0; i < 256; ++i) bytes.set([...colourAt(map, i / 255).map((part) => Math.round(255 * part)), 255], 4 * i);
  const texture = new DataTexture(bytes, 256, 1);
  texture.minFilter = texture.magFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

// Several numbers of each vertex in one attribute.
function woven(...values: Float32Array[]): BufferAttribute {
  const size = values.length, all = new Float32Array(size * (values[0]?.length ?? 0));
  values.forEach((one, k) => one.forEach((value, i) => { all[size * i + k] = value; }));
  return new BufferAttribute(all, size);
}

// `left`: on which side the patient's left is.
export async function createSheet(viewer: Viewer, formed: Formed, left: LeftSide): Promise<Sheet> {
  const [printed, drawn] = await Promise.all([picture(formed.printed), picture(formed.drawn)]);
  let ink: Texture = printed;
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(formed.positions, 3));
  geometry.setAttribute('normal', new BufferAttribute(formed.normals, 3));
  geometry.setAttribute('uv', new BufferAttribute(formed.texture, 2));
  geometry.setAttribute('pattern', new BufferAttribute(formed.pattern, 2));
  geometry.setAttribute('marks', woven(formed.contact, formed.chart));
  geometry.setAttribute('value', new BufferAttribute(formed.contact, 1));
  const fine = new BufferAttribute(formed.indices, 1), few = coarse(formed), rough = few && new BufferAttribute(few, 1);
  geometry.setIndex(fine);

  const ramps = new Map<string, DataTexture>();
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = overlaySize;
  const overlay = new CanvasTexture(canvas);
  overlay.flipY = false;
  overlay.premultiplyAlpha = true;
  overlay.colorSpace = NoColorSpace;
  const uniforms = {
    kind: {value: 0}, overInk: {value: true}, cut: {value: 0}, onPrint: {value: false}, moved: {value: false}, place: {value: new Matrix3()}, range: {value: new Vector3()},
    outline: {value: new Color()}, noValue: {value: new Vector3(...noValue)}, touches: {value: new Vector3(...touches)},
    touchesNot: {value: new Vector3(...touchesNot)}, printed: {value: printed as Texture}, drawn: {value: drawn}, ramp: {value: null as DataTexture | null},
    overlay: {value: overlay},
  };
  const material = new ShaderMaterial({uniforms, vertexShader, fragmentShader, glslVersion: GLSL3, side: DoubleSide});
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  viewer.root.add(mesh);

  const [size, origin] = picturePlace(formed);

  const onMold: number[] = [];
  for (let i = 0; i < formed.contact.length; ++i)
    if (formed.contact[i] === 1) onMold.push(...formed.positions.subarray(3 * i, 3 * i + 3));
  const fitted = onMold.length > 0 ? onMold : formed.positions;
  // The flat sheet around the mold is seen too: the middle of the view is lower than that of the mold.
  let low = Infinity, high = -Infinity;
  for (let i = 2; i < fitted.length; i += 3) low = Math.min(low, fitted[i]!), high = Math.max(high, fitted[i]!);
  viewer.fit([...fitted, fitted[0]!, fitted[1]!, low - 0.35 * (high - low)]);
  viewer.setSides(left);
  // The letters stand around what touches the mold.
  const half: [number, number] = [0, 0];
  for (let i = 0; i < fitted.length; i += 3)
    for (const k of [0, 1] as const) half[k] = Math.max(half[k], Math.abs(fitted[i + k]!));
  let sides: Group | null = null;
  const setSides = (): void => {
    if (sides) release(sides);
    viewer.root.add(sides = letters(viewer, half, 0, 0.12 * Math.max(...half), left));
  };
  setSides();

  // Against the ground for the heat maps, whose ends are as dark or as bright as it; on the sheet itself for the print.
  const setOutline = (): void => {
    uniforms.outline.value = uniforms.kind.value === kinds.print ? new Color(0.13, 0.17, 0.2) : viewer.colour('--text');
  };
  viewer.on('theme', () => {
    setOutline();
    setSides();
  });
  viewer.on('quality', () => {
    geometry.setIndex(viewer.quality.coarse && rough ? rough : fine);
    for (const texture of new Set([ink, printed, drawn])) {
      if (texture.anisotropy >= viewer.quality.anisotropy) continue;  // each change sends the picture again
      texture.anisotropy = viewer.quality.anisotropy;
      texture.needsUpdate = true;
    }
  });

  let surface: Surface | null = null;
  return {
    picture: {size, origin},
    show(what) {
      const {map} = what, values = typeof map === 'string' ? undefined : formed.maps.get(map.id);
      uniforms.kind.value = typeof map === 'string' ? kinds[map] : kinds.heat;
      uniforms.overInk.value = typeof map === 'string' || map.over_ink;
      setOutline();
      if (values && typeof map !== 'string') {
        geometry.setAttribute('value', new BufferAttribute(values, 1));
        uniforms.ramp.value = ramps.get(map.id) ?? ramp(map);
        ramps.set(map.id, uniforms.ramp.value);
        uniforms.range.value.set(map.low, map.high, what.isolines ? map.step : 0);
      }
      uniforms.moved.value = what.place !== null;
      if (what.place) uniforms.place.value.set(...what.place as [number, number, number, number, number, number, number, number, number]);
      viewer.halves = what.sideBySide ? (half) => { uniforms.cut.value = half === 0 ? 2 : -1; } : null;
      uniforms.cut.value = what.cut;
      viewer.invalidate(true);
    },
    draw(paint, onPrint) {
      uniforms.onPrint.value = onPrint;
      const context = canvas.getContext('2d');
      if (!context) return;
      context.setTransform(1, 0, 0, 1, 0, 0);
      context.clearRect(0, 0, overlaySize, overlaySize);
      toSheet(context, {size, origin}, overlaySize, overlaySize);
      paint(context);
      overlay.needsUpdate = true;
      viewer.invalidate();
    },
    ink(paint) {
      if (ink !== printed) ink.dispose();
      uniforms.printed.value = ink = paint ? drawnInk(printed, {size, origin}, paint) : printed;
      viewer.invalidate();
    },
    under(event) {
      const {origin, direction} = viewer.ray(event);
      return under(formed, origin.toArray(), direction.toArray());
    },
    nearest: (place, onChart) => nearest(formed, place, onChart),
    having: (name, value) => having(formed, name, value),
    chart() {
      const pairs = (values: Float32Array): Flat[] => [...formed.chart.keys()].filter((i) => formed.chart[i] === 1).map((i) => [values[2 * i]!, values[2 * i + 1]!]);
      return {drawn: pairs(formed.pattern), sheet: pairs(formed.sheet)};
    },
    onScreen({point, normal}) {
      const place = new Vector3(...point);
      return viewer.halves || viewer.ray().origin.sub(place).dot(new Vector3(...normal)) < 0 ? null : viewer.toFrame(place);
    },
    way(a, b) {
      surface ??= new Surface(formed.positions, formed.indices);
      const way = surface.way(a, b);
      const at = (vertex: number, k: 0 | 1): number => formed.sheet[2 * vertex + k]!;
      return way && {length: way.length, sheet: [a.sheet, ...way.crossed.map(([from, to, share]): [number, number] =>
        [at(from, 0) + share * (at(to, 0) - at(from, 0)), at(from, 1) + share * (at(to, 1) - at(from, 1))]), b.sheet]};
    },
    turnTo(place) {
      const spot = nearest(formed, place), [x, y, z] = spot.normal, [turned = '0', , zoom = '1'] = viewer.camera.split('_');
      // On top, where the normal points to no side, the side that one looks from stays.
      const azimuth = Math.hypot(x, y) < 0.3 ? turned : Math.atan2(-x, y) * 180 / Math.PI;
      viewer.camera = [azimuth, Math.min(70, Math.max(-20, Math.asin(z) * 180 / Math.PI)), Math.max(1.5, Number(zoom)), ...spot.point].join('_');
    },
  };
}
