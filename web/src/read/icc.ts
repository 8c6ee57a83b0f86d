// The header of an ICC profile (ICC.1:2022, 7.2).

// The colour space of the data, such as "RGB", "CMYK" or "GRAY"; null: this is no ICC profile.
export function iccSpace(head: ArrayBuffer): string | null {
  const text = (from: number): string => String.fromCharCode(...new Uint8Array(head).subarray(from, from + 4));
  return text(36) === 'acsp' ? text(16).trim() : null;
}
