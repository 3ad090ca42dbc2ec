// Pages of what is made from scenes: executions, recordings, batches and datasets, each used by keys alone.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { makeScene, once, post, start, tabTo, violations } from './browser.mjs';

const suite = `results-${process.pid}-${Date.now()}`;
const address = {};
let studio;

before(async () => {
  studio = await start();
  const { url } = studio;
  const scene = await makeScene(url, { text: 'A desk with a laptop, a mug and two books', seed: 7, labels: { suite } });
  const { proposed } = await (await fetch(`${url}/scenes/${scene.id}/tasks?robot=panda&count=1`)).json();
  const [{ task }] = proposed;
  const recording = await post(`${url}/scenes/${scene.id}/episodes`, { robot: 'panda', task, count: 1 }, 0);
  const execution = await post(`${url}/scenes/${scene.id}/executions`, { task, seed: 0 }, 0);
  const recipe = { templates: ['A desk with a {color} mug'], slots: { color: ['red', 'blue'] }, seeds: { first: 0, count: 1 } };
  const batch = await post(`${url}/batches?name=mugs`, recipe, 0);
  const dataset = await post(`${url}/datasets`, { name: 'desks', label: `suite:${suite}`, splits: { train: 1 } }, 0);
  address.recording = `/recordings/${recording.id}`;
  address.execution = `/executions/${execution.id}?scene=${scene.id}`;
  address.batch = `/batches/${batch.id}`;
  address.dataset = `/datasets/${dataset.id}`;
  await once(`${url}/jobs/${execution.id}`, ({ state }) => state === 'succeeded');
  await once(`${url}/batches/${batch.id}`, ({ state }) => state === 'finished');
  await once(`${url}/datasets/${dataset.id}`, ({ state }) => state === 'finished');
  await once(`${url}/episodes/${recording.id}`, ({ state }) => state === 'finished', 120);
});
after(() => studio?.stop());

/** What each page has when it is complete, and what is done on it by keys. */
const PAGES = {
  recording: {
    ready: '.player .plots svg',
    async byKeys(page) {
      await page.keyboard.press('ArrowRight');
      await page.waitForSelector('.clock >> text=/^1.00 of/');
      await page.keyboard.press('.');
      await page.waitForFunction(() => document.querySelector('.player video').currentTime > 1);
      await page.keyboard.press(' ');
      await page.waitForSelector('.clock button:has-text("Pause")');
      await page.waitForFunction(() => document.querySelector('.player video').currentTime > 1.3);
    },
  },
  execution: {
    ready: '[data-replay="ready"] canvas',
    async byKeys(page) {
      const drawn = () => page.locator('.replay canvas').screenshot();
      const still = await drawn();
      await page.keyboard.press('ArrowRight');
      await page.waitForSelector('.clock >> text=/^1.00 of/');
      assert.notDeepEqual(await drawn(), still, 'the robot moves');
      await page.keyboard.press('ArrowLeft');
      await page.waitForSelector('.clock >> text=/^0.00 of/');
    },
  },
  batch: {
    ready: '.table tbody tr >> nth=1',
    async byKeys(page) {
      await page.focus('#main');
      await tabTo(page, 'Gallery');
      await page.keyboard.press('Enter');
      await page.waitForSelector('.gallery .cards > li >> nth=1');
      assert.equal(await page.locator('.gallery .cards > li').count(), 2);
    },
  },
  dataset: {
    ready: '.histogram',
    async byKeys(page) {
      await page.focus('#main');
      await tabTo(page, 'Verify');
      await page.keyboard.press('Enter');
      await page.waitForSelector('text=/Verified: 1 scene/');
    },
  },
};

for (const [name, { ready, byKeys }] of Object.entries(PAGES)) {
  test(`the page of the ${name} breaks no rule of accessibility, and is used by keys alone`, async () => {
    for (const dark of [false, true]) {
      const { page, context, faults } = await studio.open(address[name], { dark });
      await page.waitForSelector(ready);
      await page.waitForFunction(() => !document.querySelector('.waiting'));
      assert.deepEqual(await violations(page), [], dark ? 'dark' : 'light');
      if (!dark) await byKeys(page);
      assert.deepEqual(faults, []);
      await context.close();
    }
  });

  test(`the page of the ${name} that is not there says so`, async () => {
    const { page, context } = await studio.open(address[name].replace(/[0-9a-f]{12}(?=\?|$)/, '000000000000'));
    await page.waitForSelector('.notice.bad');
    assert.deepEqual(await violations(page), []);
    assert.equal(await page.locator('text=Try again').count(), 0);
    await context.close();
  });
}
