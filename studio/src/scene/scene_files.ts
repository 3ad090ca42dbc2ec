/** Addresses of the files of a scene. */
import type { Artifact, Scene } from '../api/types';

function suffix(scene: Pick<Scene, 'verdict'>, joint: '?' | '&'): string {
  return scene.verdict === 'quarantine' ? `${joint}quarantined=true` : '';
}

/** A file of the bundle, by its name there. */
export function fileUrl(scene: Pick<Scene, 'id' | 'verdict'>, name: string): string {
  return `/scenes/${scene.id}/files/${name}${suffix(scene, '?')}`;
}

export function bundleUrl(scene: Pick<Scene, 'id' | 'verdict'>, format: string): string {
  return `/scenes/${scene.id}/bundle?format=${format}${suffix(scene, '&')}`;
}

/** Address of an artifact, by its name. */
export function artifactUrl(scene: Pick<Scene, 'artifacts'>, name: string): string | undefined {
  return scene.artifacts?.find((artifact) => artifact.name === name)?.url;
}

/** Files of collision hulls by body; an edit has those of its parent, but for the bodies that it changed. */
export function hullUrls(scene: Pick<Scene, 'artifacts'>): Map<string, string> {
  const urls = new Map<string, string>();
  for (const form of [/^parent\/([^/]+)_hulls\.json$/, /^decompose\/([^/]+)\/hulls\.json$/, /^edit\/([^/]+)_hulls\.json$/]) {
    for (const artifact of scene.artifacts ?? []) {
      const found = form.exec(artifact.name);
      if (found) urls.set(found[1]!, artifact.url);
    }
  }
  return urls;
}

/** Images that stages made of one object: hidden parts, upright pose, rotation. */
export function imagesOf(scene: Pick<Scene, 'artifacts'>, name: string): Artifact[] {
  const isOfIt = (artifact: Artifact) => artifact.name.split('/').some((part) => part === name || part === `${name}.png`);
  return (scene.artifacts ?? []).filter((artifact) => artifact.media_type.startsWith('image/') && isOfIt(artifact));
}

/** The first lines of code under each heading of a bundle's `README.md`. */
export function examples(readme: string): { title: string; language: string; code: string }[] {
  const found: { title: string; language: string; code: string }[] = [];
  let title = '';
  for (const part of readme.split(/^(?=## |```)/m)) {
    const heading = /^## (.+)/.exec(part);
    if (heading) title = heading[1]!.trim();
    const block = /^```(python|js|sh)\n([\s\S]*)/.exec(part);
    if (block && title && !found.some((one) => one.title === title)) found.push({ title, language: block[1]!, code: block[2]!.trimEnd() });
  }
  return found;
}
