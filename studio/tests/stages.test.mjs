import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './modules.mjs';

const { STAGES, stageRows } = await load('scene/stages.ts');
const { timelineOf } = await load('scene/timeline.ts');

const at = (ms) => new Date(Date.parse('2026-11-29T12:00:00Z') + ms).toISOString();
const stage = (name, start, ms, more = {}) => ({
  stage: name,
  state: 'finished',
  cached: false,
  runs: 1,
  elapsed_ms: ms,
  started_at: at(start),
  ...more,
});

test('parts of a stage are one row, and stages to come are shown while the job goes on', () => {
  const stages = [
    stage('reference', 0, 300),
    stage('complete', 300, 5, { instance: 'mug_1' }),
    stage('complete', 300, 7, { instance: 'bowl_1', state: 'running', elapsed_ms: null }),
  ];
  const rows = stageRows(stages, [], false);
  assert.deepEqual(
    rows.slice(0, 4).map((row) => [row.stage, row.state]),
    [
      ['reference', 'finished'],
      ['recognize', 'waiting'],
      ['segment', 'waiting'],
      ['complete', 'running'],
    ],
  );
  assert.deepEqual([rows[3].finished, rows[3].parts, rows[3].computed_ms], [1, 2, 5]);
  assert.ok(!rows.some((row) => row.stage === 'grasp'));
  assert.deepEqual(
    stageRows(stages, [], true).map((row) => [row.stage, row.state]),
    [
      ['reference', 'finished'],
      ['complete', 'failed'],
    ],
  );
});

test('a stage shows its telling image', () => {
  const image = (name) => ({ name, stage: 'segment', media_type: 'image/png', url: `/${name}` });
  const [row] = stageRows(
    [stage('segment', 0, 1)],
    [image('segment/a.png'), image('segment/masks.png'), image('segment/z.png')],
    true,
  );
  assert.equal(row.image.name, 'segment/masks.png');
});

test('rows of the timeline are in the order of the pipeline', () => {
  const { rows } = timelineOf([stage('bundle', 900, 100), stage('reference', 0, 300), stage('segment', 300, 10)]);
  assert.deepEqual(
    rows.map((row) => row.stage),
    ['reference', 'segment', 'bundle'],
  );
  assert.ok(STAGES.indexOf('reference') < STAGES.indexOf('bundle'));
});

test('a long idle time is folded, and what follows moves up', () => {
  const { rows, gaps, shown_ms } = timelineOf([stage('reference', 0, 300), stage('recognize', 60_300, 700)]);
  assert.deepEqual(gaps, [{ at: 0.3, ms: 60_000 }]);
  assert.equal(shown_ms, 1000);
  assert.deepEqual(rows[1].spans[0].from, 0.3);
  assert.ok(Math.abs(rows[1].spans[0].width - 0.7) < 1e-12);
});

test('a result that was found takes no time', () => {
  const { rows, shown_ms } = timelineOf([stage('reference', 0, 300, { cached: true }), stage('certify', 10, 100)]);
  assert.equal(shown_ms, 110);
  assert.equal(rows[0].computed_ms, 0);
});

test('a job without stages has an empty timeline', () => {
  assert.deepEqual(timelineOf([]), { rows: [], shown_ms: 0, gaps: [] });
});
