import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';
import test from 'node:test';
import {parseNumber, typed} from '../src/parts/number-field';

const value = (text: string, language: string): unknown => {
  const parsed = parseNumber(text, language);
  return parsed.kind === 'number' ? parsed.value : parsed.kind;
};

test('reads a decimal comma and a decimal point in both languages', () => {
  for (const language of ['en', 'de']) {
    assert.equal(value('1,5', language), 1.5);
    assert.equal(value('1.5', language), 1.5);
    assert.equal(value('-0,25', language), -0.25);
    assert.equal(value('−3', language), -3);
    assert.equal(value(' 12 ', language), 12);
    assert.equal(value('.5', language), 0.5);
    assert.equal(value('5.', language), 5);
    assert.equal(value('1234.5678', language), 1234.5678);
  }
});

test('asks about a German 1.234 and an English 1,234', () => {
  assert.deepEqual(parseNumber('1.234', 'de'), {kind: 'doubt', grouped: 1234, decimal: 1.234});
  assert.deepEqual(parseNumber('-12,345', 'en'), {kind: 'doubt', grouped: -12345, decimal: -12.345});
  assert.equal(value('1,234', 'de'), 1.234);
  assert.equal(value('1.234', 'en'), 1.234);
  assert.equal(value('0.500', 'de'), 0.5);
  assert.equal(value('1.2345', 'de'), 1.2345);
});

test('reads marks between groups', () => {
  for (const language of ['en', 'de']) {
    assert.equal(value('1.234,5', language), 1234.5);
    assert.equal(value('1,234.5', language), 1234.5);
    assert.equal(value('1.234.567', language), 1234567);
    assert.equal(value('1 234 567', language), 1234567);
    assert.equal(value("12'345.68", language), 12345.68);
  }
});

test('refuses what is not one number', () => {
  for (const text of ['abc', '1e3', '1.2.3', '1,23,456', '1.234,5.6', '--1', '5 mm', '.', ',', '0x10', '1.23,456.7', '1,234.567,8'])
    assert.equal(value(text, 'de'), 'none', text);
  assert.equal(value('  ', 'de'), 'empty');
});

test('writes numbers so that they are read back as they were', () => {
  for (const language of ['en', 'de'])
    for (const number of [0, 1.5, -0.1, 1234, 12345.678, 0.30000000000000004])
      assert.equal(value(typed(number, language), language), Number(number.toPrecision(12)));
});

// The settings of the service, from its reference.
const root = process.env['VACUFORM_WEB'] ?? '';
const reference = readFileSync(join(root, '../docs/reference/settings.md'), 'utf8');
const ids = [...reference.matchAll(/^\| `([a-z]+\.[a-z_0-9]+)` \|/gm)].map((match) => match[1] ?? '');

for (const language of ['en', 'de']) {
  const texts = JSON.parse(readFileSync(join(root, 'lang', language, 'settings.json'), 'utf8')) as Record<string, string>;
  test(`has a name for every setting, group and choice in ${language}`, () => {
    assert.ok(ids.length > 60);
    for (const id of ids) {
      assert.ok(texts[`setting.${id}`], `there is no setting.${id}`);
      assert.ok(texts[`group.${id.split('.')[0]}`]);
      if (language !== 'en') assert.ok(texts[`setting.${id}.hint`], `there is no setting.${id}.hint`);
    }
    for (const [, id, , values] of reference.matchAll(/^\| `([a-z]+\.[a-z_0-9]+)` \| (\S+) \| ([a-z_]+(?:, [a-z_]+)+) \|/gm))
      for (const choice of (values ?? '').split(', '))
        if (!['auto', 'true', 'false'].includes(choice)) assert.ok(texts[`choice.${id}.${choice}`], `there is no choice.${id}.${choice}`);
  });
}
