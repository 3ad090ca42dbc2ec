import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './modules.mjs';

const { MaskIndex } = await load('scene/masks.ts');
const { farthest, posesAt } = await load('scene/track.ts');

test('run lengths go down the columns, and runs may pass from one column to the next', () => {
  // Three columns of four pixels: the last two of the first column, the first of the second; the whole third column.
  const masks = new MaskIndex([{ id: 'mug_1', visible: { size: [4, 3], counts: [2, 3, 3, 4] } }]);
  assert.deepEqual([masks.width, masks.height], [3, 4]);
  assert.deepEqual(masks.runs('mug_1'), [
    [0, 2, 2],
    [1, 0, 1],
    [2, 0, 4],
  ]);
  const found = [0.1, 0.9].flatMap((x) => [0.1, 0.6, 0.99].map((y) => masks.at(x, y)));
  assert.deepEqual(found, [undefined, 'mug_1', 'mug_1', 'mug_1', 'mug_1', 'mug_1']);
  assert.deepEqual(masks.runs('bowl_1'), []);
  assert.equal(new MaskIndex([]).at(0.5, 0.5), undefined);
});

test('poses between two frames are between theirs, and a body that stays has its last pose', () => {
  const half = Math.SQRT1_2;
  const track = {
    mug_1: [
      [0, 0, 0.1, 0, 0, 0, 1],
      [0, 0, 0, 0, 0, half, half],
    ],
    table: [[0, 0, 0, 0, 0, 0, 1]],
  };
  const names = ['mug_1', 'table'];
  const near = (found, wanted) => found.forEach((value, index) => assert.ok(Math.abs(value - wanted[index]) < 1e-6, `${[...found]}`));
  near(posesAt(track, names, 30, 0), [0, 0, 0.1, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
  const [c, s] = [Math.cos(Math.PI / 8), Math.sin(Math.PI / 8)];
  near(posesAt(track, names, 30, 1 / 60), [0, 0, 0.05, c, 0, 0, s, 0, 0, 0, 1, 0, 0, 0]);
  near(posesAt(track, names, 30, 9), [0, 0, 0, half, 0, 0, half, 0, 0, 0, 1, 0, 0, 0]);
  assert.ok(Math.abs(farthest(track) - 0.1) < 1e-12);
  assert.equal(farthest({}), 0);
});
