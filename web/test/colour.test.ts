import assert from 'node:assert/strict';
import {test} from 'node:test';
import {colourAt, css, marksOf} from '../src/scene/colour';

const map = {colours: ['#f7f7f7', '#fdb863', '#7f3b08']};

test('colours are linear between those of the report, and stay outside of the range', () => {
  assert.equal(css(colourAt(map, 0)), 'rgb(247 247 247)');
  assert.equal(css(colourAt(map, 0.25)), 'rgb(250 216 173)');
  assert.equal(css(colourAt(map, 0.5)), 'rgb(253 184 99)');
  assert.deepEqual(colourAt(map, -1), colourAt(map, 0));
  assert.deepEqual(colourAt(map, 7), colourAt(map, 1));
});

test('marks lie at round numbers within the range', () => {
  assert.deepEqual(marksOf({low: 1, high: 2, step: 0.2}), [1, 1.2, 1.4, 1.6, 1.8, 2]);
  assert.deepEqual(marksOf({low: 0.35, high: 1, step: 0.1}), [0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1]);
});
