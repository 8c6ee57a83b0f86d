// Checks the messages: every language has the same keys with the same values, and every key is used.
import {readdirSync, readFileSync, statSync} from 'node:fs';
import {join} from 'node:path';

export function readMessages(folder) {
  const all = {};
  for (const name of readdirSync(folder).filter((file) => file.endsWith('.json')).sort())
    for (const [key, text] of Object.entries(JSON.parse(readFileSync(join(folder, name), 'utf8')))) {
      if (key in all) throw new Error(`${name}: the key is there twice: ${key}`);
      all[key] = text;
    }
  return all;
}

// An esbuild plugin: "messages:keys" is the list of all keys, "messages:en" that of the English texts in their order. So no
// key is in the bundle twice.
export function messages(lang) {
  const keys = () => [...new Set(readdirSync(lang).flatMap((language) => Object.keys(readMessages(join(lang, language)))))].sort();
  return {
    name: 'messages',
    setup(build) {
      build.onResolve({filter: /^messages:/}, ({path}) => ({path: path.slice('messages:'.length), namespace: 'messages'}));
      build.onLoad({filter: /./, namespace: 'messages'}, ({path}) => {
        const folder = join(lang, path), texts = path === 'keys' ? {} : readMessages(folder);
        const list = path === 'keys' ? keys() : keys().map((key) => texts[key] ?? 0);
        return {contents: `export default ${JSON.stringify(list)};`, watchDirs: path === 'keys' ? [] : [folder],
                watchFiles: path === 'keys' ? [] : readdirSync(folder).map((name) => join(folder, name))};
      });
    },
  };
}

const values = (text) => [...text.matchAll(/\{(\w+)/g)].map((match) => match[1]).sort().join(' ');

function sources(folder) {
  return readdirSync(folder).flatMap((name) => {
    const path = join(folder, name);
    return statSync(path).isDirectory() ? sources(path) : [readFileSync(path, 'utf8')];
  });
}

// Texts of what the server names: a setting, a warning, an error... They are looked up by its name.
const ofServer = /^(setting|group|choice|warning|error|stage|state|kind|artifact|scope|severity)\./;

// `strict`: unused messages are faults too.
export function checkMessages(lang, src, strict = true) {
  const languages = readdirSync(lang).filter((name) => statSync(join(lang, name)).isDirectory());
  const english = readMessages(join(lang, 'en'));
  const faults = [];
  for (const language of languages) {
    const messages = readMessages(join(lang, language));
    for (const key of Object.keys(english))
      if (!(key in messages)) faults.push(`${language}: there is no message ${key}`);
      else if (values(messages[key]) !== values(english[key])) faults.push(`${language}: other values in ${key}`);
    for (const key of Object.keys(messages))
      if (!(key in english) && !ofServer.test(key)) faults.push(`${language}: English has no message ${key}`);
  }
  const text = sources(src).join('\n');
  const prefixes = [...text.matchAll(/`([a-z_]+\.[a-z_.]*)\$\{/g)].map((match) => match[1]);  // t(`shell.theme_${...}`)
  for (const key of Object.keys(english))
    if (strict && !ofServer.test(key) && !text.includes(`'${key}'`) && !prefixes.some((prefix) => key.startsWith(prefix)))
      faults.push(`en: nothing uses the message ${key}`);
  if (faults.length > 0) throw new Error('messages:\n  ' + faults.join('\n  '));
}
