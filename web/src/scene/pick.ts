// What lies under a ray or next to a place of the formed sheet.
import type {Formed} from '../read/formed';
import {hit} from './hit';
import type {Flat} from '../state/result';
import {distance, type Point, type SurfacePoint} from './measure';

export interface Spot extends SurfacePoint {
  normal: Point;
  sheet: [number, number];           // (s, t) mm
  pattern: [number, number] | null;  // (u, v) mm; null off the chart
  values: ReadonlyMap<string, number | null>;  // of the heat maps by their ids; null where there is no value
  contact: number;                   // of the nearest vertex
}

// Along `direction` from `origin`. `positions`: others of the vertices.
export function under(formed: Formed, origin: Point, direction: Point, positions = formed.positions): Spot | null {
  const found = hit({positions, indices: formed.indices}, origin, direction);
  return found && spotOf(formed, found.face, found.shares);
}

// The point of the sheet, or of the chart, that is nearest to a place: below the place, as the nearest vertex faces, or
// that vertex.
export function nearest(formed: Formed, place: Point, onChart = false): Spot {
  const {positions: p, indices} = formed;
  let best = 0, least = Infinity;
  for (let i = 0; i < p.length / 3; ++i) {
    const far = distance(place, [p[3 * i]!, p[3 * i + 1]!, p[3 * i + 2]!]);
    if (far < least && !(onChart && formed.chart[i] !== 1)) [least, best] = [far, i];
  }
  const at = Math.max(0, indices.indexOf(best)), shares: [number, number, number] = [0, 0, 0];
  shares[at % 3] = 1;
  const vertex = spotOf(formed, Math.floor(at / 3), shares), [x, y, z] = vertex.normal, above = 25;  // mm; points of the mold lie at most 20 off
  const below = under(formed, [place[0] + above * x, place[1] + above * y, place[2] + above * z], [-x, -y, -z]);
  return below && distance(below.point, place) <= least && (below.pattern || !onChart) ? below : vertex;
}

// Where the vertices' pairs of numbers, `sheet` or `pattern`, have this value.
export function having(formed: Formed, name: 'sheet' | 'pattern', [a, b]: Flat): Spot | null {
  const flat = formed.positions.map((_, i) => {
    const vertex = Math.floor(i / 3);
    return formed.chart[vertex] !== 1 ? NaN : i % 3 < 2 ? formed[name][2 * vertex + i % 3]! : 0;
  });
  return under(formed, [a + 1e-4, b + 2e-4, 1], [0, 0, -1], flat);  // beside the edges of a grid
}

function spotOf(formed: Formed, face: number, shares: readonly [number, number, number]): Spot {
  const vertices = [0, 1, 2].map((k) => formed.indices[3 * face + k]!);
  const mean = (values: Float32Array, size = 1, which = 0): number =>
    shares.reduce((sum, share, k) => sum + share * values[size * vertices[k]! + which]!, 0);
  const pair = (values: Float32Array): [number, number] => [mean(values, 2, 0), mean(values, 2, 1)];
  const three = (values: Float32Array): [number, number, number] => [mean(values, 3, 0), mean(values, 3, 1), mean(values, 3, 2)];
  const known = (values: Float32Array): number | null => vertices.every((i) => values[i]! >= 0) ? mean(values) : null;
  const onChart = vertices.every((i) => formed.chart[i] === 1), normal = three(formed.normals), length = Math.hypot(...normal) || 1;
  const contact = formed.contact[vertices[shares.indexOf(Math.max(...shares))]!]!;
  return {
    face, point: three(formed.positions), normal: [normal[0] / length, normal[1] / length, normal[2] / length], sheet: pair(formed.sheet),
    pattern: onChart ? pair(formed.pattern) : null, contact, values: new Map([...formed.maps].map(([id, values]) => [id, known(values)])),
  };
}
