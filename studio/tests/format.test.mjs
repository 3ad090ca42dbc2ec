import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './modules.mjs';

const format = await load('format.ts');

test('lengths have the unit in which they are read', () => {
  const cases = [
    [0, '0 mm'],
    [1.5e-7, '0.15 µm'],
    [-3e-9, '< 0.1 µm'],
    [0.00234, '2.3 mm'],
    [0.0457, '4.57 cm'],
    [-0.2, '−20 cm'],
    [1.5, '1.5 m'],
  ];
  for (const [meters, text] of cases) assert.equal(format.length(meters), text);
});

test('masses, bytes and durations change their unit at the right place', () => {
  assert.deepEqual([0.1284, 0.9996, 18.442].map(format.mass), ['128 g', '1 kg', '18.4 kg']);
  assert.deepEqual([999, 1000, 413580, 2714976].map(format.bytes), ['999 B', '1 KB', '414 KB', '2.71 MB']);
  assert.deepEqual([0, 999, 1234, 61000, 3_720_000].map(format.duration), ['0 ms', '999 ms', '1.2 s', '1 min 1 s', '1 h 2 min']);
});

test('numbers have no sign before zero and no zeros at the end', () => {
  assert.equal(format.fixed(-0.04, 1), '0.0');
  assert.equal(format.fixed(-1.25, 1), '−1.3');
  assert.deepEqual(
    [0.1, 1234.5, 1e-9].map((value) => format.significant(value)),
    ['0.1', '1235', '1e−9'],
  );
  assert.equal(format.percent(2 / 3), '66.7 %');
});

test('times since a moment are rounded down', () => {
  const now = Date.parse('2026-11-29T12:00:00Z');
  const before = (seconds) => format.ago(new Date(now - seconds * 1000).toISOString(), now);
  assert.deepEqual([1, 59, 119, 3599, 7300].map(before), ['now', '59 s ago', '1 min ago', '59 min ago', '2 h ago']);
});
