/** Reviews of scenes: labels of the scene, changed only if they are still as they were read. */
import { getJson, request } from './api/fetch';
import type { Scene } from './api/types';

export const REVIEW = 'review';
export const NOTE = 'note';

export type Decision = 'accept' | 'reject';

/** Sets labels, and removes those that are null. */
export async function label(id: string, labels: Record<string, string | null>): Promise<Scene> {
  // The list has no entity tags; the state of the one scene does.
  const current = await request(`/scenes/${id}`, { headers: { accept: 'application/json' } });
  const etag = current.headers.get('etag');
  await current.body?.cancel();
  await request(`/scenes/${id}`, {
    method: 'PATCH',
    headers: { 'content-type': 'application/merge-patch+json', accept: 'application/json', ...(etag && { 'if-match': etag }) },
    body: JSON.stringify({ labels }),
  });
  return getJson<Scene>(`/scenes/${id}`);
}
