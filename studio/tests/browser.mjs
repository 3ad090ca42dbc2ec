// A server with the page, and a browser, for tests. `STUDIO_URL` names a server that runs already; else the program
// `TABLETOPGEN` (or `target/release/tabletopgen`) is started with temporary data. `CHROMIUM` names the browser.
import { execFileSync, spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

const axe = readFileSync(new URL('../node_modules/axe-core/axe.min.js', import.meta.url), 'utf8');

/** Address of a running server, or one of a program with `settings` and keys of the given scopes. */
async function startServer(settings, scopes) {
  if (process.env.STUDIO_URL && !settings.length) return { url: process.env.STUDIO_URL, keys: [], stop: async () => {} };
  const program = process.env.TABLETOPGEN ?? new URL('../../target/release/tabletopgen', import.meta.url).pathname;
  const data = mkdtempSync(join(tmpdir(), 'studio-'));
  const server = spawn(program, ['serve', '--listen', '127.0.0.1:0', '--data-dir', data, '--json', ...settings.flatMap((setting) => ['--set', setting])], {
    stdio: ['ignore', 'pipe', 'inherit'],
  });
  const ended = new Promise((resolve) => server.on('exit', resolve));
  const url = await new Promise((resolve, reject) => {
    let text = '';
    server.on('error', reject);
    server.on('exit', (code) => reject(new Error(`${program} ended with ${code} before it served`)));
    server.stdout.on('data', (bytes) => {
      text += bytes;
      const found = /http:\/\/[0-9.]+:\d+/.exec(text);
      if (found) resolve(found[0]);
    });
  });
  const make = (list) => execFileSync(program, ['keys', 'create', '--name', 'test', '--scopes', list, '--data-dir', data], { encoding: 'utf8' });
  return {
    url,
    keys: scopes.map((list) => /tt_\S+/.exec(make(list))[0]),
    async stop() {
      server.kill('SIGTERM');
      await ended;
      rmSync(data, { recursive: true, force: true });
    },
  };
}

/** Starts both. `page(options)` opens an address of the page, and keeps what goes wrong there in `faults`. */
export async function start({ args = [], settings = [], scopes = [] } = {}) {
  const server = await startServer(settings, scopes);
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: [
      '--no-sandbox',
      '--disable-quic',
      '--no-first-run',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
      '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader',
      ...args,
    ],
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
    url: server.url,
    keys: server.keys,
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

/** A finished scene, made from a text. */
export async function makeScene(url, body) {
  const headers = { 'content-type': 'application/json', prefer: 'wait=60' };
  const answer = await fetch(`${url}/scenes`, { method: 'POST', headers, body: JSON.stringify(body) });
  const scene = await answer.json();
  if (scene.state !== 'ready') throw new Error(`the scene of the test is ${scene.state ?? JSON.stringify(scene)}`);
  return scene;
}
