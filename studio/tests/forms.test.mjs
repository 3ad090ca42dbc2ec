import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './modules.mjs';

const { recipeOf, sizeOf, yieldOf } = await load('batch_parts.ts');
const { filterOf, searchOf } = await load('gallery/filters.ts');
const { controlOf, optionsSchema, resolved } = await load('api/settings.ts');
const { examples } = await load('scene/scene_files.ts');
const { documentOf, imageFault } = await load('submit_scene.ts');

test('a recipe has a template per line, its slots and its seeds', () => {
  const recipe = recipeOf('a {color} mug\n\n a {color} {item} \n', 'color: red, blue\nitem: fork', 3, 10);
  assert.deepEqual(recipe, {
    templates: ['a {color} mug', 'a {color} {item}'],
    slots: { color: ['red', 'blue'], item: ['fork'] },
    seeds: { first: 3, count: 10 },
  });
  assert.equal(sizeOf(recipe), 40);
  assert.throws(() => recipeOf('a mug', 'red, blue', 0, 1), /no slot/);
});

test('the yield is of requests that ended', () => {
  const counts = { total: 10, pending: 5, running: 1, succeeded: 3, quarantined: 1, failed: 0, cancelled: 0, duplicate: 0, invalid: 0 };
  assert.equal(yieldOf(counts), 0.75);
  assert.equal(yieldOf({ ...counts, succeeded: 0, quarantined: 0 }), undefined);
});

test('filters of the address are those of the list, and nothing else', () => {
  const filter = filterOf(new URLSearchParams('verdict=pass&q=red+mug&tab=x&sort=newest&min_objects='));
  assert.deepEqual(filter, { verdict: 'pass', q: 'red mug', sort: 'newest' });
  assert.deepEqual(searchOf(filter), { verdict: 'pass', q: 'red mug' });
});

test('the form of options follows references and leaves out what may be null', () => {
  const root = optionsSchema({
    $defs: {
      Options: {
        properties: {
          max_objects: { type: ['integer', 'null'] },
          on_unknown: { anyOf: [{ $ref: '#/$defs/OnUnknown' }, { type: 'null' }], description: 'How.' },
          table: { anyOf: [{ $ref: '#/$defs/Table' }, { type: 'null' }] },
        },
      },
      OnUnknown: { type: 'string', enum: ['fail', 'drop'], description: 'Of its own.' },
      Table: { type: 'object', properties: {} },
    },
  });
  const field = (name) => resolved(root.properties[name], root);
  assert.equal(controlOf(field('max_objects')), 'integer');
  assert.deepEqual(
    [controlOf(field('on_unknown')), field('on_unknown').enum, field('on_unknown').description],
    ['choice', ['fail', 'drop'], 'How.'],
  );
  assert.equal(controlOf(field('table')), 'none');
});

test('the first code of each section of the read-me is its example', () => {
  const readme =
    '# Scene\n\n## MuJoCo\n\nText.\n\n```python\nimport mujoco\n```\n\n```python\nmore\n```\n\n## Gazebo\n\n```sh\ngz sim\n```\n\n## Words\n\nNone.\n';
  assert.deepEqual(examples(readme), [
    { title: 'MuJoCo', language: 'python', code: 'import mujoco' },
    { title: 'Gazebo', language: 'sh', code: 'gz sim' },
  ]);
});

test('a draft without text, seed and options is an empty document', () => {
  assert.deepEqual(documentOf({ text: '  ', options: {} }), {});
  assert.deepEqual(documentOf({ text: 'a mug', seed: 0, options: { max_objects: 3 } }), {
    text: 'a mug',
    seed: 0,
    options: { max_objects: 3 },
  });
});

test('files that the server would refuse are refused before they are sent', () => {
  const limits = { max_image_bytes: 10 };
  const file = (type, size) => ({ name: 'x', type, size });
  assert.equal(imageFault(file('image/png', 10), limits), undefined);
  assert.match(imageFault(file('image/png', 11), limits), /at most 10 B/);
  assert.match(imageFault(file('image/gif', 1), limits), /PNG, JPEG or WebP/);
});
