/** A request for a scene, from the form to the server. */
import { idempotencyKey, Refusal, request, sendJson } from './api/fetch';
import type { Scene, Session, Validated } from './api/types';
import { bytes } from './format';

export interface Draft {
  text: string;
  image?: File | undefined;
  seed?: number | undefined;
  options: Record<string, unknown>;
}

/** The JSON document of the draft; of an image it lies beside the file. */
export function documentOf(draft: Draft): Record<string, unknown> {
  return {
    ...(draft.text.trim() && { text: draft.text }),
    ...(draft.seed !== undefined && { seed: draft.seed }),
    ...(Object.keys(draft.options).length > 0 && { options: draft.options }),
  };
}

const IMAGE_TYPES = ['image/png', 'image/jpeg', 'image/webp'];

/** Why a file cannot be the image of a request, or nothing. */
export function imageFault(file: File, limits: Session['limits'] | undefined): string | undefined {
  if (!IMAGE_TYPES.includes(file.type)) return `“${file.name}” is not a PNG, JPEG or WebP file.`;
  if (limits && file.size > limits.max_image_bytes) {
    return `“${file.name}” has ${bytes(file.size)}; this server accepts at most ${bytes(limits.max_image_bytes)}.`;
  }
  return undefined;
}

export function validate(draft: Draft, signal: AbortSignal): Promise<Validated> {
  return sendJson<Validated>('POST', '/scenes/validate', documentOf(draft), {}, signal);
}

/** Submits; `progress` gets the share of the image that has been sent. */
export async function submit(draft: Draft, progress: (share: number) => void): Promise<Scene> {
  if (!draft.image) return sendJson<Scene>('POST', '/scenes', documentOf(draft), idempotencyKey());
  // A session that ended in the meantime is renewed before the upload, not after it.
  await request('/version');
  const form = new FormData();
  form.set('request', new Blob([JSON.stringify(documentOf(draft))], { type: 'application/json' }));
  form.set('image', draft.image);
  return new Promise((resolve, reject) => {
    // `fetch` does not tell how much of a body was sent.
    const upload = new XMLHttpRequest();
    upload.open('POST', '/scenes');
    for (const [name, value] of Object.entries(idempotencyKey())) upload.setRequestHeader(name, value);
    upload.responseType = 'json';
    upload.upload.onprogress = (event) => event.lengthComputable && progress(event.loaded / event.total);
    upload.onload = () => {
      if (upload.status < 300) return resolve(upload.response as Scene);
      const problem = upload.response ?? {};
      reject(
        new Refusal(
          upload.status,
          '',
          problem.title ?? '',
          problem.detail ?? problem.title ?? `The server answered ${upload.status}.`,
          problem.errors ?? [],
        ),
      );
    };
    upload.onerror = () =>
      reject(new Refusal(0, 'unreachable', 'No answer', 'The image was not sent. Check that the server runs, then try again.', []));
    upload.send(form);
  });
}
