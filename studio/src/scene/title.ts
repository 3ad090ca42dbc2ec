/** What a scene is called, and whether its job has ended. */
import type { Scene } from '../api/types';
import { short } from '../format';

/** The text of the request, or what stands in its place. */
export function titleOf(scene: Pick<Scene, 'id' | 'request'>): string {
  const { text, kind } = scene.request.input;
  if (text) return text;
  return `${kind === 'image' ? 'Image' : kind === 'variant' ? 'Variant' : 'Scene'} ${short(scene.id)}`;
}

export function isOver(scene: Pick<Scene, 'job'>): boolean {
  return scene.job === null || ['succeeded', 'failed', 'cancelled'].includes(scene.job.state);
}

/** Whether the scene has files: a quarantined one has failed, and has them nevertheless. */
export function hasFiles(scene: Pick<Scene, 'state' | 'verdict'>): boolean {
  return scene.state === 'ready' || (scene.state === 'failed' && scene.verdict === 'quarantine');
}
