import assert from 'node:assert/strict';
import test from 'node:test';
import type {SettingsSchema} from '../src/api/types';
import {
  accepting, attemptFor, withDefaultProfile, changed, doubtsOf, emptyDraft, emptyForm, hasIcc, hasPattern, redone, restored, saved, scanSettings, separated, staleJob, statusOf,
  submission, undone, withProfile, withoutReference, withSetting, withSettings, type DraftState, type Origin, type Pattern, type SentFile} from '../src/state/draft';

const schema: SettingsSchema = {properties: {
  scan: {properties: {units: {type: 'string', enum: ['auto', 'mm'], default: 'auto'}, left_side: {type: 'string', default: 'unknown'}}},
  sheet: {properties: {width_mm: {type: 'number', default: 300}, height_mm: {type: 'number', default: 300}}},
  layout: {properties: {count: {type: 'number', default: 16}}},
  print: {properties: {dpi: {type: 'integer', default: 300}}}}};
const scan: SentFile = {upload: 'u1', whole: true, name: 'Meier.stl', bytes: 10, mark: '10-ab'};
const pattern: Pattern = {...scan, upload: 'u2', name: 'rings.svg', mark: '9-cd', kind: 'svg', width: 10, height: 5, aspect: 2, layout: ''};
const from: Origin = {
  job: 'j1', kind: 'print', settings: {print: {dpi: 600}},
  scan: {bytes: 1, sha256: 'aa', extension: 'stl'}, pattern: {bytes: 1, sha256: 'bb', extension: 'svg'}, icc: null};
const draft = (change: Partial<DraftState> = {}): DraftState => ({...emptyDraft('tab'), ...change});
const fields = (of: DraftState, kind: 'print' | 'inspection' | 'layout' = 'print'): Record<string, string> =>
  Object.fromEntries(submission(of, kind, schema));

test('a new print begins with the default profile, one from another job does not', () => {
  const profiles = [{name: 'small', changed: '', default: false, settings: {}},
                    {name: 'wide', changed: '', default: true, settings: {sheet: {width_mm: 450}, print: {dpi: 300}}}];
  const fresh = draft({schema, profiles});
  assert.deepEqual(withDefaultProfile(fresh).form, {...emptyForm, profile: 'wide', settings: {sheet: {width_mm: 450}}});
  assert.deepEqual(withDefaultProfile({...fresh, profiles: [profiles[0]!]}), {});
  assert.deepEqual(withDefaultProfile({...fresh, form: {...emptyForm, reference: 'C-1'}}), {}, 'what a person has typed stays');
  assert.deepEqual(withDefaultProfile({...fresh, from}), {});
});

test('a print of the colours of the scan needs no drawing and sends none', () => {
  const now = draft({schema, scan, form: {...emptyForm, pattern, settings: {pattern: {source: 'scan'}}}});
  assert.equal(hasPattern({...now, form: {...now.form, pattern: null}}), true);
  assert.equal(hasPattern(draft({scan})), false);
  assert.equal(fields(now)['pattern_upload'], undefined);
  assert.equal(fields({...now, form: {...now.form, settings: {}}})['pattern_upload'], 'u2');
});

test('an ICC profile goes with a print as soon as it has arrived, and with no other job', () => {
  const icc = {upload: 'u3', whole: false, name: 'printer.icc', bytes: 344, mark: 'i'};
  const now = draft({schema, scan, form: {...emptyForm, pattern, icc}});
  assert.equal(hasIcc(now), false);
  assert.equal(statusOf(now, 'machine'), 'working');
  assert.equal(fields(now)['icc_upload'], undefined);
  const there = {...now, form: {...now.form, icc: {...icc, whole: true}}};
  assert.equal(hasIcc(there), true);
  assert.equal(fields(there)['icc_upload'], 'u3');
  assert.equal(fields(there, 'inspection')['icc_upload'], undefined);
});

test('undo and redo go over the whole form', () => {
  let now = draft();
  now = {...now, ...changed(now, {reference: 'CASE-1'})};
  now = {...now, ...changed(now, {settings: {print: {dpi: 600}}})};
  assert.deepEqual(changed(now, {reference: 'CASE-1'}), {});
  now = {...now, ...undone(now)};
  assert.deepEqual([now.form.reference, now.form.settings], ['CASE-1', {}]);
  now = {...now, ...undone(now)};
  assert.equal(now.form.reference, '');
  assert.deepEqual(undone(now), {});
  now = {...now, ...redone(now)};
  now = {...now, ...redone(now)};
  assert.deepEqual([now.form.reference, now.form.settings, now.future.length], ['CASE-1', {print: {dpi: 600}}, 0]);
  now = {...now, ...undone(now)};
  now = {...now, ...changed(now, {note: 'new'})};
  assert.equal(now.future.length, 0);
});

test('settings hold only what differs from the defaults', () => {
  assert.deepEqual(withSettings({}, {print: {dpi: 300}, sheet: {width_mm: 450}}, schema), {sheet: {width_mm: 450}});
  assert.deepEqual(withSetting({sheet: {width_mm: 450}}, 'sheet.width_mm', undefined), {});
  assert.deepEqual(withSettings({}, {scan: {other: 1}}, schema), {}, 'a setting that this service lacks is left out');
});

test('another profile takes back what the former one set', () => {
  const small = {sheet: {width_mm: 210}}, wide = {sheet: {height_mm: 450}};
  const first = withProfile({print: {dpi: 600}}, {}, small, schema);
  assert.deepEqual(first, {print: {dpi: 600}, sheet: {width_mm: 210}});
  assert.deepEqual(withProfile(first, small, wide, schema), {print: {dpi: 600}, sheet: {height_mm: 450}});
});

test('a new print names its uploads and no file name', () => {
  const now = draft({scan, form: {...draft().form, pattern, reference: 'CASE-1', note: 'thin', settings: {layout: {count: 9}, print: {dpi: 600}}}});
  assert.deepEqual(fields(now), {
    kind: 'print', settings: '{"print":{"dpi":600}}', scan_upload: 'u1', pattern_upload: 'u2', reference: 'CASE-1', note: 'thin'});
  assert.ok(!JSON.stringify(fields(now)).includes('Meier'));
  assert.deepEqual(fields(now, 'layout')['settings'], '{"layout":{"count":9},"print":{"dpi":600}}');
  assert.equal(fields(now, 'inspection')['pattern_upload'], undefined);
});

test('a print from a job sends every setting, so that one can go back to its default', () => {
  const now = draft({from, form: {...draft().form, settings: {}}});
  assert.equal(fields(now)['from'], 'j1');
  assert.equal(fields(now)['scan_upload'], undefined);
  assert.deepEqual(JSON.parse(fields(now)['settings'] ?? ''), {
    scan: {units: 'auto', left_side: 'unknown'}, sheet: {width_mm: 300, height_mm: 300}, print: {dpi: 300}});
});

test('the key stays until something else is started', () => {
  let count = 0;
  const newKey = (): string => `key-${++count}`;
  const first = attemptFor(draft(), [['kind', 'print']], newKey);
  const again = attemptFor(draft({attempt: first}), [['kind', 'print']], newKey);
  const other = attemptFor(draft({attempt: first}), [['kind', 'layout']], newKey);
  assert.deepEqual([first.key, again.key, other.key], ['key-1', 'key-1', 'key-2']);
});

test('a reload restores the draft, and nothing of what was on its way', () => {
  const now = draft({scan: {...scan, whole: false}, form: {...draft().form, pattern, settings: {print: {dpi: 600}}}, accepted: ['side x'],
    attempt: {key: 'k', content: 'c'}, faults: {'print.dpi': 'x'}, past: [draft().form]});
  const kept = restored(saved(now), 'other');
  assert.deepEqual([kept.tab, kept.form, kept.scan, kept.attempt, kept.accepted], [now.tab, now.form, now.scan, now.attempt, now.accepted]);
  assert.deepEqual([kept.faults, kept.past], [{}, []]);
  for (const text of [null, '', '{', '{"format":0}', '[]']) assert.equal(restored(text, 'new').tab, 'new');
});

test('a second tab has its own draft without unfinished uploads and without the key', () => {
  const now = draft({scan: {...scan, whole: false}, attempt: {key: 'k', content: 'c'}, form: {...draft().form, pattern, note: 'n'}});
  const copy = separated(now, 'two');
  assert.deepEqual([copy.tab, copy.scan, copy.attempt, copy.form], ['two', null, null, now.form]);
});

test('sections say what is missing', () => {
  const form = {...draft().form, pattern};
  const statuses = (of: DraftState): string => (['scan', 'pattern', 'machine', 'check'] as const).map((one) => statusOf(of, one)).join(' ');
  assert.equal(statuses(draft()), 'open open defaults open');
  assert.equal(statuses(draft({scan: {...scan, whole: false}})), 'working open defaults open');
  assert.equal(statuses(draft({scan, form: {...form, profile: 'a'}})), 'done done done open');
  assert.equal(statuses(draft({scan, form, plan: {kind: 'print', settings: {}, inputs: {}}})), 'done done defaults ready');
  assert.equal(statuses(draft({scan, form, faults: {'sheet.width_mm': 'no number'}})), 'done done problem open');
  assert.equal(statuses(draft({scan, form, problem: {type: 'bad-settings', title: '', status: 422, where: 'pattern.scale'}})), 'done problem defaults problem');
  assert.equal(statuses(draft({from})), 'done done done open');
});

const good = {plausible: true, mirrored: false, upGuessed: false, wide: false};
test('a doubt is raised once for each scan', () => {
  const now = draft({schema, scan, facts: {...good, plausible: false, mirrored: true}});
  assert.deepEqual(doubtsOf(now), ['mirror', 'size', 'side']);
  const accepted = accepting(now, ['mirror', 'size', 'side']);
  assert.deepEqual(doubtsOf({...now, accepted}), []);
  assert.deepEqual(doubtsOf({...now, accepted, scan: {...scan, mark: 'another'}}), ['mirror', 'size', 'side']);
  const confirmed = draft({schema, scan, form: {...draft().form, settings: {scan: {left_side: 'minus_x'}}}});
  assert.deepEqual(doubtsOf(confirmed), []);
  assert.deepEqual(doubtsOf({...confirmed, found: {codes: ['inside-out'], fits: true}}), ['mirror']);
});

test('no section is done and nothing is ready while a point is open', () => {
  const statuses = (of: DraftState): string => (['scan', 'pattern', 'check'] as const).map((one) => statusOf(of, one)).join(' ');
  const settings = {scan: {left_side: 'minus_x'}}, machine: SettingsSchema = {properties: {...schema.properties,
    machine: {properties: {window: {type: 'string', default: 'rectangle'}, window_width_mm: {type: 'number', default: 280}, window_height_mm: {type: 'number', default: 200}}}}};
  const whole = draft({schema: machine, scan, facts: good, plan: {kind: 'print', reference: '', note: '', settings: {}, inputs: {}}, form: {...draft().form, pattern, settings}});
  assert.equal(statuses(whole), 'done done ready');
  const open = {...whole, form: {...whole.form, settings: {}}};
  assert.equal(statuses(open), 'look done look');
  assert.equal(statuses({...whole, facts: {...good, plausible: false}}), 'look done look');
  assert.equal(statuses({...whole, facts: {...good, wide: true}}), 'look done look');
  assert.deepEqual(doubtsOf({...open, facts: {...good, upGuessed: true}}), ['up', 'side']);
  assert.equal(statuses({...whole, facts: {...good, upGuessed: true}}), 'done done ready', 'the side was confirmed on an upright head');
  assert.deepEqual(doubtsOf({...whole, found: {codes: [], fits: false}}), ['fit']);
  const guessed = {...whole, found: {codes: ['up-guessed'], fits: true}};
  assert.deepEqual(doubtsOf(guessed), ['up']);
  assert.deepEqual(doubtsOf({...guessed, form: {...whole.form, settings: {scan: {left_side: 'minus_x', up: '+z'}}}}), [], 'a person has set the axis');
  // rings larger than the window, turned or not; scaled down they fit
  const of = (width: number, height: number, scale = 1): DraftState =>
    ({...whole, form: {...whole.form, pattern: {...pattern, width, height}, settings: {...settings, pattern: {scale}}}});
  assert.equal(statuses(of(270, 199)), 'done done ready');
  assert.equal(statuses(of(199, 270)), 'done done ready');
  assert.equal(statuses(of(281, 100)), 'done look look');
  assert.equal(statuses(of(201, 201)), 'done look look');
  assert.equal(statuses(of(400, 300, 0.5)), 'done done ready');
  const laid = {...whole, form: {...whole.form, pattern: {...pattern, offHead: 4}}};
  assert.deepEqual(doubtsOf(laid), ['coils']);
  assert.equal(statuses({...laid, accepted: accepting(laid, ['coils'])}), 'done done ready');
  assert.equal(statuses({...laid, accepted: accepting(laid, ['coils']), form: {...laid.form, pattern: {...pattern, mark: 'other', offHead: 1}}}), 'done look look');
});

test('another scan takes the reference and the note along, also from what undo brings back', () => {
  let now = draft({scan});
  now = {...now, ...changed(now, {reference: 'CASE-2000', rescan: true})};
  now = {...now, ...changed(now, {note: 'left ear sore'})};
  now = {...now, ...changed(now, {settings: {print: {dpi: 600}}})};
  now = {...now, ...withoutReference(now)};
  assert.deepEqual([now.form.reference, now.form.rescan, now.form.note, now.dropped], ['', false, '', 'CASE-2000']);
  assert.deepEqual(now.form.settings, {print: {dpi: 600}});
  for (let back = now; back.past.length > 0;) {
    back = {...back, ...undone(back)};
    assert.deepEqual([back.form.reference, back.form.rescan, back.form.note], ['', false, '']);
  }
  assert.deepEqual(withoutReference(draft({dropped: 'CASE-1'})).dropped, 'CASE-1');
  assert.ok(restored(saved(now), 'x').dropped === 'CASE-2000');
});

test('that a scan is another one of the same patient is confirmed for one reference', () => {
  let now = draft({scan, form: {...draft().form, pattern}});
  now = {...now, ...changed(now, {reference: 'CASE-2000'})};
  assert.equal(fields(now)['rescan'], undefined);
  now = {...now, ...changed(now, {rescan: true})};
  assert.equal(fields(now)['rescan'], 'true');
  assert.equal(fields(now, 'inspection')['reference'], undefined);
  now = {...now, ...changed(now, {note: 'x'})};
  assert.equal(fields(now)['rescan'], 'true');
  now = {...now, ...changed(now, {reference: 'CASE-2001'})};
  assert.equal(fields(now)['rescan'], undefined);
});

test('a result is out of date when the draft from it differs', () => {
  const form = {...draft().form, settings: {print: {dpi: 600}}};
  assert.equal(staleJob(draft()), null);
  assert.equal(staleJob(draft({from, form})), null);
  assert.equal(staleJob(draft({from, form: {...form, settings: {}}})), 'j1');
  assert.equal(staleJob(draft({from, form: {...form, pattern}})), 'j1');
});

test('findings belong to the placement of the scan, not to its sides or the print', () => {
  const at = (settings: DraftState['form']['settings']): string => scanSettings(draft({scan, form: {...draft().form, settings}}));
  assert.equal(at({scan: {up: '+z', units: 'mm'}}), at({scan: {units: 'mm', left_side: 'minus_x', up: '+z'}, print: {dpi: 600}}));
  assert.notEqual(at({}), at({scan: {up: '-z'}}));
  assert.notEqual(at({}), at({machine: {window_width_mm: 100}}));
});
