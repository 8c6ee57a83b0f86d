// A 3D view: a figure with a canvas, buttons for six views and a line that says where one looks from. Draws only when
// something changed.
//
// All materials are ShaderMaterial. Colours go to the screen as they are given (no tone mapping, no colour
// management): a material writes sRGB.
// Quality: frames are drawn at one pixel a CSS pixel until one was timed. If it took less than 50 ms, the view at rest is
// drawn at two; if more, a moving view is drawn at half a pixel and with coarse meshes. Without a graphics card, a view that
// has rested for longer may take 300 ms: a person who turns it in that time waits for it once.
import {Color, ColorManagement, Group, LinearSRGBColorSpace, type Object3D, PerspectiveCamera, Ray, Scene, Vector3, WebGLRenderer,
        type Material, type BufferGeometry} from 'three';
import {el, newId} from '../dom';
import {icon, type IconName} from '../parts/icon';
import {t} from '../text';
import {control, Orbit, sectorOf, viewOf, viewOrder, type Hand, type LeftSide, type ViewName} from './orbit';

export type {LeftSide, ViewName} from './orbit';

// The browser gives no WebGL. The caller shows what it has instead of the view.
export class NoWebGl extends Error {}

export interface Quality {
  coarse: boolean;     // draw a coarse mesh: the view moves and the machine is slow
  anisotropy: number;  // for textures
}
export interface Options {
  label: string;          // the accessible name, for example "Scan in the machine"
  elevation?: number;     // from which one looks at first
  summary?: string;       // what is shown, for people who do not see it
  tools?: HTMLElement[];  // more buttons below the picture
  failed?: () => void;    // the graphics were lost twice within a minute: the view is disposed of, show something else
}
export interface Viewer {
  readonly element: HTMLElement;       // the figure
  readonly frame: HTMLElement;         // holds the canvas; for what lies over it
  readonly canvas: HTMLCanvasElement;  // data-frame counts the frames, data-quality is "moving", "modest" or "full"
  readonly root: Group;                // what is shown, in mm, z up; disposed of with the view
  readonly quality: Quality;
  camera: string;                      // where the camera stands, for links
  hand: Hand;                          // what the hand does besides moving the camera
  halves: ((half: 0 | 1) => void) | null;  // draws the same view twice, side by side; called before each
  invalidate(moving?: boolean): void;  // draws a frame soon; `moving`: more will follow
  setSummary(text: string): void;
  setSides(left: LeftSide): void;      // on which side the patient's left is
  setView(name: ViewName): void;
  home(): void;
  lookAt(x: number, y: number, z: number, zoom?: number): void;
  turnTo(x: number, y: number, z: number): void;  // shows the side of the model on which that point is, and the point in the middle
  fit(points: ArrayLike<number>): void;  // xyz triples that every orbit at zoom 1 shows
  mmPerPixel(): number;                // at the point that is looked at
  ray(event?: {clientX: number; clientY: number}): Ray;  // through that point of the page, or through the centre
  toFrame(point: Vector3): {x: number; y: number; hidden: boolean};  // CSS pixels in the frame; hidden: behind the camera
  colour(token: string): Color;        // of a token of the style, such as "--accent"
  viewWords(): string;                 // "from the front, slightly above"
  on(event: 'frame' | 'rest' | 'theme' | 'quality', listener: () => void): void;
  snapshot(): HTMLCanvasElement;       // a copy of the picture at full quality
  picture(): Promise<Blob>;            // the same as PNG
  dispose(): void;
}

const slowFrame = 50;  // ms
ColorManagement.enabled = false;

// Throws NoWebGl.
export function createViewer(options: Options): Viewer {
  const canvas = el('canvas', {tabindex: 0, role: 'application', 'aria-roledescription': t('viewer.role'), 'aria-label': options.label});
  const context = canvas.getContext('webgl2', {antialias: false, alpha: false, powerPreference: 'high-performance'});
  if (!context) throw new NoWebGl();
  const renderer = new WebGLRenderer({canvas, context});
  const software = drawsInSoftware(context);
  renderer.outputColorSpace = LinearSRGBColorSpace;
  const scene = new Scene(), root = new Group(), camera = new PerspectiveCamera();
  scene.add(root);
  const ending = new AbortController(), {signal} = ending;
  const listeners: Record<'frame' | 'rest' | 'theme' | 'quality', (() => void)[]> = {frame: [], rest: [], theme: [], quality: []};
  const tell = (event: keyof typeof listeners): void => listeners[event].forEach((listener) => listener());
  const quality: Quality = {coarse: false, anisotropy: 1};
  let left: LeftSide = 'unknown', disposed = false, lost = 0;

  // --- drawing
  let width = 0, height = 0, scheduled = 0, frames = 0, restTimer = 0, speakTimer = 0;
  let moving = false;
  let cost: number | null = null;  // ms of a frame at one pixel a CSS pixel
  let full = false;                // the view at rest has been drawn at full quality

  const fullRatio = (): number => Math.min(Math.max(2, devicePixelRatio), Math.sqrt(8e6 / Math.max(1, width * height)));
  const mayBeFull = (): boolean => cost !== null && cost * fullRatio() ** 2 < (software ? 300 : slowFrame);

  let halves: Viewer['halves'] = null;
  const aspectNow = (): number => (halves ? width / 2 : width) / Math.max(1, height);
  function aim(): void {
    const aspect = aspectNow(), d = orbit.distance(aspect), {azimuth, elevation, x, y, z} = orbit.pose;
    const reach = 4 * orbit.radius;  // the machine around what was fitted
    camera.fov = 360 * orbit.halfAngle / Math.PI;
    camera.aspect = aspect;
    camera.far = d + reach;
    camera.near = Math.max(d - reach, camera.far / 1000);
    camera.rotation.set((90 - elevation) * Math.PI / 180, 0, (azimuth + 180) * Math.PI / 180, 'ZXY');
    camera.position.set(0, 0, d).applyEuler(camera.rotation).add(new Vector3(x, y, z));
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }
  function draw(ratio: number): void {
    aim();
    if (renderer.getPixelRatio() !== ratio) renderer.setPixelRatio(ratio);
    if (!halves) {
      renderer.render(scene, camera);
      return;
    }
    renderer.setScissorTest(true);
    for (const half of [0, 1] as const) {
      renderer.setViewport(half * width / 2, 0, width / 2, height);
      renderer.setScissor(half * width / 2, 0, width / 2, height);
      halves(half);
      renderer.render(scene, camera);
    }
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, width, height);
  }
  function render(): void {
    scheduled = 0;
    if (disposed || !width || !height || context!.isContextLost()) return;
    const slow = cost !== null && cost > slowFrame;
    const ratio = moving && slow ? 0.5 : full ? fullRatio() : 1;
    const coarse = moving && slow, anisotropy = full && !software ? renderer.capabilities.getMaxAnisotropy() : 1;
    if (coarse !== quality.coarse || anisotropy !== quality.anisotropy) {
      Object.assign(quality, {coarse, anisotropy});
      tell('quality');
    }
    const began = performance.now();
    draw(ratio);
    canvas.dataset['frame'] = String(++frames);
    canvas.dataset['quality'] = moving ? 'moving' : full ? 'full' : 'modest';
    if (ratio === 1 && frames > 1) time(began);
    else if (frames === 1) invalidate();  // the first frame compiles shaders; the second one is timed
    tell('frame');
  }
  // Waits until the graphics have drawn the frame, without blocking the page.
  function time(began: number): void {
    const sync = context!.fenceSync(context!.SYNC_GPU_COMMANDS_COMPLETE, 0);
    context!.flush();
    if (!sync) return;
    const ask = (): void => {
      if (disposed || context!.isContextLost()) return;
      const ms = performance.now() - began;
      if (context!.getSyncParameter(sync, context!.SYNC_STATUS) !== context!.SIGNALED && ms < 2000) {
        setTimeout(ask, 3);
        return;
      }
      context!.deleteSync(sync);
      cost = cost === null ? ms : (cost + ms) / 2;
      if (!moving) rest();
    };
    setTimeout(ask, 3);
  }
  function rest(): void {
    clearTimeout(restTimer);
    restTimer = window.setTimeout(() => {
      const refine = !full && !(software && moving) && mayBeFull();
      if (!moving && !refine) return;
      moving = false;
      full = refine;
      schedule();
    }, software && !moving ? 500 : 200);
  }
  function schedule(): void {
    scheduled ||= requestAnimationFrame(render);
  }
  function invalidate(more = false): void {
    if (more) {
      moving = true;
      full = false;
      rest();
    }
    schedule();
  }

  // --- where one looks from
  const orbit: Orbit = new Orbit(() => {
    invalidate(true);
    markView();
    clearTimeout(speakTimer);
    speakTimer = window.setTimeout(() => {
      status.textContent = t('viewer.spoken', {view: viewWords()});
      tell('rest');
    }, 500);
  });
  if (options.elevation) orbit.pose.elevation = orbit.first.elevation = options.elevation;
  const mmPerPixel = (): number =>
    2 * orbit.distance(aspectNow() || 1) * Math.tan(orbit.halfAngle) / Math.max(1, height);

  function viewWords(): string {
    const {eighth, height: level} = sectorOf(orbit.pose);
    if (level === 2) return t('viewer.from_above');
    if (level === -2) return t('viewer.from_below');
    // the eighths 1 to 3 are on the side of -x
    const side = eighth % 4 === 0 ? '' : left === 'unknown' ? (eighth < 4 ? '_minus_x' : '_plus_x')
      : (eighth < 4) === (left === 'minus_x') ? '_left' : '_right';
    const words = t(`viewer.from_${['front', 'front', '', 'back', 'back', 'back', '', 'front'][eighth] ?? ''}${side}` as 'viewer.from_front');
    return level === 0 ? words : t(level > 0 ? 'viewer.slightly_above' : 'viewer.slightly_below', {view: words});
  }

  // --- the elements
  const keysId = newId('keys'), summary = el('span', null, options.summary ?? '');
  canvas.setAttribute('aria-describedby', keysId);
  canvas.append(summary);
  const status = el('p', {class: 'hidden', role: 'status'});
  const note = el('p', {class: 'view3d-note', role: 'alert', hidden: true});
  const views = [0, 1, 2, 3, 4, 5].map((i) => el('button', {type: 'button', onclick: () => orbit.view(order()[i]!)}));
  const order = (): ViewName[] => viewOrder(left);
  const tool = (name: IconName, text: string, act: () => void): HTMLButtonElement =>
    el('button', {type: 'button', class: 'icon-only', 'aria-label': text, title: text, onclick: act}, icon(name));
  const touch = el('button', {type: 'button', class: 'view3d-touch', 'aria-pressed': 'false', onclick: () => {
    const active = touch.getAttribute('aria-pressed') !== 'true';
    touch.setAttribute('aria-pressed', String(active));
    touch.textContent = t(active ? 'viewer.touch_done' : 'viewer.touch');
    touchable();
  }}, t('viewer.touch'));
  let hand: Hand = {};
  function touchable(): void {
    canvas.style.touchAction = hand.turn || touch.getAttribute('aria-pressed') === 'true' ? 'none' : 'auto';
  }
  const zoom = el('div', {class: 'view3d-zoom'},
    tool('add', t('viewer.zoom_in'), () => orbit.move({zoom: orbit.pose.zoom * 1.2})),
    tool('minus', t('viewer.zoom_out'), () => orbit.move({zoom: orbit.pose.zoom / 1.2})),
    tool('reset', t('viewer.home'), () => orbit.home()));
  const frame = el('div', {class: 'view3d-frame'}, canvas, note);
  const element = el('figure', {class: 'view3d'}, el('div', {class: 'view3d-stage'}, frame, zoom), status,
    el('div', {class: 'view3d-tools', role: 'group', 'aria-label': t('viewer.views')}, ...views,
      ...options.tools ?? [], touch),
    el('details', {class: 'view3d-keys small'}, el('summary', null, t('viewer.keys_title')), el('p', {id: keysId}, t('viewer.keys'))));

  function markView(): void {
    const now = viewOf(orbit.pose);
    views.forEach((button, i) => button.setAttribute('aria-pressed', String(order()[i] === now)));
  }
  function setSides(side: LeftSide): void {
    left = side;
    order().forEach((name, i) => {
      const known = side === 'unknown' ? name : i === 2 ? 'left' : i === 3 ? 'right' : name;
      views[i]!.textContent = t(`viewer.view_${known}`);
    });
    markView();
  }
  setSides(left);
  control(canvas, orbit, {mmPerPixel, hand: () => hand, touch: () => canvas.style.touchAction === 'none', left: () => left, next: () => zoom.querySelector('button'), signal});

  // --- size, theme, loss of the graphics
  const sizes = new ResizeObserver(() => {
    if (canvas.clientWidth === width && canvas.clientHeight === height) return;
    width = canvas.clientWidth;
    height = canvas.clientHeight;
    renderer.setSize(width, height, false);
    if (width && height) render();
  });
  sizes.observe(canvas);

  const colour = (token: string): Color =>
    new Color(getComputedStyle(element.isConnected ? element : document.documentElement).getPropertyValue(token).trim() || '#888');
  function applyTheme(): void {
    scene.background = colour('--ground');
    tell('theme');
    schedule();
  }
  const themes = new MutationObserver(applyTheme);
  themes.observe(document.documentElement, {attributes: true, attributeFilter: ['data-theme']});
  for (const query of ['(prefers-color-scheme: dark)', '(prefers-contrast: more)'])
    matchMedia(query).addEventListener('change', applyTheme, {signal});
  applyTheme();

  canvas.addEventListener('webglcontextlost', (event) => {
    event.preventDefault();
    if (lost && performance.now() - lost < 60_000) {
      dispose();
      options.failed?.();
      return;
    }
    lost = performance.now();
    note.textContent = t('viewer.lost');
    note.hidden = false;
  }, {signal});
  canvas.addEventListener('webglcontextrestored', () => {
    note.hidden = true;
    status.textContent = t('viewer.restored');
    cost = null;
    schedule();
  }, {signal});

  function dispose(): void {
    if (disposed) return;
    disposed = true;
    ending.abort();
    sizes.disconnect();
    themes.disconnect();
    cancelAnimationFrame(scheduled);
    clearTimeout(restTimer);
    clearTimeout(speakTimer);
    release(root);
    renderer.dispose();
    context!.getExtension('WEBGL_lose_context')?.loseContext();
  }

  function snapshot(): HTMLCanvasElement {
    draw(fullRatio());
    const copy = el('canvas', {width: canvas.width, height: canvas.height});
    copy.getContext('2d')?.drawImage(canvas, 0, 0);
    schedule();
    return copy;
  }

  return {
    element, frame, canvas, root, quality, invalidate, setSides, mmPerPixel, colour, viewWords, snapshot, dispose,
    get camera() { return orbit.text; },
    set camera(text) { orbit.text = text; },
    get hand() { return hand; },
    set hand(does) {
      hand = does;
      touchable();
    },
    get halves() { return halves; },
    set halves(draws) { halves = draws; },
    setSummary: (text) => { summary.textContent = text; },
    setView: (name) => orbit.view(name),
    home: () => orbit.home(),
    lookAt: (x, y, z, zoom = orbit.pose.zoom) => orbit.move({x, y, z, zoom}),
    turnTo: (x, y, z) => orbit.turnTo(x, y, z),
    fit(points) {
      const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
      for (let i = 0; i < points.length; ++i) {
        low[i % 3] = Math.min(low[i % 3]!, points[i]!);
        high[i % 3] = Math.max(high[i % 3]!, points[i]!);
      }
      const [x = 0, y = 0, z = 0] = low.map((value, k) => (value + high[k]!) / 2);
      let far = 0;
      for (let i = 0; i + 2 < points.length; i += 3)
        far = Math.max(far, Math.hypot(points[i]! - x, points[i + 1]! - y, points[i + 2]! - z));
      if (far > 0) orbit.fit(x, y, z, far * 1.02);
      schedule();
    },
    ray(event) {
      aim();  // the camera may have moved since the last frame
      const box = canvas.getBoundingClientRect();
      const across = event ? (event.clientX - box.left) / box.width * 2 : 1;  // 0 to 2
      const at = event ? [halves ? across % 1 * 2 - 1 : across - 1, 1 - (event.clientY - box.top) / box.height * 2] : [0, 0];
      const to = new Vector3(at[0], at[1], 0.5).unproject(camera);
      return new Ray(camera.position.clone(), to.sub(camera.position).normalize());
    },
    toFrame(point) {
      const p = point.clone().project(camera);
      return {x: (p.x + 1) / 2 * width, y: (1 - p.y) / 2 * height, hidden: p.z > 1};
    },
    on: (event, listener) => void listeners[event].push(listener),
    picture: () => new Promise((resolve, reject) => {
      snapshot().toBlob((blob) => blob ? resolve(blob) : reject(new Error('the picture is empty')), 'image/png');
    }),
  };
}

function drawsInSoftware(context: WebGL2RenderingContext): boolean {
  const plain = String(context.getParameter(context.RENDERER));
  const info = plain === 'WebKit WebGL' ? context.getExtension('WEBGL_debug_renderer_info') : null;
  return /SwiftShader|llvmpipe|Basic Render/.test(info ? String(context.getParameter(info.UNMASKED_RENDERER_WEBGL)) : plain);
}

// Takes an object out of its parent and frees what it holds on the graphics card.
export function release(object: Object3D): void {
  object.removeFromParent();
  object.traverse((part) => {
    const {geometry, material} = part as {geometry?: BufferGeometry; material?: Material | Material[]};
    geometry?.dispose();
    for (const one of material ? [material].flat() : []) one.dispose();
  });
}
