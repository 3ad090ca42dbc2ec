// Writes `dist/licenses.txt`: the licenses of the packages that the page consists of.
import { existsSync, readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

const root = new URL('.', import.meta.url).pathname;
const lock = JSON.parse(readFileSync(join(root, 'package-lock.json'), 'utf8'));

/** The text of a package's license; packages under Apache-2.0 without a file have that of this repository. */
function textOf(folder, license) {
  const name = readdirSync(folder).find((file) => /^licen[sc]e/i.test(file));
  if (name) return readFileSync(join(folder, name), 'utf8').trim();
  if (license === 'Apache-2.0') return readFileSync(join(root, '../LICENSE'), 'utf8').trim();
  throw new Error(`${folder} has no license file, and its license is ${license}`);
}

const parts = Object.entries(lock.packages)
  .filter(([path, entry]) => path && !entry.dev && !entry.devOptional && !entry.optional && existsSync(join(root, path)))
  .map(([path, { version, license }]) => {
    const name = path.replace(/^.*node_modules\//, '');
    return `${name} ${version} (${license})\n\n${textOf(join(root, path), license)}\n`;
  });
writeFileSync(join(root, 'dist/licenses.txt'), parts.join(`\n${'-'.repeat(80)}\n\n`));
