// Runs the files of tests that are named, one after the other, on one server.
import { spawn } from 'node:child_process';
import { startServer } from './browser.mjs';

const server = await startServer({});
const tests = spawn(process.execPath, ['--test', '--test-concurrency=1', ...process.argv.slice(2)], {
  stdio: 'inherit',
  env: { ...process.env, STUDIO_URL: server.url },
});
tests.on('exit', async (code) => {
  await server.stop();
  process.exitCode = code ?? 1;
});
