/** The request of a scene as commands and programs that make the same scene again. */
import type { Scene } from '../api/types';

export type Language = 'curl' | 'python' | 'json';

interface Call {
  path: string;
  body: Record<string, unknown>;
  /** The file name of an image that must lie beside the program. */
  image?: string;
}

const IMAGE_NAMES: Record<string, string> = { 'image/jpeg': 'image.jpg', 'image/webp': 'image.webp' };

function callOf(scene: Pick<Scene, 'parent' | 'request'>): Call {
  const { input, seed, options } = scene.request;
  const rest = { seed, ...(Object.keys(options).length > 0 && { options }) };
  switch (input.kind) {
    case 'image':
      return {
        path: '/scenes',
        body: { ...(input.text && { text: input.text }), ...rest },
        image: IMAGE_NAMES[input.media_type ?? ''] ?? 'image.png',
      };
    case 'text':
      return { path: '/scenes', body: { text: input.text, ...rest } };
    default:
      // A variant is kept as the operations that its seed drew, so it is repeated as an edit.
      if (input.operations) return { path: `/scenes/${scene.parent}/edits`, body: { operations: input.operations, ...rest } };
      if (input.text) return { path: `/scenes/${scene.parent}/edits`, body: { text: input.text, ...rest } };
      return { path: `/scenes/${scene.parent}/variants`, body: { count: 1, randomize: input.randomize, ...rest } };
  }
}

function shellQuoted(text: string): string {
  return `'${text.replaceAll("'", `'\\''`)}'`;
}

/** A value as Python writes it. */
export function pythonLiteral(value: unknown, indent = ''): string {
  if (value === null || value === undefined) return 'None';
  if (typeof value === 'boolean') return value ? 'True' : 'False';
  if (typeof value === 'number') return String(value);
  if (typeof value === 'string') return JSON.stringify(value);
  const inner = `${indent}    `;
  const list = Array.isArray(value);
  const parts = list
    ? value.map((one) => pythonLiteral(one, inner))
    : Object.entries(value).map(([name, one]) => `${JSON.stringify(name)}: ${pythonLiteral(one, inner)}`);
  const [open, close] = list ? ['[', ']'] : ['{', '}'];
  const line = open + parts.join(', ') + close;
  return line.length + indent.length <= 90 ? line : `${open}\n${parts.map((part) => `${inner}${part},\n`).join('')}${indent}${close}`;
}

export function asCode(scene: Pick<Scene, 'parent' | 'request'>, language: Language, server: string): string {
  const { path, body, image } = callOf(scene);
  const json = JSON.stringify(body);
  if (language === 'json') return JSON.stringify(body, null, 2);
  if (language === 'curl') {
    const content = image
      ? `-F image=@${image} -F ${shellQuoted(`request=${json};type=application/json`)}`
      : `-H 'content-type: application/json' \\\n     -d ${shellQuoted(json)}`;
    return `curl -s ${server}${path} -H 'prefer: wait=60' ${content}`;
  }
  const { text, seed, options, operations } = body;
  const given = [
    ...(image ? [`image=${JSON.stringify(image)}`] : []),
    ...(text ? [JSON.stringify(text)] : []),
    ...(operations ? [`operations=${pythonLiteral(operations)}`] : []),
    `seed=${seed}`,
    ...(options ? [`options=${pythonLiteral(options)}`] : []),
  ].join(', ');
  const parent = `client.scene(${JSON.stringify(scene.parent)})`;
  const made =
    path === '/scenes'
      ? `client.generate(${given}).wait()`
      : path.endsWith('/edits')
        ? `${parent}.edit(${given}).wait()`
        : `${parent}.variants(1, randomize=${pythonLiteral(body.randomize)}, seed=${seed})[0].wait()`;
  return [
    'from tabletopgen import Client',
    '',
    `client = Client(${JSON.stringify(server)})  # a key is taken from TABLETOPGEN_API_KEY`,
    `scene = ${made}`,
    'print(scene.ok, scene.metrics)',
  ].join('\n');
}
