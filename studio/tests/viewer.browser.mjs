// Clicks in the drawing of a scene.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { makeScene, start } from './browser.mjs';

let studio;
let scene;

before(async () => {
  studio = await start();
  scene = await makeScene(studio.url, { text: 'A desk with a laptop, a mug and two books', seed: 7 });
});
after(() => studio?.stop());

test('a click selects the object under it, also below its hulls', async () => {
  const { page, faults } = await studio.open(`/scenes/${scene.id}?light=plain`);
  await page.waitForSelector('.tools');
  for (const hulls of [false, true]) {
    for (const name of ['mug_1', 'book_1', 'laptop_1']) {
      const node = page.locator(`.tree button.node:has-text("${name}")`);
      await node.click();
      // The label stands above the middle of the object's top.
      const label = page.locator('.floating.object');
      await label.waitFor();
      const [x, y] = await label.evaluate((element) => [parseFloat(element.style.left), parseFloat(element.style.top)]);
      await node.click();
      await label.waitFor({ state: 'detached' });
      await page.locator('.canvas').click({ position: { x, y: y + 3 } });
      await page.waitForSelector('.tree .node[aria-expanded="true"]');
      assert.match(await page.textContent('.tree .node[aria-expanded="true"]'), new RegExp(name), `with${hulls ? '' : 'out'} hulls`);
      await page.click('.tree .node[aria-expanded="true"]');
    }
    await page.click('.tools >> text=Hulls');
    await page.waitForTimeout(800);
  }
  assert.deepEqual(faults, []);
  await page.context().close();
});

test('two clicks measure the distance between two points', async () => {
  const { page } = await studio.open(`/scenes/${scene.id}?light=plain`);
  await page.waitForSelector('.tools');
  await page.click('.tools >> text=From above');
  await page.click('.tools >> text=Measure');
  const box = await page.locator('.canvas').boundingBox();
  // Side by side on the desk, or on a book that lies there.
  for (const share of [0.35, 0.65]) await page.locator('.canvas').click({ position: { x: box.width * share, y: box.height * 0.62 } });
  const text = await page.locator('.floating.measure').textContent();
  const [, distance, x, y, z] = /([\d.]+) cm {2}\(x (−?[\d.]+), y (−?[\d.]+), z (−?[\d.]+)\)/.exec(text).map((part) => Number(part.replace('−', '-')));
  assert.ok(distance > 5 && distance < 200, text);
  assert.ok(Math.abs(distance - Math.hypot(x, y, z)) < 0.2 && Math.abs(x) > 0.9 * distance && Math.abs(z) < 6, text);
  await page.context().close();
});
