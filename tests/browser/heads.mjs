// A head that no mirror and no turn maps onto itself, as an OBJ: a nose in front (+y), a large ear on the patient's left (-x)
// alone, a small hump on the right of the crown (+x). 150 x 190 x 230 mm, z up; `shift`: added to every corner, mm; `scale`:
// of the whole.
export function head({scale = 1, shift = [0, 0, 0], turn = 0} = {}) {
  const rows = 48, columns = 96, lines = [], c = Math.cos(turn * Math.PI / 180), s = Math.sin(turn * Math.PI / 180);
  const bump = (p, at, wide, high) => high * Math.exp(-((p[0] - at[0]) ** 2 + (p[1] - at[1]) ** 2 + (p[2] - at[2]) ** 2) / (2 * wide * wide));
  for (let i = 0; i <= rows; ++i)
    for (let j = 0; j < columns; ++j) {
      const e = Math.PI * (i / rows - 0.5), a = 2 * Math.PI * j / columns, n = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
      const far = 1 + bump(n, [0, 1, 0], 0.09, 0.2) + bump(n, [-1, 0, 0], 0.11, 0.3) + bump(n, [0.5, 0, 0.86], 0.15, 0.08);
      const [x, y, z] = [75 * n[0] * far, 95 * n[1] * far, 115 * n[2] * far];
      lines.push(`v ${[c * x - s * y, s * x + c * y, z].map((value, k) => (value * scale + shift[k]).toFixed(4)).join(' ')}`);
    }
  const at = (i, j) => i * columns + j % columns + 1;
  for (let i = 0; i < rows; ++i)
    for (let j = 0; j < columns; ++j) {
      if (i > 0) lines.push(`f ${at(i, j)} ${at(i, j + 1)} ${at(i + 1, j + 1)}`);
      if (i < rows - 1) lines.push(`f ${at(i, j)} ${at(i + 1, j + 1)} ${at(i + 1, j)}`);
    }
  return lines.join('\n');
}
