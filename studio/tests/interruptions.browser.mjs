// What a page shows when its server dies, when its scene is deleted, and when files are missing.
import assert from 'node:assert/strict';
import { rmSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { makeScene, once, post, start, tabTo, violations } from './browser.mjs';

let studio;

before(async () => {
  studio = await start({ own: true });
});
after(() => studio?.stop());

const live = (page) => page.waitForSelector('.stream.live', { state: 'attached' });
const interrupted = (page) => page.waitForSelector('.stream.interrupted', { state: 'attached' });

/** Marks the document of a page; the mark is gone once the page is loaded again. */
const mark = (page) => page.evaluate(() => (window.isMarked = true));
const isMarked = (page) => page.evaluate(() => window.isMarked === true);

/** Kills the server, and starts it again after `run`. */
async function whileDown(run) {
  await studio.kill();
  try {
    await run();
  } finally {
    await studio.restart();
  }
}

test('a scene that was running when the server was killed ends on the page', async () => {
  const { page, context } = await studio.open('/');
  await live(page);
  await mark(page);
  await page.fill('#text', 'Breakfast for two: plates with forks on the left and knives on the right, three apples and two mugs');
  await page.fill('.seed', '11');
  await page.keyboard.press('Control+Enter');
  await page.waitForSelector('.progress .strip img');
  await whileDown(async () => {
    await interrupted(page);
    assert.equal(await page.locator('.progress >> text=Open the scene').count(), 0);
    assert.deepEqual(await violations(page), []);
  });
  await live(page);
  await page.waitForSelector('.progress >> text=Open the scene', { timeout: 60_000 });
  assert.ok(await isMarked(page), 'the page was loaded again');
  assert.equal(await page.locator('.notice.bad').count(), 0);
  await context.close();
});

test('what happened during an interruption is on all tabs after it', async () => {
  studio.command('queue', 'pause');
  const queued = await post(`${studio.url}/scenes`, { text: 'A desk with a mug', seed: 21 }, 0);
  const { page: leader, context } = await studio.open('/');
  const { page: follower } = await studio.open(`/scenes/${queued.id}`, { context });
  for (const page of [leader, follower]) {
    await live(page);
    await page.waitForSelector('.badge:has-text("Waiting")');
    await mark(page);
  }
  // No event has come yet from which a stream could go on, and none comes before all is over.
  await context.route('**/events*', (route) => route.abort());
  await whileDown(async () => {
    for (const page of [leader, follower]) await interrupted(page);
    studio.command('queue', 'resume');
  });
  await once(`${studio.url}/scenes/${queued.id}`, (scene) => scene.state === 'ready');
  await context.unroute('**/events*');
  await follower.waitForSelector('.tree');
  await leader.waitForSelector('.recent .badge:has-text("Pass")');
  assert.equal(await leader.locator('.badge:has-text("Waiting")').count(), 0);
  for (const page of [leader, follower]) assert.ok(await isMarked(page), 'a page was loaded again');
  await context.close();
});

test('a list that could not be read while the server was away is read when it is back', async () => {
  const { page, context } = await studio.open('/gallery');
  await live(page);
  await page.waitForSelector('.gallery .cards > li');
  await whileDown(async () => {
    await page.fill('[type=search]', 'desk');
    await page.keyboard.press('Enter');
    await page.waitForSelector('.notice.bad:has-text("The server does not answer")');
  });
  await live(page);
  await page.waitForSelector('.notice.bad', { state: 'detached' });
  await page.waitForSelector('.gallery .cards > li');
  await context.close();
});

test('a scene that is deleted in one tab is shown as deleted in another', async () => {
  const scene = await makeScene(studio.url, { text: 'A desk with a mug', seed: 21 });
  const { page, context, faults } = await studio.open(`/scenes/${scene.id}?light=plain`);
  const { page: other } = await studio.open(`/scenes/${scene.id}?light=plain`, { context });
  for (const tab of [page, other]) await tab.waitForSelector('.tools');
  page.once('dialog', (dialog) => dialog.accept());
  await page.click('.scene-head >> text=Delete');
  await page.waitForURL(/\/gallery/);
  await other.bringToFront();
  // The tab still has what it loaded; the next request finds that the scene is gone.
  await other.keyboard.press('a');
  await other.waitForSelector('text=This scene was deleted');
  await other.reload();
  await other.waitForSelector('.notice:has-text("This scene was deleted")');
  assert.equal(await other.locator('text=Try again').count(), 0);
  assert.deepEqual(await violations(other), []);
  assert.deepEqual(faults, []);
  await context.close();
});

test('a quarantined scene has its image, its model and its reasons', async () => {
  // One hull fills the hollow of a mug.
  const scene = await post(`${studio.url}/scenes`, { text: 'A desk with a mug', seed: 22, options: { set: { 'decompose.max_hulls': '1' } } });
  assert.equal(scene.verdict, 'quarantine', JSON.stringify(scene.failure ?? scene));
  const { page, context, faults } = await studio.open('/gallery?verdict=quarantine');
  await page.waitForSelector('.gallery .cards .badge.warn');
  await page.waitForFunction(() => document.querySelector('.cards .thumbnail img')?.naturalWidth > 0);
  await page.click('.gallery .cards a');
  await page.waitForSelector('.tools');
  await page.waitForSelector('.notice.warn, .notice.bad, .reasons');
  await page.click('text=Certificate');
  await page.waitForSelector('.check-row .badge.bad, .check-row .badge.warn');
  assert.deepEqual(await violations(page), []);
  // Certify it again.
  await page.keyboard.press('ArrowRight');
  await page.waitForSelector('#tab-stages[aria-selected=true]');
  await page.selectOption('.timeline select', 'certify');
  await page.focus('.timeline select');
  await tabTo(page, 'Run again');
  await page.keyboard.press('Enter');
  const again = await once(`${studio.url}/scenes/${scene.id}`, ({ job, state }) => job.id !== scene.job.id && state === 'failed');
  const stage = ({ stages }, name) => stages.find((one) => one.stage === name);
  assert.equal(stage(again, 'reference').cached, true);
  assert.equal(stage(again, 'certify').cached, false);
  await page.waitForSelector('.tools');
  assert.deepEqual(faults, []);
  await context.close();
});

test('a scene whose files are gone from the disk says so, and its card has no broken image', async () => {
  const scene = await makeScene(studio.url, { text: 'A desk with a mug', seed: 23, labels: { files: 'gone' } });
  await whileDown(() => rmSync(join(studio.data, 'blobs'), { recursive: true }));
  const { page, context } = await studio.open('/gallery?label=files:gone');
  await page.waitForSelector('.thumbnail.none:has-text("no image")');
  assert.deepEqual(await violations(page), []);
  await page.click('.gallery .cards a');
  await page.waitForSelector('.scene-head .badge');
  await page.waitForSelector('.notice.bad');
  assert.equal(await page.textContent('h1'), 'A desk with a mug');
  assert.deepEqual(await violations(page), []);
  await context.close();
});
