// The pages in a browser, against the server.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { makeScene, once, post, start, violations } from './browser.mjs';

/** Label of the scenes of this run; a server that runs already may have others. */
const suite = `pages-${process.pid}-${Date.now()}`;
let studio;
let scene;
let edited;

before(async () => {
  studio = await start();
  scene = await makeScene(studio.url, { text: 'A desk with a laptop, a mug and two books', seed: 7, labels: { suite } });
  edited = await post(`${studio.url}/scenes/${scene.id}/edits`, { text: 'remove the mug', seed: 1 });
  assert.equal(edited.state, 'ready');
});
after(() => studio?.stop());

/** Share of the canvas that differs from its corner, by an image of the page. */
async function drawnShare(page) {
  const png = await page.locator('.viewer .stage').screenshot();
  return page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes]));
    const canvas = Object.assign(document.createElement('canvas'), { width: bitmap.width, height: bitmap.height });
    const context = canvas.getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    let drawn = 0;
    for (let at = 0; at < data.length; at += 4) if (Math.abs(data[at] - data[at + 2]) > 12) drawn++;
    return drawn / (data.length / 4);
  }, png.toString('base64'));
}

test('a sentence is checked while it is written, and becomes a scene that can be opened', async () => {
  const { page, faults } = await studio.open('/');
  await page.fill('#text', 'A desk with a mug and a zorgle');
  await page.waitForSelector('.marks mark');
  assert.equal(await page.textContent('.marks mark'), 'zorgle');
  assert.match(await page.textContent('.account'), /zorgle has no effect: the catalog has no such object/);
  await page.fill('.seed', '3');
  await page.keyboard.press('Control+Enter');
  await page.waitForSelector('.progress .strip img');
  await page.click('.progress >> text=Open the scene');
  await page.waitForSelector('.tree');
  assert.match(await page.textContent('h1'), /zorgle/);
  assert.match(await page.textContent('.scene-head'), /seed 3/);
  assert.deepEqual(faults, []);
  await page.context().close();
});

test('a field at fault is named by the server and shown', async () => {
  const { page } = await studio.open('/');
  await page.fill('#text', 'nothing but words without meaning');
  await page.fill('.seed', '-1');
  await page.waitForSelector('#account .notice.bad');
  assert.match(await page.textContent('#account .notice.bad'), /\/seed|seed/);
  await page.context().close();
});

test('the options of a scene come from the schema of the server', async () => {
  const { page } = await studio.open('/');
  await page.click('.composer summary');
  await page.waitForSelector('#option-max_objects');
  assert.equal(await page.getAttribute('#option-max_objects', 'type'), 'number');
  await page.fill('.options .search input', 'gap');
  await page.waitForSelector('[id="option-layout.gap_m"]');
  await page.context().close();
});

test('a scene is drawn from the camera of its image, and its parts are linked', async () => {
  const { page, faults } = await studio.open(`/scenes/${scene.id}?light=plain`);
  await page.waitForSelector('.tools');
  await page.waitForTimeout(500);
  const share = await drawnShare(page);
  assert.ok(share > 0.02 && share < 0.98, `the model covers ${share} of the canvas`);
  await page.click('.tree button.node >> nth=1');
  assert.match(await page.textContent('.details'), /Center of mass/);
  await page.waitForSelector('.floating.object');
  await page.click('text=Hulls');
  await page.waitForSelector('text=Move hulls apart');
  await page.click('text=Grid');
  await page.waitForSelector('.floating.ruler');
  await page.click('text=Compare');
  await page.waitForSelector('.comparison img');
  await page.keyboard.press('b');
  assert.deepEqual(faults, []);
  await page.context().close();
});

test('the mask under the pointer is shown over the image, and a click selects its object', async () => {
  const { page, faults } = await studio.open(`/scenes/${scene.id}?light=plain`);
  await page.waitForSelector('.tools');
  await page.keyboard.press('i');
  await page.waitForSelector('.comparison .pointer');
  const { camera, instances } = await page.evaluate(
    (id) => fetch(`/scenes/${id}/files/scene.json`).then((response) => response.json()),
    scene.id,
  );
  const mug = instances.find((instance) => instance.name === 'mug_1');
  const [x0, y0, x1, y1] = mug.image.bbox_px;
  const box = await page.locator('.comparison .pointer').boundingBox();
  const at = [box.x + (box.width * (x0 + x1)) / 2 / camera.width_px, box.y + (box.height * (y0 + y1)) / 2 / camera.height_px];
  await page.mouse.move(...at);
  await page.waitForSelector('canvas.mask[data-mask="mug_1"]');
  const inked = await page.evaluate(() => {
    const canvas = document.querySelector('canvas.mask');
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return data.reduce((sum, value, index) => sum + (index % 4 === 3 && value > 0 ? 1 : 0), 0);
  });
  const share = inked / ((x1 - x0) * (y1 - y0));
  assert.ok(share > 0.4 && share <= 1.05, `the mask covers ${share} of its box`);
  await page.mouse.click(...at);
  assert.match(await page.textContent('.tree .node[aria-expanded="true"]'), /mug_1/);
  assert.deepEqual(faults, []);
  await page.context().close();
});

test('the check under gravity is replayed from the finished poses and from those of the image', async () => {
  const { page, faults } = await studio.open(`/scenes/${scene.id}?light=plain`);
  await page.waitForSelector('.tools');
  await page.keyboard.press('l');
  const farthest = () => page.locator('[data-farthest]').getAttribute('data-farthest').then(Number);
  assert.ok((await farthest()) < 2e-3, `a finished scene moves by ${await farthest()} m`);
  await page.click('.clock >> text=Play');
  await page.waitForFunction(() => Number(document.querySelector('.clock input').value) > 0.5);
  await page.click('text=From the poses of the image');
  await page.waitForSelector('[data-farthest]');
  await page.fill('.clock input', '5');
  await page.click('.tools >> text=Replay');
  await page.waitForSelector('[data-farthest]', { state: 'detached' });
  assert.deepEqual(faults, []);
  await page.context().close();
});

test('the certificate has each measurement beside its threshold', async () => {
  const { page } = await studio.open(`/scenes/${scene.id}?tab=certificate&light=plain`);
  await page.waitForSelector('.check-row');
  assert.equal(await page.locator('.check-row').count(), 14);
  assert.equal(await page.locator('.check-row .badge.bad').count(), 0);
  await page.context().close();
});

test('MuJoCo holds the scene still, and a push moves an object', async () => {
  const { page, faults } = await studio.open(`/scenes/${scene.id}?light=plain`);
  await page.waitForSelector('.tools');
  await page.click('.tools >> text=Physics');
  await page.waitForSelector('.physics .chip', { timeout: 60_000 });
  await page.waitForFunction(() => Number(document.querySelector('[data-time]')?.dataset.time) > 1, undefined, { timeout: 60_000 });
  const drift = () => page.locator('[data-drift]').first().getAttribute('data-drift').then(Number);
  assert.ok((await drift()) < 1e-3, `something moved by ${await drift()} m at rest`);
  await page.selectOption('.physics select', 'mug_1');
  await page.click('[aria-label="Push to the right"]');
  await page.waitForFunction(() => Number(document.querySelector('[data-drift]')?.dataset.drift) > 5e-3, undefined, { timeout: 60_000 });
  await page.click('text=Reset');
  await page.waitForFunction(() => Number(document.querySelector('[data-drift]')?.dataset.drift) < 1e-3);
  assert.deepEqual(faults, []);
  await page.context().close();
});

test('an edit shows its differences from the parent', async () => {
  const { page } = await studio.open(`/scenes/${edited.id}?tab=parent&light=plain`);
  await page.waitForSelector('.panel table tbody tr');
  assert.match(await page.textContent('.panel table tbody'), /mug_1.*removed/s);
  await page.context().close();
});

test('filters are in the address, and counts beside them', async () => {
  const { page } = await studio.open(`/gallery?label=suite:${suite}`);
  await page.waitForSelector('.gallery .cards > li');
  assert.equal(await page.locator('.gallery .cards > li').count(), 1);
  await page.focus('.facet li button:has-text("pass")');
  await page.keyboard.press('Enter');
  await page.waitForURL(/verdict=pass/);
  assert.match(await page.textContent('.chosen'), /Verdict: pass/);
  await page.fill('[type=search]', 'zzz');
  await page.keyboard.press('Enter');
  await page.waitForSelector('text=No scene fits these filters');
  await page.context().close();
});

test('a review by keys is kept by the server', async () => {
  const { page, faults } = await studio.open(`/gallery?label=suite:${suite}`);
  await page.waitForSelector('.gallery .cards > li');
  await page.keyboard.press('a');
  await page.waitForSelector('text=accepted');
  await once(`${studio.url}/scenes/${scene.id}`, ({ labels }) => labels.review === 'accept', 5);
  assert.deepEqual(faults, []);
  await page.context().close();
});

test('seven tabs of a browser load, share one stream of events, and all get them', async () => {
  const { page, context, faults } = await studio.open('/');
  await page.waitForSelector('.stream.live', { state: 'attached' });
  const streams = [];
  context.on('request', (request) => new URL(request.url()).pathname === '/events' && streams.push(request));
  // A browser opens six connections to a server, so seven streams would leave none for the files of the last page.
  const label = `tabs-${suite}`;
  const others = [];
  for (let index = 0; index < 6; index++) others.push((await studio.open(`/gallery?label=suite:${label}`, { context })).page);
  for (const other of others) {
    await other.waitForSelector('.stream.live', { state: 'attached' });
    await other.waitForSelector('text=No scene fits these filters');
  }
  assert.equal(streams.length, 0);
  await makeScene(studio.url, { text: 'A desk with a mug', seed: 1, labels: { suite: label } });
  for (const other of others) await other.waitForSelector('.gallery .cards .badge.good');
  await page.close();
  // Another tab takes over, and passes on what happens from then on.
  await others[0].waitForTimeout(1500);
  assert.equal(streams.length, 1);
  await makeScene(studio.url, { text: 'A desk with a mug', seed: 2, labels: { suite: label } });
  for (const other of others) await other.waitForSelector('.gallery .cards > li >> nth=1');
  assert.deepEqual(faults, []);
  await context.close();
});

test('the login dialog opens over the page, and the page goes on after it', async () => {
  const { page, context } = await studio.open('/');
  let isIn = false;
  await context.route(/\/(session|scenes)(\?|$)/, async (route) => {
    const request = route.request();
    if (request.method() === 'POST' && new URL(request.url()).pathname === '/session') {
      isIn = JSON.parse(request.postData()).key === 'tt_right';
      return isIn
        ? route.fulfill({ status: 204 })
        : route.fulfill({ status: 401, contentType: 'application/problem+json', body: '{"title":"Unknown key","detail":"No such key."}' });
    }
    return isIn ? route.continue() : route.fulfill({ status: 401, contentType: 'application/problem+json', body: '{"title":"Log in"}' });
  });
  await page.reload();
  await page.waitForSelector('dialog[open]');
  await page.fill('dialog input', 'tt_wrong');
  await page.keyboard.press('Enter');
  await page.waitForSelector('text=No such key.');
  assert.deepEqual(await violations(page), []);
  await page.fill('dialog input', 'tt_right');
  await page.keyboard.press('Enter');
  await page.waitForSelector('.recent .cards');
  assert.equal(await page.locator('dialog[open]').count(), 0);
  await context.close();
});

test('keys are listed by the question mark, and lead to pages', async () => {
  const { page } = await studio.open('/gallery');
  await page.waitForSelector('h1');
  await page.keyboard.press('?');
  await page.waitForSelector('dialog[open] kbd');
  await page.keyboard.press('Escape');
  await page.waitForSelector('dialog', { state: 'detached' });
  await page.keyboard.press('c');
  await page.waitForURL(/\/studio\/$/);
  await page.context().close();
});

test('an image can be pasted, is shown, and is sent as a file', async () => {
  const { page } = await studio.open('/');
  await page.waitForSelector('.recent');
  await page.evaluate(async () => {
    const canvas = Object.assign(document.createElement('canvas'), { width: 8, height: 8 });
    const blob = await new Promise((resolve) => canvas.toBlob(resolve));
    const data = new DataTransfer();
    data.items.add(new File([blob], 'table.png', { type: 'image/png' }));
    window.dispatchEvent(new ClipboardEvent('paste', { clipboardData: data }));
  });
  await page.waitForSelector('.image-chip img');
  const sent = page.waitForRequest((request) => request.method() === 'POST' && new URL(request.url()).pathname === '/scenes');
  await page.click('text=Make the scene');
  assert.match((await sent).headers()['content-type'], /^multipart\/form-data/);
  // The server refuses an image of 8 pixels, and says why.
  await page.waitForSelector('#account .notice.bad, .progress');
  await page.context().close();
});

/** Bytes of the page's own files that an address loads, as they are sent, and the number of all requests. */
async function loaded(path, ready) {
  const { page, context } = await studio.open('/nowhere');
  await page.waitForSelector('h1');
  const client = await context.newCDPSession(page);
  await client.send('Network.enable');
  await client.send('Network.setCacheDisabled', { cacheDisabled: true });
  const names = new Map();
  let bytes = 0;
  let requests = 0;
  client.on('Network.requestWillBeSent', ({ requestId, request }) => {
    if (!request.url.startsWith('http')) return;
    requests++;
    names.set(requestId, new URL(request.url).pathname);
  });
  client.on('Network.loadingFinished', ({ requestId, encodedDataLength }) => {
    if (names.get(requestId)?.startsWith('/studio/')) bytes += encodedDataLength;
  });
  await page.goto(`${studio.url}/studio${path}`);
  await page.waitForSelector(ready);
  await page.waitForTimeout(300);
  await context.close();
  return { bytes, requests };
}

test('the first view is small, and three is loaded only where a scene is shown', async (t) => {
  const first = await loaded('/', '.recent');
  const shown = await loaded(`/scenes/${scene.id}?light=plain`, '.tools');
  t.diagnostic(`first view ${first.bytes} bytes in ${first.requests} requests; scene ${shown.bytes} bytes in ${shown.requests} requests`);
  assert.ok(first.bytes > 1000 && first.bytes < 60_000, `the first view has ${first.bytes} bytes`);
  assert.ok(shown.bytes > first.bytes && shown.bytes < 250_000, `a scene has ${shown.bytes} bytes`);
});

const PAGES = () => [
  '/',
  '/gallery',
  `/scenes/${scene.id}?light=plain`,
  `/scenes/${scene.id}?tab=certificate&light=plain`,
  `/scenes/${scene.id}?tab=stages&light=plain`,
  `/scenes/${scene.id}?tab=download&light=plain`,
  `/scenes/${scene.id}?tab=code&light=plain`,
  `/scenes/${scene.id}?tab=edit&light=plain`,
  `/scenes/${edited.id}?tab=parent&light=plain`,
  '/batches',
  '/recordings',
  '/datasets',
  '/operate',
  '/operate?tab=keys',
  '/operate?tab=webhooks',
  '/operate?tab=audit',
  '/operate?tab=limits',
  '/nowhere',
];

for (const [name, options] of [
  ['light', {}],
  ['dark', { dark: true }],
  ['phone', { phone: true, dark: true }],
]) {
  test(`no page breaks a rule of accessibility or runs over the edge: ${name}`, async () => {
    const { page, context } = await studio.open('/', options);
    for (const path of PAGES()) {
      await page.goto(`${studio.url}/studio${path}`);
      await page.waitForSelector('main h1');
      await page.waitForFunction(() => !document.querySelector('.waiting'));
      await page.waitForTimeout(150);
      assert.deepEqual(await violations(page), [], path);
      const over = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.ok(over <= 0, `${path} is ${over} pixels wider than the screen`);
    }
    await context.close();
  });
}

test('without WebGL an image stands in for the model', async () => {
  const other = await start({ args: ['--disable-3d-apis', '--disable-webgl', '--disable-webgl2'] });
  try {
    const { id } = process.env.STUDIO_URL ? scene : await makeScene(other.url, { text: 'A desk with a mug', seed: 1 });
    const { page } = await other.open(`/scenes/${id}`);
    await page.waitForSelector('.fallback img');
    assert.match(await page.textContent('.fallback'), /no WebGL/);
    assert.equal(await page.evaluate(() => document.querySelector('.fallback img').complete), true);
    await page.waitForSelector('.tree');
  } finally {
    await other.stop();
  }
});
