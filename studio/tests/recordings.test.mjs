import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './modules.mjs';

const { formatsOf } = await load('recording/episode_files.ts');
const { jerk, ofUnit, stillShare } = await load('recording/episode_tables.ts');
const { outliers, partsOfRecording, titleOfRecording } = await load('recording_parts.ts');
const { pathOf, rangeOf } = await load('ui/plot.tsx');

test('files are put in order by format, episode and camera', () => {
  const paths = [
    'lerobot-v3.0/meta/info.json',
    'lerobot-v3.0/data/chunk-000/file-000.parquet',
    'lerobot-v3.0/meta/tasks.parquet',
    'lerobot-v3.0/strips/chunk-000/episode_000001.mp4',
    'lerobot-v3.0/strips/chunk-000/episode_000000_my_front.png',
    'lerobot-v3.0/strips/chunk-000/episode_000000.mp4',
    'robomimic/dataset.hdf5',
  ];
  const formats = formatsOf(paths.map((path) => ({ path, url: `/${path}` })));
  assert.deepEqual(
    formats.map((format) => format.format),
    ['lerobot-v3.0'],
  );
  const [format] = formats;
  assert.deepEqual(
    format.episodes.map((episode) => [episode.index, episode.strips.map((strip) => strip.camera), episode.video?.path.slice(-10)]),
    [
      [0, ['my_front'], '000000.mp4'],
      [1, [], '000001.mp4'],
    ],
  );
  assert.equal(format.info.path, paths[0]);
  assert.deepEqual(
    format.tables.map((table) => table.path),
    [paths[1]],
  );
});

test('episodes of an unusual length are found, and usual differences are none', () => {
  assert.deepEqual([...outliers([100, 104, 98, 101, 250, 99, 30])], [4, 6]);
  assert.deepEqual([...outliers([100, 110, 95])], []);
  assert.deepEqual([...outliers([])], []);
});

test('the jerk of a parabola is zero, and that of a cubic constant', () => {
  const series = (f) => [{ name: 'joint1_rad', values: Float64Array.from({ length: 20 }, (_, frame) => f(frame / 10)) }];
  assert.ok(jerk(series((t) => 3 * t * t - t), 10) < 1e-9);
  assert.ok(Math.abs(jerk(series((t) => 2 * t ** 3), 10) - 12) < 1e-6);
});

test('stillness is the share of frames in which no joint moves', () => {
  const series = [
    { name: 'a_rad', values: [0, 0, 0, 1, 1] },
    { name: 'b_rad', values: [0, 0, 1, 1, 1] },
  ];
  assert.equal(stillShare(series), 0.5);
  assert.deepEqual(
    ofUnit([...series, { name: 'x_m', values: [] }, { name: 'a_rad_per_s', values: [] }], '_rad').map((one) => one.name),
    ['a_rad', 'b_rad'],
  );
});

test('a recording is named by its title, its instruction or its task', () => {
  const name = (order) => titleOfRecording({ id: '01a227e8-7510-717d-9678-51df648542a8', order });
  assert.equal(name({ title: 'Mugs', task: 'x' }), 'Mugs');
  assert.equal(name({ tasks: ['put it there', { instruction: 'lift it' }] }), 'put it there and 1 more');
  assert.equal(name({ task: { instruction: 'lift it' } }), 'lift it');
  assert.equal(name({}), 'Recording 648542a8');
});

test('attempts that succeeded come first', () => {
  const parts = partsOfRecording({ attempts: { no_path: 2, success: 3, dropped: 1 } });
  assert.deepEqual(
    parts.map((part) => `${part.number} ${part.name}`),
    ['3 succeeded', '1 dropped', '2 no path'],
  );
});

test('a line goes from edge to edge, and long ones are thinned', () => {
  const values = [0, 5, 10];
  assert.deepEqual(rangeOf([{ name: 'a', values }]), [0, 10]);
  assert.equal(pathOf(values, 0, 10), 'M0.0 180.0L400.0 90.0L800.0 0.0');
  assert.ok(pathOf(new Float32Array(10_000), 0, 0).split('L').length <= 501);
  assert.deepEqual(rangeOf([]), [0, 1]);
});
