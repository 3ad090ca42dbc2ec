import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './modules.mjs';

const { accused, checksOf, parityShare } = await load('scene/certificate.ts');

const still = { distance_m: 1e-7, angle_rad: 1e-6 };
const moved = { by_resolve: still, by_settling: still, from_aligned: still, after_shipping: still, after_aligning: still };
const object = (name, more) => ({
  name,
  support_margin_m: 0.03,
  moved,
  rest_limit_m: 0.02,
  overlap_m: 1e-6,
  outline_margin_m: 0.1,
  inside_outline: true,
  silhouette_iou: 0.9,
  color_difference: 10,
  method: 'category',
  ...more,
});
const body = (name, more) => ({
  name,
  watertight: true,
  triangles: 100,
  size_m: [0.1, 0.1, 0.1],
  density_kg_m3: 1000,
  hulls: 2,
  hull_excess_m: 0.003,
  uncovered_m: 0.001,
  hull_fit: { air_share: 0.05, open_share: 0.9 },
  ...more,
});
const deviation = { mass_relative: 1e-8, vertex_m: 0, static_friction: null, bodies: 2 };
const report = (more) => ({
  verdict: 'pass',
  summary: '',
  reasons: [],
  metrics: { col_o: 0, col_s: 0, ss: 1, dss_aligned: 1, dss_shipped: 1 },
  pairs: 3,
  fidelity: {
    silhouette_iou: 0.9,
    color_difference: 10,
    missed: { share: 0.01 },
    invented: { share: 0.02 },
    appearance: { similarity: 0.9 },
  },
  thresholds: {
    penetration_m: 0.001,
    wall_share: 0.25,
    support_dilation_m: 0.002,
    dss_displacement_m: 0.03,
    dss_rotation_rad: 0.5236,
    dss_duration_s: 5,
    rest_side_share: 0.25,
    rest_rotation_rad: 0.0349,
    outline_m: 0.001,
    silhouette_iou: 0.3,
    missed_share: 0.25,
    invented_share: 0.25,
    hull_excess_m: 0.03,
    uncovered_m: 0.01,
    uncovered_share: 0.015,
    open_share: 0.5,
    longest_side_m: [0.003, 5],
    density_kg_m3: [10, 23000],
    friction: 2,
  },
  objects: [object('mug_1'), object('bowl_1')],
  bodies: [body('table', { size_m: [1, 1, 0.7] }), body('mug_1'), body('bowl_1')],
  collisions: [],
  resolve: { rounds: 1, log: [] },
  parity: {
    tolerances: { mass_relative: 1e-6, vertex_m: 1e-6 },
    usd: deviation,
    urdf: deviation,
    mjcf: deviation,
    sdf: deviation,
    glb: { vertex_m: 5e-7 },
  },
  ...more,
});
const friction = { static: 0.5, dynamic: 0.4 };
const scene = {
  table: { name: 'table', friction },
  instances: [
    { name: 'mug_1', friction },
    { name: 'bowl_1', friction: { static: 0.8, dynamic: 0.7 } },
  ],
};
const find = (checks, title) => checks.find((check) => check.title.startsWith(title));

test('a scene that passes passes every check', () => {
  const checks = checksOf(report(), scene);
  assert.equal(checks.length, 14);
  assert.ok(checks.every((check) => check.passes));
  assert.equal(find(checks, 'Friction').worst, 'bowl_1');
});

test('a collision fails its check alone, with the deepest pair over the threshold', () => {
  const collisions = [
    { a: 'mug_1', b: 'bowl_1', depth_m: 0.002 },
    { a: 'bowl_1', b: 'table', depth_m: 0.004 },
  ];
  const failed = report({ collisions, reasons: [{ code: 'collision', bodies: ['mug_1', 'bowl_1'], sentence: 'They collide.' }] });
  const checks = checksOf(failed, scene);
  assert.deepEqual(
    checks.filter((check) => check.passes === false).map((check) => check.title),
    ['No bodies collide'],
  );
  const check = find(checks, 'No bodies');
  assert.equal(check.worst, 'bowl_1');
  assert.equal(check.share, 4);
  assert.match(check.measured, /2 of 3 pairs, deepest 4 mm/);
  assert.deepEqual([...accused(failed)], ['mug_1', 'bowl_1']);
});

test('the largest of a limit in meters and one by size applies to hulls', () => {
  const bodies = [body('table', { size_m: [1, 1, 0.7], uncovered_m: 0.012 }), body('mug_1', { uncovered_m: 0.009 })];
  const check = find(checksOf(report({ bodies }), scene), 'Hulls cover');
  // The table may lack 15 mm, the mug 10 mm: the mug is nearer to its limit.
  assert.equal(check.worst, 'mug_1');
  assert.ok(Math.abs(check.share - 0.9) < 1e-9);
});

test('an image that the program drew is reported and not judged', () => {
  const base = report();
  const checks = checksOf({ ...base, fidelity: { ...base.fidelity, is_judged: false } }, scene);
  assert.deepEqual(checks.filter((check) => check.passes === null).length, 3);
});

test('an image that the scene does not show fails by its own limit', () => {
  const base = report();
  const checks = checksOf({ ...base, fidelity: { ...base.fidelity, is_judged: true, missed: { share: 0.4 } } }, scene);
  assert.deepEqual(
    checks.filter((check) => check.passes === false).map((check) => check.title),
    ['The scene shows what the image shows'],
  );
});

test('the parity is that of the format which differs most for its tolerance', () => {
  assert.deepEqual(parityShare(report().parity), { share: 0.5, what: 'GLB, vertex' });
});

test('a scene without objects has a certificate, too', () => {
  const checks = checksOf(report({ objects: [], bodies: [body('table')] }), { ...scene, instances: [] });
  assert.ok(checks.every((check) => !/NaN|undefined|Infinity/.test(`${check.measured} ${check.asked}`)));
});
