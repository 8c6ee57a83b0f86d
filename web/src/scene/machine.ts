// The machine around a mold: platform at z = 0, clamp frame with its window, the edge of the sheet, and signs with
// letters that say which side of the patient is where. The signs always face the camera.
import {BufferAttribute, BufferGeometry, CanvasTexture, Group, LineSegments, Mesh, type ShaderMaterial} from 'three';
import {el} from '../dom';
import {flat} from './flat';
import {release, type LeftSide, type Viewer} from './viewer';

export interface Frame {
  sheet: [number, number];   // mm
  window: [number, number];
  round: boolean;
  height: number;            // of the frame above the platform
}

type Point = [number, number];
const corners = 64;

// A closed line of 64 points that meets the corners of a rectangle.
const around = (w: number, h: number, round: boolean): Point[] => Array.from({length: corners}, (_, i): Point => {
  const a = 2 * Math.PI * i / corners, c = Math.cos(a), s = Math.sin(a), m = round ? 1 : Math.max(Math.abs(c), Math.abs(s));
  return [w / 2 * c / m, (round ? w : h) / 2 * s / m];
});

function surface(points: number[], indices: number[], colour: string, viewer: Viewer, opacity: number): Mesh {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
  geometry.setIndex(indices);
  return new Mesh(geometry, flat(viewer.colour(colour), {opacity}));
}

export type Lines = LineSegments<BufferGeometry, ShaderMaterial>;
export function segments(points: number[], colour: string, viewer: Viewer, through = false): Lines {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
  return new LineSegments(geometry, flat(viewer.colour(colour), {through}));
}

const loop = (outline: Point[], z: number): number[] =>
  outline.flatMap(([x, y], i) => [x, y, z, ...outline[(i + 1) % outline.length]!, z]);

export function sign(text: string, size: number, viewer: Viewer): Mesh {
  const picture = el('canvas', {width: 128, height: 128}), pen = picture.getContext('2d')!;
  pen.scale(2, 2);
  pen.fillStyle = viewer.colour('--accent').getStyle();
  pen.fillRect(0, 0, 64, 64);
  pen.fillStyle = viewer.colour('--accent-text').getStyle();
  pen.font = `700 ${text.length > 1 ? 38 : 50}px system-ui, sans-serif`;
  pen.textAlign = 'center';
  pen.textBaseline = 'middle';
  pen.fillText(text, 32, 36, 56);
  const map = new CanvasTexture(picture), geometry = new BufferGeometry(), half = size / 2;
  geometry.setAttribute('position', new BufferAttribute(new Float32Array([-half, -half, 0, half, -half, 0, half, half, 0, -half, half, 0]), 3));
  geometry.setAttribute('uv', new BufferAttribute(new Float32Array([0, 0, 1, 0, 1, 1, 0, 1]), 2));
  geometry.setIndex([0, 1, 2, 0, 2, 3]);
  const mesh = new Mesh(geometry, flat(viewer.colour('--accent'), {map, upright: true}));
  mesh.material.addEventListener('dispose', () => map.dispose());
  return mesh;
}

// The letters at -x, +x, +y and -y, as worker/scan/sides.hpp has them: with a question mark until a person has seen the
// patient's left at -x.
export const sideLetters: Record<LeftSide, readonly [string, string, string, string]> = {
  minus_x: ['L', 'R', 'A', 'P'], plus_x: ['R', 'L', 'A?', 'P?'], unknown: ['L?', 'R?', 'A?', 'P?']};

// Signs around a rectangle that reaches from -x to x and from -y to y, on the plane z.
export function letters(viewer: Viewer, [w, h]: Point, z: number, size: number, left: LeftSide): Group {
  const group = new Group();
  [[-1, 0], [1, 0], [0, 1], [0, -1]].forEach(([x, y], i) => {
    const one = sign(sideLetters[left][i]!, size, viewer);
    one.position.set(x! * (w + size), y! * (h + size), z + size / 2);
    group.add(one);
  });
  return group;
}

// Replaces `old`.
export function machine(viewer: Viewer, frame: Frame, left: LeftSide, old: Group | null): Group {
  if (old) release(old);
  const group = new Group(), [w, h] = frame.sheet, z = frame.height;
  const outline = around(...frame.window, frame.round), edge = around(w, h, false);
  const ring = outline.flatMap((_, i) => {
    const j = (i + 1) % corners;
    return [i, j, corners + i, corners + i, j, corners + j];
  });
  group.add(surface(outline.flatMap(([x, y]) => [x, y, 0]).concat(0, 0, 0), outline.flatMap((_, i) => [i, (i + 1) % corners, corners]), '--card', viewer, 1));
  group.add(surface([...outline, ...edge].flatMap(([x, y]) => [x, y, z]), ring, '--control', viewer, 0.35));
  const grid: number[] = [], [a, b] = frame.window;
  for (let at = -20 * Math.floor(Math.max(a, b) / 40); at < Math.max(a, b) / 2; at += 20) {  // lines 20 mm apart
    const chord = Math.sqrt(Math.max(0, a * a / 4 - at * at));
    const y = frame.round ? chord : Math.abs(at) < a / 2 ? b / 2 : 0, x = frame.round ? chord : Math.abs(at) < b / 2 ? a / 2 : 0;
    grid.push(at, -y, 0.2, at, y, 0.2, -x, at, 0.2, x, at, 0.2);
  }
  group.add(segments(grid, '--line', viewer));
  group.add(segments([z, 0].flatMap((at) => loop(outline, at + 0.3)).concat(loop(edge, z + 0.3)), '--control', viewer));
  const size = 0.075 * Math.max(w, h);
  group.add(letters(viewer, [w / 2 - size, h / 2 - size], z, size, left));
  viewer.root.add(group);
  return group;
}
