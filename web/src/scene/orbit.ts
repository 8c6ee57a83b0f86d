// Where the camera stands, and how pointer, wheel, touch and keys move it. Millimetres, z up; the face looks along +y, and
// the patient's left is then at -x. Nothing here is animated: the picture follows the hand.

export interface Pose {
  azimuth: number;    // degrees: 0 from the front, 90 from -x, 180 from the back
  elevation: number;  // degrees: 90 from above
  zoom: number;       // 1 shows everything that was fitted
  x: number;          // the point that is looked at
  y: number;
  z: number;
}
export type ViewName = 'front' | 'back' | 'minus_x' | 'plus_x' | 'above' | 'below';
export type LeftSide = 'minus_x' | 'plus_x' | 'unknown';

const directions: Record<ViewName, [number, number]> = {
  front: [0, 0], back: [180, 0], minus_x: [90, 0], plus_x: [-90, 0], above: [180, 90], below: [0, -90]};

const clamp = (value: number, low: number, high: number): number => Math.min(high, Math.max(low, value));
const turned = (degrees: number): number => ((degrees + 180) % 360 + 360) % 360 - 180;  // -180 to 180

// The six views in the order of the keys 1 to 6: front, back, patient's left, patient's right, above, below.
export const viewOrder = (left: LeftSide): ViewName[] =>
  ['front', 'back', ...(left === 'plus_x' ? ['plus_x', 'minus_x'] as const : ['minus_x', 'plus_x'] as const), 'above', 'below'];

// The named view that the camera stands in, if it does.
export function viewOf(pose: Pose): ViewName | undefined {
  return (Object.keys(directions) as ViewName[]).find((name) => {
    const [azimuth, elevation] = directions[name];
    return Math.abs(turned(pose.azimuth - azimuth)) < 0.5 && Math.abs(pose.elevation - elevation) < 0.5;
  });
}

// In eighths of a turn from the front towards -x, and in five steps from below (-2) to above (2).
export function sectorOf(pose: Pose): {eighth: number; height: -2 | -1 | 0 | 1 | 2} {
  const e = pose.elevation, steep = Math.abs(e) > 70 ? 2 : Math.abs(e) > 10 ? 1 : 0;
  return {eighth: Math.round(turned(pose.azimuth) / 45 + 8) % 8, height: (steep * Math.sign(e)) as -2 | -1 | 0 | 1 | 2};
}

export class Orbit {
  first = {azimuth: 25, elevation: 15};  // where home() looks from
  pose: Pose = {...this.first, zoom: 1, x: 0, y: 0, z: 0};
  #home = {x: 0, y: 0, z: 0};
  radius = 100;  // of the sphere that is shown at zoom 1
  readonly halfAngle = Math.PI / 12;  // of the picture's height

  // `changed` is called after every move by hand.
  constructor(private readonly changed: () => void) {}

  distance(aspect: number): number {
    const half = Math.atan(Math.tan(this.halfAngle) * Math.min(1, aspect));
    return this.radius / Math.sin(half) / this.pose.zoom;
  }

  // What zoom 1 shows: a sphere, so that no orbit cuts it. The camera follows unless a person zoomed or moved it.
  fit(x: number, y: number, z: number, radius: number): void {
    const p = this.pose, home = this.#home;
    const untouched = p.zoom === 1 && p.x === home.x && p.y === home.y && p.z === home.z;
    this.#home = {x, y, z};
    this.radius = Math.max(radius, 1e-3);
    if (untouched) Object.assign(this.pose, this.#home);
  }
  home(): void {
    this.move({...this.first, zoom: 1, ...this.#home});
  }
  view(name: ViewName): void {
    const [azimuth, elevation] = directions[name];
    this.move({azimuth, elevation});
  }
  // Looks at a point from outside of the model.
  turnTo(x: number, y: number, z: number): void {
    const dx = x - this.#home.x, dy = y - this.#home.y, dz = z - this.#home.z;
    this.move({azimuth: Math.atan2(-dx, dy) * 180 / Math.PI, elevation: clamp(Math.atan2(dz, Math.hypot(dx, dy)) * 180 / Math.PI, -60, 75),
               x, y, z, zoom: Math.max(2, this.pose.zoom)});
  }
  move(to: Partial<Pose>): void {
    const pose = {...this.pose, ...to};
    this.pose = {...pose, azimuth: turned(pose.azimuth), elevation: clamp(pose.elevation, -90, 90), zoom: clamp(pose.zoom, 0.2, 60)};
    this.changed();
  }
  turn(right: number, down: number): void {  // the model, in degrees
    this.move({azimuth: this.pose.azimuth - right, elevation: this.pose.elevation + down});
  }
  pan(right: number, up: number): void {  // the model, in mm
    const a = this.pose.azimuth * Math.PI / 180, e = this.pose.elevation * Math.PI / 180;
    const {x, y, z} = this.pose;
    this.move({x: x + right * Math.cos(a) - up * Math.sin(e) * Math.sin(a),
               y: y + right * Math.sin(a) + up * Math.sin(e) * Math.cos(a), z: z - up * Math.cos(e)});
  }

  // "25_15_1_0_0_60": short enough for an address.
  get text(): string {
    const {azimuth, elevation, zoom, x, y, z} = this.pose;
    return [azimuth, elevation, zoom, x, y, z].map((value) => String(Math.round(value * 100) / 100)).join('_');
  }
  set text(text: string) {
    const [azimuth, elevation, zoom, x, y, z] = text.split('_').map(Number);
    const pose = {azimuth, elevation, zoom, x, y, z};
    if (Object.values(pose).every((value) => Number.isFinite(value))) this.move(pose as Pose);
  }
}

// What the hand does besides moving the camera.
export interface Hand {
  tap?(event: MouseEvent): void;  // a click that was no drag
  // Dragging and the arrow keys call this instead of turning the camera: degrees to the right and down, for who looks from
  // `azimuth`. `snap`: Shift is held while dragging.
  turn?: ((right: number, down: number, snap: boolean, azimuth: number) => void) | null;
  rest?(): void;                  // no pointer and no key is down any more
  escape?(): void;
  key?(key: string): boolean;     // a letter, small; false: it means nothing
}

// Has the canvas move the camera, or what `hand()` says. `mmPerPixel` at the point that is looked at. `touch()`: whether
// fingers move the model (otherwise they scroll the page). Escape moves the focus on to `next`. `signal` ends it.
export function control(canvas: HTMLCanvasElement, orbit: Orbit, options: {
  mmPerPixel: () => number; hand: () => Hand; touch: () => boolean; left: () => LeftSide; next: () => HTMLElement | null; signal: AbortSignal;
}): void {
  const {signal, mmPerPixel} = options;
  const held = new Map<number, {x: number; y: number}>();
  let down = [0, 0];
  const spread = (): number => {
    const [a, b] = [...held.values()];
    return a && b ? Math.hypot(a.x - b.x, a.y - b.y) : 0;
  };
  const on = <K extends keyof HTMLElementEventMap>(type: K, handle: (event: HTMLElementEventMap[K]) => void): void =>
    canvas.addEventListener(type, handle, {signal, passive: false});

  const turn = (right: number, down: number, snap: boolean): void => {
    const hand = options.hand();
    if (hand.turn) hand.turn(right, down, snap, orbit.pose.azimuth);
    else orbit.turn(right, down);
  };

  on('pointerdown', (event) => {
    down = [event.clientX, event.clientY];
    if (event.pointerType === 'touch' && !options.touch()) return;
    canvas.focus({preventScroll: true});
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, {x: event.clientX, y: event.clientY});
  });
  on('pointermove', (event) => {
    const last = held.get(event.pointerId);
    if (!last) return;
    const dx = event.clientX - last.x, dy = event.clientY - last.y, before = spread();
    held.set(event.pointerId, {x: event.clientX, y: event.clientY});
    if (held.size > 1) {
      if (before > 0) orbit.move({zoom: orbit.pose.zoom * spread() / before});
      orbit.pan(dx / 2 * mmPerPixel(), -dy / 2 * mmPerPixel());
    } else if (event.buttons & 6 || event.ctrlKey || event.metaKey) {
      orbit.pan(dx * mmPerPixel(), -dy * mmPerPixel());
    } else {
      const degrees = 180 / Math.max(200, canvas.clientHeight);
      turn(dx * degrees, dy * degrees, event.shiftKey);
    }
  });
  const rest = (): void => options.hand().rest?.();
  const release = (event: PointerEvent): void => {
    if (held.delete(event.pointerId) && held.size === 0) rest();
  };
  on('pointerup', release);
  on('pointercancel', release);
  on('lostpointercapture', release);
  on('click', (event) => {
    if (Math.hypot(event.clientX - down[0]!, event.clientY - down[1]!) <= 4) options.hand().tap?.(event);
  });
  on('contextmenu', (event) => event.preventDefault());
  on('wheel', (event) => {
    if (document.activeElement !== canvas) return;  // the page scrolls
    event.preventDefault();
    const lines = event.deltaMode === 0 ? event.deltaY / 100 : event.deltaY / 3;
    orbit.move({zoom: orbit.pose.zoom * 1.2 ** -clamp(lines, -3, 3)});
  });
  on('keydown', (event) => {
    if (event.altKey || event.metaKey) return;
    const step = event.shiftKey ? 1 : 5;
    const arrow = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[event.key];
    const view = viewOrder(options.left())[Number(event.key) - 1];
    if (arrow) {
      const [x = 0, y = 0] = arrow;
      if (!event.repeat) rest();  // of another key
      if (event.ctrlKey) orbit.pan(x * 4 * step * mmPerPixel(), -y * 4 * step * mmPerPixel());
      else turn(x * step, y * step, false);
    } else if (event.ctrlKey) return;
    else if (event.key === '+' || event.key === '=') orbit.move({zoom: orbit.pose.zoom * 1.2});
    else if (event.key === '-') orbit.move({zoom: orbit.pose.zoom / 1.2});
    else if (event.key === 'Home') orbit.home();
    else if (event.key === 'Escape') {
      options.hand().escape?.();
      options.next()?.focus();
    }
    else if (view) orbit.view(view);
    else if (!options.hand().key?.(event.key.toLowerCase())) return;
    event.preventDefault();
  });
  on('keyup', rest);
  on('blur', rest);
}
