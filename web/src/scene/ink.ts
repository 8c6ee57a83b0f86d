// The pictures on the formed sheet. What is printed can be drawn here in place of the picture that the file has.
import {CanvasTexture, LinearMipmapLinearFilter, NoColorSpace, Texture} from 'three';

export type Paint = (context: CanvasRenderingContext2D) => void;

function asPicture<T extends Texture>(texture: T): T {
  texture.flipY = false;
  texture.colorSpace = NoColorSpace;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.needsUpdate = true;
  return texture;
}

export async function picture(blob: Blob): Promise<Texture<ImageBitmap>> {
  return asPicture(new Texture(await createImageBitmap(blob, {colorSpaceConversion: 'none', premultiplyAlpha: 'none'})));
}

// Where the sheet lies on a picture, as picturePlace in read/formed.ts has it.
export interface PicturePlace {
  size: readonly [number, number];
  origin: readonly [number, number];
}

// From millimetres of the sheet, t up, to the pixels of a picture of that size.
export function toSheet(context: CanvasRenderingContext2D, {size, origin}: PicturePlace, width: number, height: number): void {
  context.setTransform(width / size[0], 0, 0, height / size[1], width * origin[0], height * origin[1]);
}

// Ink on white, in the place and size of `like`.
export function drawnInk(like: Texture<ImageBitmap>, place: PicturePlace, paint: Paint): Texture {
  const canvas = document.createElement('canvas'), {width, height} = like.image;
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext('2d');
  if (context) {
    context.fillStyle = '#fff';
    context.fillRect(0, 0, width, height);
    toSheet(context, place, width, height);
    paint(context);
  }
  const texture = asPicture(new CanvasTexture(canvas));
  texture.anisotropy = like.anisotropy;
  return texture;
}
