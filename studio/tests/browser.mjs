// A server with the page, and a browser, for tests. `STUDIO_URL` names a server that runs already; else the program
// `TABLETOPGEN` (or `target/release/tabletopgen`) is started with temporary data. `CHROMIUM` names the browser.
import { execFileSync, spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

const axe = readFileSync(new URL('../node_modules/axe-core/axe.min.js', import.meta.url), 'utf8');

/** Arguments of the browser: nothing of its own goes to the network, and it draws without a GPU. */
export const FLAGS = [
  '--no-sandbox',
  '--disable-quic',
  '--no-first-run',
  '--disable-background-networking',
  '--disable-component-update',
  '--disable-sync',
  '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader',
];

const program = process.env.TABLETOPGEN ?? new URL('../../target/release/tabletopgen', import.meta.url).pathname;

/** Starts the program on `data` at an address, and ends when it serves. */
async function serve(data, address, settings) {
  // Only what went wrong: a line for each request hides what the tests say.
  const options = ['log.filter=warn', ...settings].flatMap((setting) => ['--set', setting]);
  const child = spawn(program, ['serve', '--listen', address, '--data-dir', data, '--json', '--quiet', ...options], {
    stdio: ['ignore', 'pipe', 'inherit'],
  });
  const ended = new Promise((resolve) => child.on('exit', resolve));
  const url = await new Promise((resolve, reject) => {
    let text = '';
    child.on('error', reject);
    child.on('exit', (code) => reject(new Error(`${program} ended with ${code} before it served`)));
    child.stdout.on('data', (bytes) => {
      text += bytes;
      const found = /http:\/\/[0-9.]+:\d+/.exec(text);
      if (found) resolve(found[0]);
    });
  });
  const end = (signal) => {
    child.kill(signal);
    return ended;
  };
  return { url, end };
}

/** A server that runs already, unless the test needs one of its `own`; else the program with temporary data. */
export async function startServer({ settings = [], scopes = [], own = false }) {
  if (process.env.STUDIO_URL && !settings.length && !own) return { url: process.env.STUDIO_URL, keys: [], stop: async () => {} };
  const data = mkdtempSync(join(tmpdir(), 'studio-'));
  let server = await serve(data, '127.0.0.1:0', settings);
  const { url } = server;
  /** Runs a command of the program on the data of the server. */
  const command = (...words) => execFileSync(program, [...words, '--data-dir', data], { encoding: 'utf8' });
  const makeKey = (list) => {
    const made = JSON.parse(command('keys', 'create', '--name', 'test', '--scopes', list, '--json'));
    return { id: made.id, key: made.key };
  };
  return {
    url,
    data,
    command,
    makeKey,
    keys: scopes.map((list) => makeKey(list).key),
    kill: () => server.end('SIGKILL'),
    async restart() {
      server = await serve(data, new URL(url).host, settings);
    },
    async stop() {
      await server.end('SIGTERM');
      rmSync(data, { recursive: true, force: true });
    },
  };
}

/** Starts both. `page(options)` opens an address of the page, and keeps what goes wrong there in `faults`. */
export async function start({ args = [], ...options } = {}) {
  const server = await startServer(options);
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: [...FLAGS, ...args],
  });
  const open = async (path, { phone = false, dark = false, context: given } = {}) => {
    const context =
      given ??
      (await browser.newContext({
        viewport: phone ? { width: 390, height: 844 } : { width: 1280, height: 900 },
        isMobile: phone,
        hasTouch: phone,
        colorScheme: dark ? 'dark' : 'light',
        reducedMotion: 'reduce',
      }));
    context.setDefaultTimeout(30_000);
    const page = await context.newPage();
    const faults = [];
    page.on('pageerror', (error) => faults.push(error.message));
    page.on('console', (message) => message.type() === 'error' && faults.push(message.text()));
    page.on('request', (request) => {
      const { origin, protocol } = new URL(request.url());
      if (!['blob:', 'data:'].includes(protocol) && origin !== server.url) faults.push(`asked ${request.url()}`);
    });
    await page.goto(`${server.url}/studio${path}`);
    return { page, context, faults };
  };
  return {
    ...server,
    open,
    async stop() {
      await browser.close();
      await server.stop();
    },
  };
}

/** Rules of accessibility that a page breaks, with the first places of each. */
export async function violations(page) {
  return page.evaluate(
    `${axe}; axe.run().then(({ violations }) => violations.map((one) => one.id + ': ' + one.nodes.slice(0, 3).map((node) => node.target.join(' ')).join(', ')))`,
  );
}

/** Posts a document, waits for what comes of it where the server can, and gives the answer. */
export async function post(url, body, wait_s = 60) {
  const headers = { 'content-type': 'application/json', prefer: `wait=${wait_s}` };
  const answer = await fetch(url, { method: 'POST', headers, body: JSON.stringify(body) });
  const made = await answer.json();
  if (!answer.ok) throw new Error(`${url} refused ${JSON.stringify(body)}: ${JSON.stringify(made)}`);
  return made;
}

/** A document of the server, once `wanted` holds for it. */
export async function once(url, wanted, seconds = 60) {
  for (const end = Date.now() + 1000 * seconds; ; await new Promise((resolve) => setTimeout(resolve, 200))) {
    const found = await fetch(url).then(
      (answer) => answer.json(),
      () => undefined,
    );
    if (found && wanted(found)) return found;
    if (Date.now() > end) throw new Error(`${url} did not become what the test waits for: ${JSON.stringify(found)}`);
  }
}

/** Moves the focus by the Tab key to the control of a text. */
export async function tabTo(page, text) {
  for (let left = 100; left > 0; left--) {
    await page.keyboard.press('Tab');
    if ((await page.evaluate(() => document.activeElement.textContent.trim())) === text) return;
  }
  throw new Error(`the Tab key does not come to “${text}”`);
}

/** A finished scene, made from a text. */
export async function makeScene(url, body) {
  const scene = await post(`${url}/scenes`, body);
  if (scene.state !== 'ready') throw new Error(`the scene of the test is ${scene.state ?? JSON.stringify(scene)}`);
  return scene;
}
