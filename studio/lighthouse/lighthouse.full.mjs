// Lighthouse on the pages that are used most.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { launch } from 'chrome-launcher';
import lighthouse from 'lighthouse';
import { FLAGS, makeScene, startServer } from '../tests/browser.mjs';

let server;
let scene;
let chrome;

before(async () => {
  server = await startServer({});
  scene = await makeScene(server.url, { text: 'A desk with a laptop, a mug and two books', seed: 7 });
  chrome = await launch({ chromePath: process.env.CHROMIUM ?? '/usr/bin/chromium', chromeFlags: ['--headless=new', ...FLAGS] });
});
after(async () => {
  chrome?.kill();
  await server?.stop();
});

for (const [name, path] of [
  ['first page', () => '/'],
  ['gallery', () => '/gallery'],
  ['scene', () => `/scenes/${scene.id}?light=plain`],
]) {
  test(`Lighthouse finds nothing against the accessibility of the ${name}`, async (t) => {
    const onlyCategories = ['accessibility', 'best-practices', 'performance'];
    const { lhr } = await lighthouse(`${server.url}/studio${path()}`, { port: chrome.port, onlyCategories, logLevel: 'error' });
    assert.equal(lhr.runtimeError, undefined);
    const score = (category) => lhr.categories[category].score;
    // How fast a page is depends on the machine; it is told, and not judged.
    t.diagnostic(onlyCategories.map((category) => `${category} ${score(category)}`).join(', '));
    const failed = (category) =>
      lhr.categories[category].auditRefs.map(({ id }) => lhr.audits[id]).filter((audit) => audit.score !== null && audit.score < 1);
    assert.deepEqual(failed('accessibility').map(({ id }) => id), []);
    assert.equal(score('accessibility'), 1);
    assert.ok(score('best-practices') >= 0.95, failed('best-practices').map(({ id, explanation }) => `${id} ${explanation ?? ''}`).join());
  });
}
