// Login, scopes and logout, against a server that asks for keys.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { start, violations } from './browser.mjs';

let studio;

before(async () => {
  studio = await start({ settings: ['server.authentication.mode=keys'], scopes: ['read', 'read,submit,delete,operate,admin'] });
});
after(() => studio?.stop());

async function logIn(page, key) {
  await page.waitForSelector('dialog[open]');
  await page.fill('dialog input', key);
  await page.keyboard.press('Enter');
  await page.waitForSelector('dialog', { state: 'detached' });
}

test('a key opens all tabs, and the page shows what its scopes allow', async () => {
  const [reader] = studio.keys;
  const { page, context } = await studio.open('/');
  const { page: other } = await studio.open('/gallery', { context });
  await other.waitForSelector('dialog[open]');
  await logIn(page, reader);
  await other.waitForSelector('text=There are no scenes yet');
  assert.equal(await other.locator('dialog').count(), 0);
  await page.waitForSelector('.stream.live', { state: 'attached' });
  await page.fill('#text', 'A desk with a mug');
  await page.waitForSelector('.account .chip');
  assert.ok(await page.isDisabled('text=Make the scene'));
  // The key is kept nowhere that a script could read it.
  assert.equal(await page.evaluate(() => JSON.stringify({ ...localStorage, ...sessionStorage }) + document.cookie), '{}');
  await page.goto(`${studio.url}/studio/operate?tab=keys`);
  await page.waitForSelector('text=This needs the scope admin');
  await context.close();
});

test('an administrator makes and revokes a key, and logs out', async () => {
  const [, admin] = studio.keys;
  const { page, context } = await studio.open('/operate?tab=keys');
  await logIn(page, admin);
  await page.fill('[placeholder="training machine"]', 'robot');
  await page.click('text=Make the key');
  await page.waitForSelector('.notice code');
  const made = await page.textContent('.notice code');
  const session = () => fetch(`${studio.url}/session`, { headers: { authorization: `Bearer ${made}` } });
  assert.equal((await session()).status, 200);
  page.once('dialog', (dialog) => dialog.accept());
  await page.click('tr:has-text("robot") >> text=Revoke');
  await page.waitForSelector('text=revoked');
  assert.equal((await session()).status, 401);
  await page.click('text=Log out');
  await page.waitForSelector('dialog[open]');
  await context.close();
});

test('a key that is revoked while a page is open is asked for again, and the page goes on where it was', async () => {
  const first = studio.makeKey('read,submit');
  const { page, context } = await studio.open('/');
  const { page: other } = await studio.open('/gallery', { context });
  await logIn(page, first.key);
  await other.waitForSelector('text=There are no scenes yet');
  await page.fill('#text', 'A desk with a mug');
  await page.waitForSelector('.account .chip');
  await page.fill('.seed', '5');
  await page.evaluate(() => (window.isMarked = true));
  studio.command('keys', 'revoke', first.id);
  await page.fill('#text', 'A desk with a mug and two books');
  await page.waitForSelector('dialog[open]');
  assert.deepEqual(await violations(page), []);
  await logIn(page, studio.makeKey('read,submit').key);
  // What was written stays, and the check that was refused is asked for again.
  await page.waitForSelector('.account .chip:has-text("book")');
  assert.equal(await page.inputValue('.seed'), '5');
  await page.click('text=Make the scene');
  await page.waitForSelector('.progress >> text=Open the scene');
  assert.equal(await page.evaluate(() => window.isMarked), true);
  await page.waitForSelector('.stream.live', { state: 'attached' });
  await other.waitForSelector('.gallery .cards .badge.good');
  assert.equal(await other.locator('dialog').count(), 0);
  await context.close();
});

test('a session that has expired is asked for again, also by the stream of events', async () => {
  const { page, context } = await studio.open('/');
  const key = studio.makeKey('read,submit').key;
  await logIn(page, key);
  await page.waitForSelector('.stream.live', { state: 'attached' });
  await context.clearCookies();
  // A stream that breaks comes back with what the browser has then.
  await studio.kill();
  await studio.restart();
  await page.waitForSelector('dialog[open]');
  await logIn(page, key);
  await page.waitForSelector('.stream.live', { state: 'attached' });
  await context.close();
});
