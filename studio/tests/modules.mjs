// Modules of the page for tests in node: rolldown, which vite is made of, takes the types away.
import { rolldown } from 'rolldown';

/** The exports of a module below `src`. */
export async function load(path) {
  const bundle = await rolldown({ input: new URL(`../src/${path}`, import.meta.url).pathname, logLevel: 'silent' });
  const { output } = await bundle.generate({ format: 'es' });
  return import(`data:text/javascript;base64,${Buffer.from(output[0].code).toString('base64')}`);
}
