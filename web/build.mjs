// Bundles the web application: node build.mjs [--out DIR] [--watch] [--quiet]
//
// DIR receives index.html and files whose names carry a hash of their content, each also compressed (.gz). Fails if a
// message is missing in a language.
import {build, context} from 'esbuild';
import {mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {gzipSync} from 'node:zlib';
import {checkMessages, messages} from './messages.mjs';

const here = dirname(fileURLToPath(import.meta.url));
const option = (name) => process.argv.includes(name) ? process.argv[process.argv.indexOf(name) + 1] : undefined;
const out = option('--out') ?? join(here, 'dist');

const options = {
  absWorkingDir: here,
  entryPoints: {app: 'src/main.ts', style: 'style/main.css', 'read-worker': 'src/read/worker.ts'},
  bundle: true,
  splitting: true,
  minify: true,
  format: 'esm',
  target: ['chrome109', 'firefox115'],
  supported: {'top-level-await': true},
  outdir: out,
  entryNames: '[name]-[hash]',
  chunkNames: '[name]-[hash]',
  assetNames: '[name]-[hash]',
  loader: {'.svg': 'file', '.png': 'file'},
  publicPath: '/app',
  plugins: [messages(join(here, 'lang'))],
  metafile: true,
  legalComments: 'none',
  logLevel: 'warning',
};

// The names of the built entry points, and the page that refers to them.
function writePage(metafile) {
  const named = (entry) => {
    const [file] = Object.entries(metafile.outputs).find(([, output]) => output.entryPoint === entry);
    return file.split('/').pop();
  };
  const page = readFileSync(join(here, 'index.html'), 'utf8')
    .replace('{{style}}', `/app/${named('style/main.css')}`)
    .replace('{{app}}', `/app/${named('src/main.ts')}`)
    .replace('{{read-worker}}', `/app/${named('src/read/worker.ts')}`);
  writeFileSync(join(out, 'index.html'), page);
}

function compress() {
  for (const name of readdirSync(out).sort()) {
    const content = readFileSync(join(out, name));
    const bytes = gzipSync(content, {level: 9});
    bytes[9] = 255;  // the operating system in the header of gzip: unknown, so that the bytes are the same everywhere
    writeFileSync(join(out, name + '.gz'), bytes);
    if (!quiet) console.log(String(bytes.length).padStart(8), name);
  }
}

const quiet = process.argv.includes('--quiet');
const watching = process.argv.includes('--watch');
checkMessages(join(here, 'lang'), join(here, 'src'), !watching);
rmSync(out, {recursive: true, force: true});
mkdirSync(out, {recursive: true});
if (watching) {
  const building = await context({...options, minify: false, sourcemap: 'inline', plugins: [...options.plugins, {
    name: 'page', setup: (b) => b.onEnd((result) => { if (result.metafile) writePage(result.metafile); })}]});
  await building.watch();
} else {
  writePage((await build(options)).metafile);
  compress();
}
