// What lies under a ray or next to a place of the formed sheet.
import type {Formed} from '../read/formed';
import {hit} from './hit';
import {distance, type Point, type SurfacePoint} from './measure';

export interface Spot extends SurfacePoint {
  normal: Point;
  sheet: [number, number];           // (s, t) mm
  pattern: [number, number] | null;  // (u, v) mm; null off the chart
  thickness: number;
  temperature: number;
  shape: number | null;
  area: number | null;
  contact: number;                   // of the nearest vertex
}

export function under(formed: Formed, origin: Point, direction: Point): Spot | null {
  const found = hit(formed, origin, direction);
  return found && spotOf(formed, found.face, found.shares);
}

// The vertex that is nearest to a place.
export function nearest(formed: Formed, place: Point): Spot {
  const {positions: p, indices} = formed;
  let best = 0, least = Infinity;
  for (let i = 0; i < p.length / 3; ++i) {
    const far = distance(place, [p[3 * i]!, p[3 * i + 1]!, p[3 * i + 2]!]);
    if (far < least) [least, best] = [far, i];
  }
  const at = Math.max(0, indices.indexOf(best)), shares: [number, number, number] = [0, 0, 0];
  shares[at % 3] = 1;
  return spotOf(formed, Math.floor(at / 3), shares);
}

function spotOf(formed: Formed, face: number, shares: readonly [number, number, number]): Spot {
  const vertices = [0, 1, 2].map((k) => formed.indices[3 * face + k]!);
  const mean = (values: Float32Array, size = 1, which = 0): number =>
    shares.reduce((sum, share, k) => sum + share * values[size * vertices[k]! + which]!, 0);
  const pair = (values: Float32Array): [number, number] => [mean(values, 2, 0), mean(values, 2, 1)];
  const three = (values: Float32Array): [number, number, number] => [mean(values, 3, 0), mean(values, 3, 1), mean(values, 3, 2)];
  const onChart = vertices.every((i) => formed.chart[i] === 1), normal = three(formed.normals), length = Math.hypot(...normal) || 1;
  return {
    face, point: three(formed.positions), normal: [normal[0] / length, normal[1] / length, normal[2] / length], sheet: pair(formed.sheet),
    pattern: onChart ? pair(formed.pattern) : null, thickness: mean(formed.thickness), temperature: mean(formed.temperature),
    shape: onChart ? mean(formed.shape) : null, area: onChart ? mean(formed.area) : null,
    contact: formed.contact[vertices[shares.indexOf(Math.max(...shares))]!]!,
  };
}
