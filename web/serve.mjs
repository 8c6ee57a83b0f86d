// For developing: serves the application as it is built from the sources now, and passes the rest to a running service.
// node serve.mjs [--server http://127.0.0.1:8080] [--port 8181]
import {spawn} from 'node:child_process';
import {createReadStream, existsSync} from 'node:fs';
import {createServer, request} from 'node:http';
import {dirname, extname, join} from 'node:path';
import {fileURLToPath} from 'node:url';

const option = (name, fallback) =>
  process.argv.includes(name) ? process.argv[process.argv.indexOf(name) + 1] : fallback;
const server = new URL(option('--server', 'http://127.0.0.1:8080'));
const port = Number(option('--port', '8181'));
const here = dirname(fileURLToPath(import.meta.url));
const out = option('--out', join(here, 'dist-serve'));
spawn(process.execPath, [join(here, 'build.mjs'), '--out', out, '--watch'], {stdio: 'inherit'});

const types = {'.html': 'text/html; charset=utf-8', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml', '.png': 'image/png'};
// As the server sends it; see server/pages/html.cpp.
const policy = "default-src 'none'; script-src 'self'; worker-src 'self'; style-src 'self'; img-src 'self' blob: data:; " +
  "connect-src 'self'; font-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'; " +
  "require-trusted-types-for 'script'; trusted-types vacuform";

createServer((asked, answer) => {
  const path = new URL(asked.url, 'http://x').pathname;
  const file = path === '/' ? join(out, 'index.html') : path.startsWith('/app/') ? join(out, path.slice(5)) : '';
  if (file && existsSync(file)) {
    answer.writeHead(200, {'Content-Type': types[extname(file)] ?? 'application/octet-stream', 'Cache-Control': 'no-store',
                           'Content-Security-Policy': policy});
    createReadStream(file).pipe(answer);
    return;
  }
  const headers = {...asked.headers, host: server.host};
  if (headers.origin) headers.origin = server.origin;
  const passed = request({host: server.hostname, port: server.port, method: asked.method, path: asked.url, headers},
    (response) => { answer.writeHead(response.statusCode, response.headers); response.pipe(answer); });
  passed.on('error', () => { if (!answer.headersSent) answer.writeHead(502); answer.end(); });
  answer.on('close', () => passed.destroy());  // also when the browser has gone
  asked.pipe(passed);
}).listen(port, '127.0.0.1', () => console.log(`http://127.0.0.1:${port}`));
