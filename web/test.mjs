// Bundles the unit tests, test/**/*.test.ts, and runs them: node test.mjs [part of a name...]
import {build} from 'esbuild';
import {messages} from './messages.mjs';
import {spawnSync} from 'node:child_process';
import {mkdtempSync, readdirSync, rmSync, statSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {dirname, join, relative} from 'node:path';
import {fileURLToPath} from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const wanted = process.argv.slice(2);

function tests(folder) {
  return readdirSync(folder).sort().flatMap((name) => {
    const path = join(folder, name);
    return statSync(path).isDirectory() ? tests(path) : path.endsWith('.test.ts') ? [path] : [];
  });
}
const entryPoints = tests(join(here, 'test'))
  .filter((path) => wanted.length === 0 || wanted.some((part) => relative(here, path).includes(part)));
if (entryPoints.length === 0) throw new Error(`no test has a name with ${wanted.join(' or ')}`);
const outdir = mkdtempSync(join(tmpdir(), 'vacuform-web-test-'));
try {
  const {metafile} = await build({
    entryPoints, outdir, outbase: join(here, 'test'), absWorkingDir: here, bundle: true, platform: 'node', format: 'esm',
    alias: {'tus-js-client': 'tus-js-client/lib.esm/browser/index.js'},  // what a browser gets of it
    target: 'node18', sourcemap: 'inline', outExtension: {'.js': '.mjs'}, metafile: true, logLevel: 'warning', plugins: [messages(join(here, 'lang'))],
    // where files of the repository are found; a bundle lies elsewhere
    define: {'process.env.VACUFORM_WEB': JSON.stringify(here)}});
  const files = Object.keys(metafile.outputs).map((path) => join(here, path));
  process.exitCode = spawnSync(process.execPath, ['--enable-source-maps', '--test', ...files], {stdio: 'inherit'}).status ?? 1;
} finally {
  rmSync(outdir, {recursive: true, force: true});
}
