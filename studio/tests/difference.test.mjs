import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './modules.mjs';

const { differences, metricChanges } = await load('scene/difference.ts');

const mug = {
  name: 'mug_1',
  label: 'mug',
  translation_m: [0.1, 0.2, 0],
  yaw_rad: 3.0,
  mass_kg: 0.3,
  size_m: [0.1, 0.08, 0.09],
  friction: { static: 0.5, dynamic: 0.4 },
};
const metrics = { col_o: 0, col_s: 0, ss: 1, dss_aligned: 0.5, dss_shipped: 1 };
const scene = (...instances) => ({ instances, metrics });

test('a moved object has its displacement, and its rotation the short way around', () => {
  const [row] = differences(scene(mug), scene({ ...mug, translation_m: [0.15, 0.2, 0.01], yaw_rad: -3.0 }));
  assert.equal(row.what, 'moved');
  assert.ok(Math.abs(row.dx - 0.05) < 1e-12 && Math.abs(row.dz - 0.01) < 1e-12);
  assert.ok(Math.abs(row.dyaw - (2 * Math.PI - 6)) < 1e-12);
});

test('objects that came, went, changed and stayed are told apart, those that differ first', () => {
  const bowl = { ...mug, name: 'bowl_1', label: 'bowl' };
  const fork = { ...mug, name: 'fork_1', label: 'fork' };
  const rows = differences(scene(mug, bowl, fork), scene(mug, { ...fork, mass_kg: 0.6 }, { ...bowl, name: 'plate_1' }));
  assert.deepEqual(
    rows.map((row) => [row.what, row.name]),
    [
      ['added', 'plate_1'],
      ['removed', 'bowl_1'],
      ['changed', 'fork_1'],
      ['same', 'mug_1'],
    ],
  );
  assert.equal(rows[2].massRatio, 2);
});

test('noise of the settling is no movement, and an undefined rotation no rotation', () => {
  const [row] = differences(scene(mug), scene({ ...mug, translation_m: [0.10001, 0.2, 0], yaw_rad: null }));
  assert.equal(row.what, 'same');
  assert.equal(row.dyaw, null);
});

test('only metrics that differ are listed', () => {
  assert.deepEqual(metricChanges(metrics, { ...metrics, dss_aligned: 1 }), [{ name: 'dss_aligned', before: 0.5, after: 1 }]);
});
