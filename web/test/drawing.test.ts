import assert from 'node:assert/strict';
import test from 'node:test';
import {pictureSize, svgSize, svgWithSize} from '../src/read/drawing';

const rounded = (text: string): (number | null)[] => {
  const {width, height, aspect} = svgSize(text);
  return [width, height, aspect].map((value) => value && Math.round(value * 1000) / 1000);
};

test('reads the physical size of an SVG as the service does', () => {
  assert.deepEqual(rounded('<svg width="186.4mm" height="93.2mm" viewBox="0 0 2 1"/>'), [186.4, 93.2, 2]);
  assert.deepEqual(rounded("<?xml version='1.0'?><!-- <svg width='1mm'> --><!DOCTYPE svg [<!ENTITY a 'b'>]><svg width='2in' height='72PT'>"), [50.8, 25.4, 2]);
  assert.deepEqual(rounded('<s:svg xmlns:s="x" title="a > b" width="4cm" viewBox="0,0 20 10">'), [40, 20, 2]);
  assert.deepEqual(rounded('<svg viewBox="-1 -1 3 2" width="100%">'), [null, null, 1.5]);
  assert.deepEqual(rounded('<svg stroke-width="3" height="72pt" viewBox="0 0 1 1">'), [25.4, 25.4, 1]);
  assert.deepEqual(rounded('<html><p>no drawing</p>'), [null, null, null]);
  assert.deepEqual(rounded('<svg width="-3mm" height="0"/>'), [null, null, null]);
});

test('knows the pixels of a program, and asks otherwise', () => {
  const illustrator = '<!-- Generator: Adobe Illustrator 24.0.1, SVG Export Plug-In -->';
  assert.deepEqual(rounded(`${illustrator}<svg width="144px" height="36px">`), [50.8, 12.7, 4]);
  assert.deepEqual(rounded(`${illustrator}<svg viewBox="0 0 144 36">`), [50.8, 12.7, 4]);
  assert.deepEqual(rounded('<svg width="180" height="45" inkscape:version="0.91 r13725">'), [50.8, 12.7, 4]);
  assert.deepEqual(rounded('<svg width="192" height="48" inkscape:version="0.92.3 (2405546)">'), [50.8, 12.7, 4]);
  assert.equal(svgSize('<svg width="192" height="48" inkscape:version="1.2">').program, 'Inkscape 1.2');
  assert.deepEqual(rounded('<svg width="120" height="30">'), [null, null, 4]);
  assert.deepEqual(svgSize('<svg width="120px" height="30px">').px?.map(Math.round), [120, 30]);
  assert.deepEqual(rounded('<svg width="120mm" height="30px" viewBox="0 0 6 2">'), [null, null, 3]);
  assert.deepEqual(rounded(`${illustrator}<svg width="144" height="36" inkscape:version="1.2">`), [null, null, 4]);
});

test('gives an SVG without a size one for the screen', () => {
  assert.equal(svgWithSize('<svg viewBox="0 0 4 2"><g/></svg>'), '<svg width="800" height="400" viewBox="0 0 4 2"><g/></svg>');
  assert.equal(svgWithSize('<svg width="1mm" height="1mm"/>'), '<svg width="1mm" height="1mm"/>');
});

function png(across: number, down: number, perMetre: number): ArrayBuffer {
  const view = new DataView(new ArrayBuffer(8 + 25 + 21 + 12));
  [0x89504e47, 0x0d0a1a0a, 13, 0x49484452, across, down].forEach((word, i) => view.setUint32(i * 4, word));
  [9, 0x70485973, perMetre, perMetre].forEach((word, i) => view.setUint32(33 + i * 4, word));
  view.setUint8(49, 1);
  view.setUint32(58, 0x49444154);
  return view.buffer;
}

test('reads the physical size of a PNG from its pixels in a metre', () => {
  const size = pictureSize(png(1000, 500, 10_000));
  assert.deepEqual(size, {width: 100, height: 50, aspect: 2, px: [1000, 500]});
  assert.deepEqual(pictureSize(png(1000, 500, 0)), {width: null, height: null, aspect: 2, px: [1000, 500]});
});

test('reads the physical size of a JPEG from its density', () => {
  const jpeg = [0xff, 0xd8, 0xff, 0xe0, 0, 16, 0x4a, 0x46, 0x49, 0x46, 0, 1, 1, 1, 0, 254, 0, 254, 0, 0,
                0xff, 0xc0, 0, 17, 8, 0, 100, 0, 200, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0];
  const {width, height, aspect} = pictureSize(new Uint8Array(jpeg).buffer);
  assert.deepEqual([width, height, aspect].map((value) => Math.round((value ?? 0) * 100) / 100), [20, 10, 2]);
});

test('says nothing of broken pictures', () => {
  const whole = png(10, 10, 1000);
  for (let end = 0; end < whole.byteLength; ++end) pictureSize(whole.slice(0, end));
  assert.deepEqual(pictureSize(new Uint8Array([0xff, 0xd8, 0xff, 0xe0, 0, 0]).buffer), {width: null, height: null, aspect: null});
});
