/** Small image of a scene. */
import { useState } from 'preact/hooks';
import type { Scene } from '../api/types';
import { hasFiles } from '../scene/title';

export function Thumbnail({ scene, width = 320 }: { scene: Pick<Scene, 'id' | 'state' | 'verdict' | 'job'>; width?: 160 | 320 | 640 }) {
  const [missing, setMissing] = useState(false);
  if (!hasFiles(scene) || missing) {
    const text = scene.state === 'pending' ? (scene.job?.state === 'running' ? 'in progress' : 'waiting') : 'no image';
    return <span class="thumbnail none">{text}</span>;
  }
  return (
    <span class="thumbnail">
      <img src={`/scenes/${scene.id}/preview?width=${width}`} alt="" loading="lazy" decoding="async" onError={() => setMissing(true)} />
    </span>
  );
}
