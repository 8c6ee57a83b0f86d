// A scan that stands in the machine, before it is sent.
import {BoxGeometry, BufferAttribute, BufferGeometry, CanvasTexture, DoubleSide, GLSL3, type Group, Matrix3, Matrix4, Mesh, ShaderMaterial,
        Vector3} from 'three';
import {el} from '../dom';
import type {ShownMesh} from '../read/cluster';
import type {Point} from '../read/landmarks';
import type {Placed} from '../read/place';
import type {ReadScan} from '../read/prepare';
import {flat} from './flat';
import {hit} from './hit';
import {machine, segments, sign, type Frame, type Lines} from './machine';
import {createViewer, release, type LeftSide, type Viewer} from './viewer';

export {NoWebGl} from './viewer';
export type {Frame} from './machine';

// A drawing about where it comes to lie on the head: as far from the top as on a ball of the head's size.
export interface Ink {
  picture: HTMLImageElement;
  size: readonly [number, number];    // mm
  offset: readonly [number, number];  // mm, of its centre from the top
  turn: number;                       // degrees, counter-clockwise from above
  scale: number;
}
export interface Standing {
  placed: Placed;
  plug: number;       // mm: the cut is at this height
  frame: Frame;
  left: LeftSide;
  outline: boolean;   // of an average adult head
  ink: Ink | null;    // the drawing
  marks: readonly (Point | undefined)[];  // nose, left and right ear, where the file of the scan has them
}
export interface ScanScene {
  readonly viewer: Viewer;
  update(standing: Standing): void;
  mark(place: readonly number[]): void;  // a place in the machine, in mm
  // What lies there, or at the centre of the view, where the file of the scan has it.
  under(event?: {clientX: number; clientY: number}): Point | null;
}

const vertexShader = `
out vec3 n; out vec3 eye; out vec3 place;
void main() {
  vec4 world = modelMatrix * vec4(position, 1.0), view = viewMatrix * world;
  place = world.xyz;
  n = mat3(viewMatrix) * mat3(modelMatrix) * normal;
  eye = -view.xyz;
  gl_Position = projectionMatrix * view;
}`;
// Light from the upper left and from the camera, darker towards the rim. What is cut away is pale: the ground shines through.
const fragmentShader = `
in vec3 n; in vec3 eye; in vec3 place;
out vec4 colour;
uniform float cut, radius;
uniform vec3 ground, top;
uniform mat3 onInk;  // from mm beside the top to the picture
uniform sampler2D ink;
void main() {
  vec3 u = normalize(n), v = normalize(eye);
  if (dot(u, v) < 0.0) u = -u;
  float key = max(0.0, dot(u, normalize(vec3(-0.45, 0.65, 0.6)))), rim = 1.0 - dot(u, v);
  float light = (0.40 + 0.16 * dot(u, v) + 0.46 * key) * (1.0 - 0.45 * rim * rim * rim);
  colour = vec4(vec3(0.93, 0.91, 0.87) * light + 0.10 * pow(key, 24.0), 1.0);
  vec3 d = place - top;
  float arc = 2.0 * radius * asin(min(1.0, 0.5 * length(d) / radius));
  vec2 at = (onInk * vec3(arc * normalize(d.xy + 1e-6), 1.0)).xy;
  vec3 printed = texture(ink, at).rgb;
  if (radius > 0.0 && at == clamp(at, 0.0, 1.0)) colour.rgb *= printed;
  if (place.z < cut - 0.05) colour.rgb = mix(colour.rgb, ground, 0.55);
}`;

function geometryOf(mesh: ShownMesh): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(mesh.positions, 3));
  const normals = new Int8Array(mesh.normals);
  geometry.setAttribute('normal', new BufferAttribute(normals, 4, true));
  geometry.setIndex(new BufferAttribute(mesh.indices, 1));
  return geometry;
}

// The upper half of an average adult head, 150 mm wide, 190 mm long and 230 mm from chin to vertex, in dashes that shine
// through the scan.
function headOutline(viewer: Viewer): Lines {
  const points: number[] = [], half = [75, 95, 115];
  for (const [i, j] of [[0, 1], [0, 2], [1, 2]] as const)
    for (let k = 0; k < (j === 2 ? 96 : 192); ++k)
      if (k % 3 < 2)
        for (const step of [k, k + 1]) {
          const a = 2 * Math.PI * step / 192, p = [0, 0, 0];
          p[i] = half[i]! * Math.cos(a);
          p[j] = half[j]! * Math.sin(a);
          points.push(...p);
        }
  const lines = segments(points, '--accent', viewer, true);
  lines.renderOrder = 1;
  return lines;
}

// Throws NoWebGl.
export function scanScene(scan: ReadScan, options: {label: string; tools?: HTMLElement[]; failed: () => void}): ScanScene {
  const viewer = createViewer(options);
  const fine = geometryOf(scan.shown), coarse = scan.coarse ? geometryOf(scan.coarse) : fine;
  const material = new ShaderMaterial({
    glslVersion: GLSL3, vertexShader, fragmentShader, side: DoubleSide,
    uniforms: {cut: {value: 0}, ground: {value: viewer.colour('--ground')}, radius: {value: 0}, top: {value: new Vector3()}, onInk: {value: new Matrix3()},
               ink: {value: null as CanvasTexture | null}}});
  const {uniforms} = material;
  const body = new Mesh(fine, material);
  body.matrixAutoUpdate = false;
  viewer.root.add(body);
  const pin = new Mesh(new BoxGeometry(5, 5, 5), flat(viewer.colour('--bad'), {through: true}));
  pin.visible = false;
  pin.rotation.set(Math.PI / 4, Math.atan(Math.SQRT1_2), 0);  // it stands on a corner
  pin.renderOrder = 1;
  viewer.root.add(pin);
  const outline = headOutline(viewer);
  let group: Group | null = null, last: Standing | null = null, drawn = '';
  const letters = ['N', 'L', 'R'];  // nose, left, right, in German too
  let marks: Mesh[] = [];

  viewer.on('quality', () => { body.geometry = viewer.quality.coarse ? coarse : fine; });
  viewer.on('theme', () => {
    uniforms['ground']!.value = viewer.colour('--ground');
    pin.material.uniforms['colour']!.value = viewer.colour('--bad');
    outline.material.uniforms['colour']!.value = viewer.colour('--accent');
    drawn = '';
    const marked = pin.visible;
    if (last) update(last);
    pin.visible = marked;
  });
  viewer.root.add(outline);

  let picture: HTMLImageElement | null = null;
  function setInk({placed, ink}: Standing): void {
    if (picture !== (ink?.picture ?? null)) {
      (uniforms['ink']!.value as CanvasTexture | null)?.dispose();
      picture = ink?.picture ?? null;
      const canvas = el('canvas', {width: 1024, height: 1024}), pen = canvas.getContext('2d')!;
      pen.fillStyle = '#fff';
      pen.fillRect(0, 0, 1024, 1024);
      if (picture) pen.drawImage(picture, 0, 0, 1024, 1024);
      uniforms['ink']!.value = picture && new CanvasTexture(canvas);
    }
    uniforms['radius']!.value = ink ? Math.max(...placed.half) : 0;
    if (!ink) return;
    const {size: [w, h], offset: [x, y], turn, scale} = ink, c = Math.cos(turn * Math.PI / 180) / scale, s = Math.sin(turn * Math.PI / 180) / scale;
    (uniforms['top']!.value as Vector3).set(...placed.top, placed.height);
    (uniforms['onInk']!.value as Matrix3).set(c / w, s / w, 0.5 - (c * x + s * y) / w, -s / h, c / h, 0.5 + (s * x - c * y) / h, 0, 0, 1);
  }

  function update(standing: Standing): void {
    setInk(standing);
    const {placed, plug, frame, left} = last = standing;
    const [a, b, c, d, e, f, g, h, i] = placed.turn as [number, number, number, number, number, number, number, number, number];
    const [x, y, z] = placed.shift;
    body.matrix = new Matrix4(a, b, c, x, d, e, f, y, g, h, i, z, 0, 0, 0, 1);
    body.matrixWorldNeedsUpdate = true;
    uniforms['cut']!.value = plug;
    outline.visible = standing.outline;
    outline.position.z = placed.height - 115;
    pin.visible = false;
    const wanted = JSON.stringify([frame, left]);
    if (wanted !== drawn) {
      group = machine(viewer, frame, left, group);
      marks.forEach(release);
      marks = letters.map((letter) => sign(letter, 12, viewer));
      viewer.root.add(...marks);
    }
    drawn = wanted;
    marks.forEach((one, i) => {
      const at = standing.marks[i];
      one.visible = at !== undefined;
      if (at) one.position.set(...at).applyMatrix4(body.matrix);
    });
    viewer.setSides(left);
    const [w, l] = frame.window.map((side) => 0.6 * side) as Frame['window'], top = placed.height, low = Math.min(0, top - placed.size[2]), [sx, sy] = placed.half;
    viewer.fit([-w / 2, -l / 2, 0, w / 2, l / 2, 0, -sx, -sy, low, sx, sy, low, -sx, -sy, top, sx, sy, top]);
    viewer.invalidate();
  }
  return {
    viewer, update,
    mark([x = 0, y = 0, z = 0]) {
      pin.position.set(x, y, z);
      pin.visible = true;
      viewer.turnTo(x, y, z);
    },
    under(event) {
      const {origin, direction} = viewer.ray(event).applyMatrix4(body.matrix.clone().invert());
      const found = hit(scan.shown, origin.toArray(), direction.toArray());
      return found && origin.addScaledVector(direction, found.far).toArray();
    },
  };
}
