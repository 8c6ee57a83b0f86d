// The shortest way along a triangulated surface between two points. A search over points on the edges (A*) finds the strip
// of triangles; within it the way is exact: the strip is laid flat and the string pulled tight (Lee and Preparata 1984).
// Where it then bends at a vertex, the other side of the vertex is tried, until no side is shorter. The result is a
// geodesic of the mesh; a test compares it with great circles.

export type Point = readonly [number, number, number];
export interface SurfacePoint {
  face: number;
  point: Point;
}
export interface Way {
  length: number;   // mm
  points: Point[];  // from one end to the other, on the edges that it crosses
  crossed: [from: number, to: number, share: number][];  // these edges, by their vertices, and where
}
interface Strip {
  edges: number[];  // crossed, in order
  faces: number[];  // one more than edges
}
interface Flat {
  x: number;
  y: number;
}

const onEdge = 2;  // points of the search on each edge

export class Surface {
  readonly #vertices: Int32Array;      // of the triangles; copies of a point are one
  readonly #edges: Int32Array;         // of the triangles: side k goes from corner k to the next
  readonly #ends: number[] = [];       // two vertices an edge
  readonly #faces: number[] = [];      // two triangles an edge, -1: none

  constructor(private readonly positions: Float32Array, indices: Uint32Array) {
    const one = joined(positions);
    this.#vertices = Int32Array.from(indices, (i) => one[i]!);
    this.#edges = new Int32Array(indices.length);
    const known = new Map<number, number>();
    for (let i = 0; i < indices.length; ++i) {
      const a = this.#vertices[i]!, b = this.#vertices[i % 3 === 2 ? i - 2 : i + 1]!;
      const key = Math.min(a, b) * one.length + Math.max(a, b), face = Math.floor(i / 3);
      const edge = known.get(key);
      if (edge === undefined) {
        known.set(key, this.#ends.length / 2);
        this.#edges[i] = this.#ends.length / 2;
        this.#ends.push(a, b);
        this.#faces.push(face, -1);
      } else {
        this.#edges[i] = edge;
        if (this.#faces[2 * edge + 1] === -1) this.#faces[2 * edge + 1] = face;
      }
    }
  }

  // null: no way leads there.
  way(from: SurfacePoint, to: SurfacePoint): Way | null {
    if (from.face === to.face) return {length: distance(from.point, to.point), points: [from.point, to.point], crossed: []};
    let strip = this.#search(from, to);
    if (!strip) return null;
    let best = this.#pull(strip, from, to);
    for (let rounds = 0; rounds < 200; ++rounds) {
      let shorter = false;
      for (const bend of best.bends) {
        const other = this.#aroundTheOtherSide(strip, bend.at, bend.vertex);
        const way = other && this.#pull(other, from, to);
        if (!way || way.length > best.length - 1e-9) continue;
        strip = other;
        best = way;
        shorter = true;
        break;
      }
      if (!shorter) break;
    }
    return best;
  }

  #at(vertex: number): Point {
    return [this.positions[3 * vertex]!, this.positions[3 * vertex + 1]!, this.positions[3 * vertex + 2]!];
  }
  #onEdge(edge: number, share: number): Point {
    return between3(this.#at(this.#ends[2 * edge]!), this.#at(this.#ends[2 * edge + 1]!), share);
  }
  #across(edge: number, face: number): number {
    return this.#faces[2 * edge] === face ? this.#faces[2 * edge + 1]! : this.#faces[2 * edge]!;
  }
  #has(edge: number, vertex: number): boolean {
    return this.#ends[2 * edge] === vertex || this.#ends[2 * edge + 1] === vertex;
  }

  #search(from: SurfacePoint, to: SurfacePoint): Strip | null {
    const nodes = this.#ends.length / 2 * onEdge;
    const far = new Float64Array(nodes).fill(Infinity);
    const before = new Int32Array(nodes).fill(-1), through = new Int32Array(nodes);
    const open = new Heap();
    const place = (node: number): Point => this.#onEdge(Math.floor(node / onEdge), (node % onEdge + 0.5) / onEdge);
    const reach = (face: number, here: Point, length: number, by: number): void => {
      const skip = by < 0 ? -1 : Math.floor(by / onEdge);
      for (let side = 0; side < 3; ++side) {
        const edge = this.#edges[3 * face + side]!;
        if (edge === skip) continue;
        for (let node = edge * onEdge; node < (edge + 1) * onEdge; ++node) {
          const there = place(node), sum = length + distance(here, there);
          if (sum >= far[node]!) continue;
          far[node] = sum;
          before[node] = by;
          through[node] = face;
          open.push(sum + distance(there, to.point), node);
        }
      }
    };
    reach(from.face, from.point, 0, -1);
    let best = Infinity, last = -1;
    for (let next = open.pop(); next && next.cost < best; next = open.pop()) {
      const here = place(next.node), length = far[next.node]!;
      if (next.cost > length + distance(here, to.point) + 1e-9) continue;  // reached on a shorter way meanwhile
      const face = this.#across(Math.floor(next.node / onEdge), through[next.node]!);
      if (face === to.face) {
        best = next.cost;
        last = next.node;
      } else if (face >= 0) reach(face, here, length, next.node);
    }
    if (last < 0) return null;
    const strip: Strip = {edges: [], faces: [to.face]};
    for (let node = last; node >= 0; node = before[node]!) {
      strip.edges.unshift(Math.floor(node / onEdge));
      strip.faces.unshift(through[node]!);
    }
    return strip;
  }

  // The shortest way within the strip, and where it bends: at which crossing and vertex.
  #pull({edges}: Strip, from: SurfacePoint, to: SurfacePoint): Way & {bends: {at: number; vertex: number}[]} {
    let right = this.#ends[2 * edges[0]!]!, left = this.#ends[2 * edges[0]! + 1]!;
    const base = inPlane(this.#at(right), this.#at(left), from.point);
    let flatRight: Flat = {x: 0, y: 0}, flatLeft: Flat = {x: base.length, y: 0};
    const beyond = (point: Point): Flat => {
      const {length, along, off} = inPlane(this.#at(right), this.#at(left), point);
      const dx = (flatLeft.x - flatRight.x) / length, dy = (flatLeft.y - flatRight.y) / length;
      return {x: flatRight.x + along * dx + off * dy, y: flatRight.y + along * dy - off * dx};
    };
    const gates = [{left, right, flatLeft, flatRight}];
    for (let i = 1; i < edges.length; ++i) {
      const a = this.#ends[2 * edges[i]!]!, b = this.#ends[2 * edges[i]! + 1]!;
      const tip = a === left || a === right ? b : a;
      const flat = beyond(this.#at(tip));
      if (this.#has(edges[i]!, left)) [right, flatRight] = [tip, flat];
      else [left, flatLeft] = [tip, flat];
      gates.push({left, right, flatLeft, flatRight});
    }
    const start: Flat = {x: base.along, y: base.off}, end = beyond(to.point);

    // corners of the tight string: the gate and the side
    const corners: {at: number; flat: Flat; vertex: number}[] = [];
    let apex = start, l = gates[0]!.flatLeft, r = gates[0]!.flatRight, li = 0, ri = 0;
    const turn = (a: Flat, b: Flat, c: Flat): number => (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    for (let i = 1; i <= gates.length; ++i) {
      const gate = gates[i], newLeft = gate?.flatLeft ?? end, newRight = gate?.flatRight ?? end;
      if (turn(apex, r, newRight) >= 0) {  // narrower from the right
        if (same(apex, r) || turn(apex, l, newRight) < 0) {
          if (!gate) break;
          [r, ri] = [newRight, i];
        } else {
          corners.push({at: li, flat: l, vertex: gates[li]!.left});
          apex = l;
          i = li;
          [l, r, ri] = [apex, apex, li];
          continue;
        }
      }
      if (turn(apex, l, newLeft) <= 0) {
        if (same(apex, l) || turn(apex, r, newLeft) > 0) [l, li] = [newLeft, i];
        else {
          corners.push({at: ri, flat: r, vertex: gates[ri]!.right});
          apex = r;
          i = ri;
          [l, r, li] = [apex, apex, ri];
        }
      }
    }

    const points: Point[] = [from.point], crossed: Way['crossed'] = [];
    let length = 0, here = start, next = 0;
    const stops = [...corners.map(({flat}) => flat), end];
    gates.forEach((gate, i) => {
      while (next < corners.length && corners[next]!.at < i) length += between(here, here = stops[next++]!);
      const to = stops[next]!;
      const a = turn(here, to, gate.flatRight), b = turn(here, to, gate.flatLeft);
      const share = a === b ? 0 : Math.min(1, Math.max(0, a / (a - b)));
      crossed.push([gate.right, gate.left, share]);
      points.push(between3(this.#at(gate.right), this.#at(gate.left), share));
    });
    while (next < stops.length) length += between(here, here = stops[next++]!);
    points.push(to.point);
    return {length, points, crossed, bends: corners.map(({at, vertex}) => ({at, vertex}))};
  }

  #aroundTheOtherSide({edges, faces}: Strip, at: number, vertex: number): Strip | null {
    let first = at, last = at;
    while (first > 0 && this.#has(edges[first - 1]!, vertex)) --first;
    while (last + 1 < edges.length && this.#has(edges[last + 1]!, vertex)) ++last;
    const goal = faces[last + 1]!, around: number[] = [], between: number[] = [];
    let face = faces[first]!, edge = edges[first]!;
    for (let steps = 0; steps < 100; ++steps) {
      const other = [0, 1, 2].map((side) => this.#edges[3 * face + side]!).find((e) => e !== edge && this.#has(e, vertex));
      if (other === undefined) return null;
      face = this.#across(edge = other, face);
      if (face < 0) return null;
      around.push(edge);
      if (face === goal)
        return {edges: [...edges.slice(0, first), ...around, ...edges.slice(last + 1)],
                faces: [...faces.slice(0, first + 1), ...between, ...faces.slice(last + 1)]};
      between.push(face);
    }
    return null;
  }
}

export const distance = (a: Point, b: Point): number => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
const between3 = (a: Point, b: Point, share: number): Point =>
  [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])];
const between = (a: Flat, b: Flat): number => Math.hypot(a.x - b.x, a.y - b.y);
const same = (a: Flat, b: Flat): boolean => between(a, b) < 1e-12;

// Where `point` lies seen from the line from a to b: how far along it and how far off it.
function inPlane(a: Point, b: Point, point: Point): {length: number; along: number; off: number} {
  const length = distance(a, b) || 1e-12;
  const along = ((point[0] - a[0]) * (b[0] - a[0]) + (point[1] - a[1]) * (b[1] - a[1]) + (point[2] - a[2]) * (b[2] - a[2])) / length;
  return {length, along, off: Math.sqrt(Math.max(0, distance(a, point) ** 2 - along ** 2))};
}

// For each vertex the first one at the same place.
function joined(positions: Float32Array): Int32Array {
  const count = positions.length / 3, bits = new Int32Array(positions.buffer, positions.byteOffset, positions.length);
  const mask = 2 ** Math.ceil(Math.log2(2 * count + 1)) - 1, table = new Int32Array(mask + 1).fill(-1);
  return Int32Array.from({length: count}, (_, i) => {
    const x = bits[3 * i]!, y = bits[3 * i + 1]!, z = bits[3 * i + 2]!;
    let at = Math.imul(Math.imul(Math.imul(x, 73856093) ^ y, 19349663) ^ z, 83492791) >>> 7 & mask;
    for (let found = table[at]!; found >= 0; found = table[at = (at + 1) & mask]!)
      if (bits[3 * found] === x && bits[3 * found + 1] === y && bits[3 * found + 2] === z) return found;
    return table[at] = i;
  });
}

// The cheapest first.
class Heap {
  readonly #costs: number[] = [];
  readonly #nodes: number[] = [];

  push(cost: number, node: number): void {
    let at = this.#costs.length;
    while (at > 0) {
      const up = (at - 1) >> 1;
      if (this.#costs[up]! <= cost) break;
      this.#costs[at] = this.#costs[up]!;
      this.#nodes[at] = this.#nodes[up]!;
      at = up;
    }
    this.#costs[at] = cost;
    this.#nodes[at] = node;
  }
  pop(): {cost: number; node: number} | null {
    const cost = this.#costs[0], node = this.#nodes[0];
    if (cost === undefined || node === undefined) return null;
    const lastCost = this.#costs.pop()!, lastNode = this.#nodes.pop()!, count = this.#costs.length;
    let at = 0;
    while (count > 0) {
      let down = 2 * at + 1;
      if (down >= count) break;
      if (down + 1 < count && this.#costs[down + 1]! < this.#costs[down]!) ++down;
      if (this.#costs[down]! >= lastCost) break;
      this.#costs[at] = this.#costs[down]!;
      this.#nodes[at] = this.#nodes[down]!;
      at = down;
    }
    if (count > 0) {
      this.#costs[at] = lastCost;
      this.#nodes[at] = lastNode;
    }
    return {cost, node};
  }
}
