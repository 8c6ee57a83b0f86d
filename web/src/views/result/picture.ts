// The picture of the view as a PNG with what it shows burnt in: identity, map, colours, point of view.

export interface PictureText {
  title: string;      // what is shown
  view: string;       // from where
  identity: string;
  halves?: [string, string];  // side by side
  cut?: {share: number; left: string; right: string};
  colours?: {css: readonly string[]; marks: readonly [share: number, text: string][]; unit: string};
}

export function framed(view: HTMLCanvasElement, text: PictureText): Promise<Blob> {
  const canvas = document.createElement('canvas'), scale = Math.max(1, view.width / 1000);
  const context = canvas.getContext('2d');
  if (!context) return Promise.reject(new Error('no canvas'));
  const px = (size: number): number => Math.round(size * scale), pad = px(20);
  const font = (size: number, weight = 400): string => `${weight} ${px(size)}px system-ui, "DejaVu Sans", sans-serif`;
  const wrapped = (words: string, width: number): string[] => words.split(' ').reduce<string[]>((lines, word) => {
    const longer = `${lines.at(-1) ?? ''} ${word}`.trim();
    if (lines.length > 0 && context.measureText(longer).width <= width) lines[lines.length - 1] = longer;
    else lines.push(word);
    return lines;
  }, []);
  context.font = font(15);
  const identity = wrapped(text.identity, view.width - 2 * pad);
  const top = px(70), bottom = pad + identity.length * px(22) + (text.colours ? px(62) : 0);
  canvas.width = view.width;
  canvas.height = view.height + top + bottom;
  context.fillStyle = '#fff';
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.drawImage(view, 0, top);
  context.fillStyle = '#212b32';
  context.font = font(22, 600);
  context.fillText(text.title, pad, px(30));
  context.font = font(15);
  context.fillText(text.view, pad, px(55));
  const tag = (words: string, x: number, align: CanvasTextAlign): void => {
    context.font = font(15, 600);
    context.textAlign = align;
    const width = context.measureText(words).width + px(16), left = align === 'left' ? x : x - width;
    context.fillStyle = '#fff';
    context.fillRect(left, top + px(10), width, px(26));
    context.fillStyle = '#212b32';
    context.fillText(words, align === 'left' ? x + px(8) : x - px(8), top + px(28));
    context.textAlign = 'left';
  };
  if (text.halves) {
    tag(text.halves[0], pad, 'left');
    tag(text.halves[1], canvas.width / 2 + pad, 'left');
    context.fillRect(canvas.width / 2 - 1, top, 2, view.height);
  } else if (text.cut) {
    const x = text.cut.share * canvas.width;
    if (text.cut.share > 0.1) tag(text.cut.left, pad, 'left');
    if (text.cut.share < 0.9) tag(text.cut.right, canvas.width - pad, 'right');
    context.fillRect(x - 1, top, 2, view.height);
  }
  let y = top + view.height + pad;
  if (text.colours) {
    const width = Math.min(px(500), canvas.width - 2 * pad), gradient = context.createLinearGradient(pad, 0, pad + width, 0);
    text.colours.css.forEach((colour, i, all) => gradient.addColorStop(i / (all.length - 1), colour));
    context.fillStyle = gradient;
    context.fillRect(pad, y, width, px(14));
    context.fillStyle = '#212b32';
    context.font = font(13);
    context.textAlign = 'center';
    for (const [share, words] of text.colours.marks) {
      context.fillRect(pad + share * width - 0.5, y + px(14), 1, px(4));
      context.fillText(words, pad + share * width, y + px(32));
    }
    context.textAlign = 'left';
    context.fillText(text.colours.unit, pad + width + px(14), y + px(12));
    y += px(62);
  }
  context.font = font(15);
  identity.forEach((line, i) => context.fillText(line, pad, y + px(6) + i * px(22)));
  return new Promise((resolve, reject) => {
    canvas.toBlob((blob) => blob ? resolve(blob) : reject(new Error('the picture is empty')), 'image/png');
  });
}
