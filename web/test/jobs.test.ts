import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';
import {test} from 'node:test';
import {
  bySeverity, choose, differences, figureAt, filterOf, isFiltered, listQuery, newerPage, olderPage, quarter, secondsLeft, settingsOf, standingOf,
  stagesOf, withFilter, type Warning} from '../src/state/jobs';

test('the address becomes a question to the server', () => {
  const asked = listQuery('state=failed&kind=print&owner=ann&text=+CASE-7+&from=2026-11-23&to=2026-11-23');
  assert.equal(asked.state, 'failed');
  assert.equal(asked.kind, 'print');
  assert.equal(asked.owner, 'ann');
  assert.equal(asked.text, 'CASE-7');
  const day = Date.parse(asked.created_before ?? '') - Date.parse(asked.created_after ?? '');
  assert.equal(day, 24 * 3600 * 1000);
  assert.equal(asked.created_after, new Date(2026, 10, 23).toISOString());
});

test('a day that does not exist as one is left out', () => {
  assert.equal(listQuery('from=yesterday').created_after, '');
  assert.equal(listQuery('').created_before, '');
});

test('pages go to older ones and back', () => {
  const second = olderPage('state=failed', 'a'), third = olderPage(second, 'b');
  assert.equal(listQuery(third).cursor, 'b');
  assert.equal(newerPage(third), second);
  assert.equal(newerPage(second), 'state=failed');
  assert.equal(newerPage('state=failed'), null);
});

test('another filter begins at the first page and keeps the others', () => {
  const query = withFilter('state=failed&cursor=a', 'text', ' x&y ');
  assert.equal(filterOf(query, 'text'), 'x&y');
  assert.equal(filterOf(query, 'state'), 'failed');
  assert.equal(listQuery(query).cursor, '');
  assert.equal(isFiltered(query), true);
  assert.equal(isFiltered(withFilter('text=x', 'text', '')), false);
  assert.equal(isFiltered('cursor=a'), false);
});

test('at most two jobs are chosen, the last ones', () => {
  assert.deepEqual(choose(['a', 'b'], 'c', true), ['b', 'c']);
  assert.deepEqual(choose(['a'], 'a', true), ['a']);
  assert.deepEqual(choose(['a', 'b'], 'a', false), ['b']);
});

test('the time left is unknown unless past jobs tell it', () => {
  assert.equal(secondsLeft({state: 'running', progress: 0.25, seconds_expected: 80}), 60);
  assert.equal(secondsLeft({state: 'running', progress: 0.25, seconds_expected: null}), null);
  assert.equal(secondsLeft({state: 'running', progress: 0.25}), null);
  assert.equal(secondsLeft({state: 'queued', progress: 0, seconds_expected: 80}), null);
});

test('progress is spoken by quarters', () => {
  assert.deepEqual([0, 0.2499, 0.25, 0.5, 0.99, 1].map(quarter), [0, 0, 1, 2, 3, 4]);
});

test('each kind of job has its stages', () => {
  assert.deepEqual(stagesOf('inspection'), ['scan', 'inspection']);
  assert.equal(stagesOf('print').length, 5);
  assert.deepEqual(stagesOf('layout'), ['scan', 'forming', 'flattening', 'printing']);
});

const schema = {properties: {
  print: {properties: {dpi: {type: 'integer', default: 300}, marks: {type: 'boolean', default: true}}},
  pattern: {properties: {offset_mm: {type: 'array', default: [0, 0]}}}}};

test('changed settings come first', () => {
  const all = settingsOf({print: {dpi: 300, marks: false}, pattern: {offset_mm: [0, 0]}}, schema);
  assert.deepEqual(all.map((one) => [one.id, one.changed]), [['print.marks', true], ['print.dpi', false], ['pattern.offset_mm', false]]);
});

test('two jobs differ in values, not in the order of members', () => {
  const a = {print: {dpi: 300, marks: true}, pattern: {offset_mm: [0, 5]}};
  assert.deepEqual(differences(a, {pattern: {offset_mm: [0, 5]}, print: {marks: true, dpi: 300}}), []);
  assert.deepEqual(differences(a, {print: {dpi: 150, marks: true}, pattern: {offset_mm: [0, 6]}}), ['print.dpi', 'pattern.offset_mm']);
  assert.deepEqual(differences({print: {dpi: 300}}, {}), ['print.dpi']);
});

test('serious warnings come first, the others keep their order', () => {
  const warning = (code: string, severity: Warning['severity']): Warning =>
    ({stage: 'scan', code, severity, what: '', place: '', figure: null, fix: '', marks: []});
  const sorted = bySeverity([warning('a', 'note'), warning('b', 'warning'), warning('c', 'serious'), warning('d', 'warning')]);
  assert.deepEqual(sorted.map((one) => one.code), ['c', 'b', 'd', 'a']);
});

test('a figure is read by its path', () => {
  const report = {figures: {with: {coils: {worst_k: 0.02}}}};
  assert.equal(figureAt(report, 'figures.with.coils.worst_k'), 0.02);
  assert.equal(figureAt(report, 'figures.without.coils.worst_k'), null);
  assert.equal(figureAt(null, 'figures'), null);
  assert.equal(figureAt(report, 'figures.with'), null);
});

const web = process.env['VACUFORM_WEB'] ?? '';
const texts = (language: string, file: string): Record<string, string> =>
  JSON.parse(readFileSync(join(web, 'lang', language, file), 'utf8')) as Record<string, string>;

test('every warning of the reference has a title in both languages, and a meaning and a fix in German', () => {
  const reference = readFileSync(join(web, '../docs/reference/warnings.md'), 'utf8');
  const codes = [...reference.matchAll(/^\| `([a-z-]+)` \|/gm)].map((match) => match[1] ?? '');
  assert.ok(codes.length > 30);
  const english = texts('en', 'warnings.json'), german = texts('de', 'warnings.json');
  for (const code of codes) {
    assert.ok(english[`warning.${code}`], code);
    for (const part of ['', '.what', '.fix']) assert.ok(german[`warning.${code}${part}`], `${code}${part}`);
  }
});

test('every problem type of the API has a title, a meaning and a fix in German', () => {
  const description = readFileSync(join(web, '../api/openapi.yaml'), 'utf8');
  const list = /^ {4}ProblemSlug:\n.*\n {6}enum:\n((?: {8}- .*\n)+)/m.exec(description)?.[1] ?? '';
  const types = [...list.matchAll(/- ([a-z-]+)/g)].map((match) => match[1] ?? '');
  assert.ok(types.length > 20);
  const ofPrograms = ['bad-usage', 'locked', 'lease-lost', 'wrong-digest'];  // a title is enough
  const wanted = types.flatMap((type) => ofPrograms.includes(type) ? [type] : [type, `${type}.what`, `${type}.fix`]);
  assert.deepEqual(Object.keys(texts('de', 'problems.json')).sort(), wanted.map((name) => `error.${name}`).sort());
});

test('every input of a job has a name', () => {
  const description = readFileSync(join(web, '../api/openapi.yaml'), 'utf8');
  const list = /input: \{enum: \[(.*)\]\}/.exec(description)?.[1]?.split(', ') ?? [];
  assert.ok(list.includes('icc'));
  for (const language of ['en', 'de'])
    assert.deepEqual(Object.keys(texts(language, 'job.json')).filter((key) => key.startsWith('job.input_')), list.map((name) => `job.input_${name}`));
});

test('a mold stands in the machine as it is, in the frame of its job', () => {
  const settings = {sheet: {width_mm: 300, height_mm: 320}, machine: {window: 'rectangle', window_width_mm: 280, window_height_mm: 290, drape_height_mm: 12}};
  const {placed, plug, frame} = standingOf({low: [-70, -95, 0], high: [80, 90, 130]}, settings);
  assert.deepEqual([placed.shift, placed.size, placed.height, placed.half], [[0, 0, 0], [150, 185, 130], 130, [80, 95]]);
  assert.equal(plug, 0, 'nothing is cut away');
  assert.deepEqual(frame, {sheet: [300, 320], window: [280, 290], round: false, height: 12});
  assert.deepEqual(standingOf({low: [0, 0, 0], high: [1, 1, 1]}, {machine: {window: 'circle', window_width_mm: 250}}).frame.window, [250, 250]);
});
