// The gallery with 500 scenes.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { makeScene, once, post, start, tabTo } from './browser.mjs';

const SCENES = 500;
/** Scenes with images; the others wait in a queue that is paused. */
const FINISHED = 48;
const PAGE_SIZE = 48;
const OBJECTS = ['mug', 'laptop', 'bowl', 'teapot', 'book'];
let studio;

before(async () => {
  studio = await start({ own: true });
  for (let seed = 0; seed < FINISHED; seed += 2) {
    await Promise.all([seed, seed + 1].map((one) => makeScene(studio.url, { text: 'A desk with a mug', seed: one })));
  }
  studio.command('queue', 'pause');
  for (let made = FINISHED; made < SCENES; made++) {
    const body = { text: `A desk with a ${OBJECTS[made % OBJECTS.length]}`, seed: made, labels: { half: made % 2 ? 'odd' : 'even' } };
    const scene = await post(`${studio.url}/scenes`, body, 0);
    assert.equal(scene.state, 'pending', JSON.stringify(scene));
  }
});
after(() => studio?.stop());

const cards = (page) => page.locator('.gallery .cards > li');

test('the first view of 500 scenes is quick and small, with and without images', async (t) => {
  for (const [path, images] of [
    ['/gallery', 0],
    ['/gallery?verdict=pass', 12],
  ]) {
    const { page, context, faults } = await studio.open('/nowhere');
    await page.waitForSelector('h1');
    const client = await context.newCDPSession(page);
    await client.send('Network.enable');
    await client.send('Network.setCacheDisabled', { cacheDisabled: true });
    let bytes = 0;
    let requests = 0;
    client.on('Network.requestWillBeSent', () => requests++);
    client.on('Network.loadingFinished', ({ encodedDataLength }) => (bytes += encodedDataLength));
    await page.goto(`${studio.url}/studio${path}`, { waitUntil: 'commit' });
    await page.waitForSelector(`.gallery .cards > li >> nth=${PAGE_SIZE - 1}`);
    const first_ms = await page.evaluate(() => Math.round(performance.now()));
    await page.waitForFunction((wanted) => [...document.images].filter((image) => image.closest('.cards') && image.naturalWidth > 0).length >= wanted, images);
    await page.waitForTimeout(500);
    t.diagnostic(`${path}: ${PAGE_SIZE} cards after ${first_ms} ms; ${requests} requests with ${bytes} bytes`);
    assert.equal(await cards(page).count(), PAGE_SIZE);
    assert.ok(first_ms < 10_000, `the cards came after ${first_ms} ms`);
    assert.ok(requests <= 20 + PAGE_SIZE && bytes < 2_000_000, `${requests} requests with ${bytes} bytes`);
    assert.deepEqual(faults, []);
    await context.close();
  }
});

test('all pages of the list come by keys, each scene once', async (t) => {
  const { page, context } = await studio.open('/gallery');
  await page.waitForSelector('.gallery .cards > li');
  assert.match(await page.textContent('.gallery header'), /500 scenes/);
  const begun = Date.now();
  await page.focus('.gallery .cards > li:last-child a');
  for (let shown = PAGE_SIZE; shown < SCENES; shown += PAGE_SIZE) {
    await tabTo(page, 'Show more');
    await page.keyboard.press('Enter');
    await page.waitForSelector(`.gallery .cards > li >> nth=${Math.min(SCENES, shown + PAGE_SIZE) - 1}`);
    await page.focus('.gallery .cards > li:last-child a');
  }
  t.diagnostic(`all ${SCENES} scenes after ${Date.now() - begun} ms`);
  const addresses = await page.locator('.gallery .cards > li > a').evaluateAll((links) => links.map((link) => link.href));
  assert.equal(new Set(addresses).size, SCENES);
  assert.equal(await page.locator('text=Show more').count(), 0);
  await context.close();
});

test('filters narrow the list, and their counts fit it', async () => {
  const { page, context } = await studio.open('/gallery');
  await page.waitForSelector('.facet li button');
  const facet = page.locator('.facet li button:has-text("half=odd")');
  const number = Number(await facet.locator('.number').textContent());
  assert.equal(number, (SCENES - FINISHED) / 2);
  await facet.focus();
  await page.keyboard.press('Enter');
  await page.waitForSelector(`.gallery header:has-text("${number} scenes")`);
  await page.fill('[type=search]', 'teapot');
  await page.keyboard.press('Enter');
  await page.waitForURL(/q=teapot/);
  await page.waitForFunction(() => {
    const titles = [...document.querySelectorAll('.gallery .scene-title')];
    return titles.length > 0 && titles.every((title) => title.textContent.includes('teapot'));
  });
  const { total } = await (await fetch(`${studio.url}/scenes/facets?label=half:odd&q=teapot`)).json();
  await page.waitForSelector(`.gallery header:has-text("${total} scenes")`);
  await context.close();
});

test('fifty scenes are reviewed by keys, and all decisions are kept', async (t) => {
  const { page, context, faults } = await studio.open('/gallery?label=half:even');
  await page.waitForSelector(`.gallery .cards > li >> nth=${PAGE_SIZE - 1}`);
  await tabTo(page, 'Show more');
  await page.keyboard.press('Enter');
  await page.waitForSelector(`.gallery .cards > li >> nth=${2 * PAGE_SIZE - 1}`);
  // Most of them are on the second page.
  await page.focus('.gallery .cards > li:nth-child(41) a');
  const begun = Date.now();
  for (let index = 0; index < 50; index++) await page.keyboard.press(index % 5 ? 'a' : 'r');
  t.diagnostic(`50 decisions after ${Date.now() - begun} ms`);
  const kept = (decision, number) => once(`${studio.url}/scenes/facets?label=review:${decision}`, ({ total }) => total === number);
  await kept('accept', 40);
  await kept('reject', 10);
  assert.equal(await page.locator('.gallery .cards .badge:has-text("rejected")').count(), 10);
  // A new scene moves the others on: none is lost, decisions stay, and keys act on the scene that has the focus.
  const current = await page.getAttribute('.gallery .cards [aria-current=true]', 'href');
  await post(`${studio.url}/scenes`, { text: 'A desk with a bowl', seed: 1, labels: { half: 'even' } }, 0);
  await page.waitForSelector(`.gallery .cards > li >> nth=${2 * PAGE_SIZE}`);
  assert.equal(await cards(page).count(), 2 * PAGE_SIZE + 1);
  assert.equal(await page.locator('.gallery .cards .badge:has-text("rejected")').count(), 10);
  await page.keyboard.press('r');
  await once(`${studio.url}/scenes/${current.split('/').at(-1)}`, ({ labels }) => labels.review === 'reject');
  assert.equal(await page.locator('.notice.bad, .toast.bad').count(), 0);
  assert.deepEqual(faults, []);
  await context.close();
});
