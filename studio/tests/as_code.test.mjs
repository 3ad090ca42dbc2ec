import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { test } from 'node:test';
import { load } from './modules.mjs';

const { asCode, pythonLiteral } = await load('scene/as_code.ts');
const server = 'http://127.0.0.1:8080';
const scene = (input, options = {}, parent = null) => ({ parent, request: { version: 1, input, seed: 7, options } });

/** What a shell passes to curl. */
function wordsOf(command) {
  const script = `curl() { for word in "$@"; do printf '%s\\0' "$word"; done; }\n${command}`;
  return execFileSync('bash', ['-c', script]).toString().split('\0').slice(0, -1);
}

test('a command passes the text through the shell unchanged', () => {
  const text = `a "red" mug, it's $HOME and \\ back`;
  const words = wordsOf(asCode(scene({ kind: 'text', text }), 'curl', server));
  assert.deepEqual(JSON.parse(words.at(-1)), { text, seed: 7 });
  assert.ok(words.includes(`${server}/scenes`));
});

test('an image is sent as a file beside its document', () => {
  const words = wordsOf(asCode(scene({ kind: 'image', media_type: 'image/jpeg' }, { max_objects: 5 }), 'curl', server));
  assert.ok(words.includes('image=@image.jpg'));
  assert.deepEqual(JSON.parse(words.at(-1).replace('request=', '').replace(';type=application/json', '')), {
    seed: 7,
    options: { max_objects: 5 },
  });
});

test('an edit is asked of its parent', () => {
  const operations = [{ op: 'remove', object: 'mug_1' }];
  const edit = scene({ kind: 'edit', text: 'remove the mug', operations }, {}, 'PARENT');
  assert.match(asCode(edit, 'curl', server), /\/scenes\/PARENT\/edits/);
  assert.deepEqual(JSON.parse(asCode(edit, 'json', server)), { operations, seed: 7 });
  assert.match(
    asCode(edit, 'python', server),
    /client\.scene\("PARENT"\)\.edit\(operations=\[\{"op": "remove", "object": "mug_1"\}\], seed=7\)\.wait\(\)/,
  );
});

test('a program reads as Python', () => {
  const code = asCode(scene({ kind: 'text', text: 'a "mug"' }, { set: { 'layout.gap_m': '0.02' }, max_objects: null }), 'python', server);
  assert.match(
    code,
    /client\.generate\("a \\"mug\\"", seed=7, options=\{"set": \{"layout.gap_m": "0.02"\}, "max_objects": None\}\)\.wait\(\)/,
  );
});

test('values become those of Python', () => {
  assert.equal(pythonLiteral({ a: [true, false, null, 1.5, 'x'] }), '{"a": [True, False, None, 1.5, "x"]}');
});
