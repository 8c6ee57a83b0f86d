// Imports of the web application go one way: read and api -> state -> parts, scene -> views. Packages are in one layer each.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';
import {before, test} from 'node:test';
import {esbuild, web} from './drive.mjs';

// A layer imports from itself and from those that it names.
const base = ['dom', 'store', 'text', 'route', 'lang'];
const layers = {
  dom: [], store: [], lang: [],
  text: ['lang'],
  route: [],
  read: [],
  api: [],
  state: ['api', 'read', 'store', 'route'],
  view: ['dom', 'state', 'store'],
  parts: ['api', 'read', 'state', 'view', ...base],
  scene: ['read', 'parts', 'state', ...base],
  views: ['api', 'read', 'state', 'view', 'parts', 'scene', ...base],
  main: ['api', 'state', 'parts', 'views', ...base],
};

const layerOf = (path) => {
  const found = /^(?:src\/)?(lang|[^/.]+)/.exec(path)?.[1];
  assert.ok(found && found in layers, `${path} is in no layer; name it in this test`);
  return found;
};

let imports;  // [importer, imported] of every import in the sources
before(async () => {
  const {metafile} = await esbuild.build({
    absWorkingDir: web, entryPoints: ['src/main.ts', 'src/read/worker.ts'], bundle: true, splitting: true, format: 'esm', write: false,
    outdir: 'none', metafile: true, target: 'es2022',
    external: ['messages:*'], logLevel: 'silent'});  // build.mjs makes these from lang/
  imports = Object.entries(metafile.inputs).filter(([path]) => path.startsWith('src/') || path.startsWith('lang/')).flatMap(
    ([path, {imports: found}]) => found.map((one) => [path, one.path]));
  assert.ok(imports.length > 50);
});

const ours = (path) => path.startsWith('src/') || path.startsWith('lang/');

test('every import leads to a lower layer', () => {
  const wrong = imports.filter(([from, to]) => {
    if (!ours(to)) return false;
    const [above, below] = [layerOf(from), layerOf(to)];
    return above !== below && !layers[above].includes(below);
  });
  assert.deepEqual(wrong.map((pair) => pair.join(' imports ')), []);
});

test('scene alone imports three, api alone tus-js-client, and nothing else comes from outside', () => {
  const outside = imports.filter(([, to]) => to.includes('node_modules/'));
  const found = outside.map(([from, to]) => `${layerOf(from)}: ${/node_modules\/([^/]+)/.exec(to)[1]}`);
  assert.deepEqual([...new Set(found)].sort(), ['api: tus-js-client', 'scene: three']);
});

test('no file imports itself through others', () => {
  const next = Map.groupBy ? Map.groupBy(imports, ([from]) => from) : new Map(imports.map(([from]) =>
    [from, imports.filter(([other]) => other === from)]));
  const done = new Set();
  const visit = (path, above) => {
    assert.ok(!above.includes(path), [...above.slice(above.indexOf(path)), path].join(' -> '));
    if (done.has(path)) return;
    for (const [, to] of next.get(path) ?? []) if (ours(to)) visit(to, [...above, path]);
    done.add(path);
  };
  for (const path of next.keys()) visit(path, []);
});

const sources = (layer) => [...new Set(imports.flat())].filter((path) => path.startsWith('src/') && layerOf(path) === layer)
  .map((path) => [path, readFileSync(join(web, path), 'utf8').replace(/\/\/.*$/gm, '')]);

test('only api talks to the server', () => {
  for (const layer of ['read', 'state', 'parts', 'scene', 'views'])
    for (const [path, text] of sources(layer)) assert.doesNotMatch(text, /\bfetch\(|XMLHttpRequest|EventSource\(|sendBeacon/, path);
});

test('readers and the client work without a document', () => {
  for (const layer of ['read', 'api'])
    for (const [path, text] of sources(layer)) assert.doesNotMatch(text, /\bdocument\.|\bHTML\w*Element|customElements/, path);
});

test('no text is parsed as HTML', () => {
  for (const layer of Object.keys(layers))
    for (const [path, text] of sources(layer))
      assert.doesNotMatch(text, /(inner|outer)HTML\s*\+?=[^=]|insertAdjacentHTML|document\.write|\beval\(|new Function/, path);
});
