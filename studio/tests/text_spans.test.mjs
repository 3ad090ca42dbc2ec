import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './modules.mjs';

const { partsOf } = await load('text_spans.ts');

/** An account with spans of the words, in bytes as the server counts them. */
function account(text, understood, unrecognized) {
  const span = (word) => {
    const start = Buffer.byteLength(text.slice(0, text.indexOf(word)));
    return { span: { start, end: start + Buffer.byteLength(word), text: word } };
  };
  return { understood: understood.map(span), unrecognized: unrecognized.map(span), stand_ins: [], fillings: [], goal: null };
}

test('the text is divided at its spans and nothing of it is lost', () => {
  const text = 'a red mug and a zorgle';
  const parts = partsOf(text, account(text, ['red mug'], ['zorgle']));
  assert.deepEqual(
    parts.map((part) => [part.kind, part.text]),
    [
      ['plain', 'a '],
      ['understood', 'red mug'],
      ['plain', ' and a '],
      ['unrecognized', 'zorgle'],
    ],
  );
});

test('bytes of letters beyond ASCII are counted as the server counts them', () => {
  const text = 'ein Käse 🧀, a zörgle';
  const parts = partsOf(text, account(text, [], ['zörgle']));
  assert.deepEqual(parts.at(-1), { kind: 'unrecognized', text: 'zörgle' });
  assert.equal(parts.map((part) => part.text).join(''), text);
});

test('spans of another text mark nothing', () => {
  const old = account('a zorgle and a mug', [], ['zorgle']);
  assert.deepEqual(partsOf('an apple and a mug', old), [{ kind: 'plain', text: 'an apple and a mug' }]);
});

test('spans that overlap are marked once', () => {
  const text = 'a tea pot';
  const parts = partsOf(text, account(text, ['tea pot', 'pot'], []));
  assert.equal(parts.map((part) => part.text).join(''), text);
});
