/** Stages of a job, with the work on single objects folded under their stage. */
import type { Artifact, Stage } from '../api/types';

/** Stages of a scene in the order in which they run. */
export const STAGES = [
  'reference',
  'recognize',
  'segment',
  'complete',
  'reconstruct',
  'canonicalize',
  'decompose',
  'refine_camera',
  'rotate',
  'place',
  'resolve',
  'clutter',
  'grasp',
  'rehearse',
  'certify',
  'bundle',
];

/** What each stage does, for people. */
export const STAGE_TITLES: Record<string, string> = {
  reference: 'Reference image',
  recognize: 'Objects',
  segment: 'Masks',
  complete: 'Hidden parts',
  reconstruct: 'Meshes',
  canonicalize: 'Upright pose',
  decompose: 'Collision hulls',
  refine_camera: 'Camera',
  rotate: 'Rotation',
  place: 'Layout',
  resolve: 'Settling',
  clutter: 'Clutter',
  grasp: 'Grasps',
  rehearse: 'Robot tasks',
  certify: 'Certificate',
  bundle: 'Files',
  edit: 'Edit',
};

export interface StageRow {
  stage: string;
  state: 'waiting' | 'running' | 'finished' | 'failed';
  /** Parts that are finished, of all that have begun. */
  finished: number;
  parts: number;
  cached: boolean;
  retries: number;
  /** Sum of the computation of all parts, milliseconds. */
  computed_ms: number;
  image?: Artifact;
}

/** Images that show a stage, best first; others are taken only if none of these exists. */
const IMAGES = [
  'masks.png',
  'camera.png',
  'top_annotated.png',
  'sheet.png',
  'reference.png',
  'beside.png',
  'canonical.png',
  'completed.png',
];

function imageOf(artifacts: Artifact[]): Artifact | undefined {
  const images = artifacts.filter((artifact) => artifact.media_type.startsWith('image/'));
  for (const name of IMAGES) {
    const found = images.filter((image) => image.name.endsWith(`/${name}`) || image.name === name).at(-1);
    if (found) return found;
  }
  return images.at(-1);
}

/** One row per stage: those that ran, and while the job goes on those that are still to come. */
export function stageRows(stages: Stage[], artifacts: Artifact[], ended: boolean): StageRow[] {
  const began = [...new Set(stages.map((one) => one.stage))];
  const order = (name: string) => (STAGES.includes(name) ? STAGES.indexOf(name) : began.indexOf(name) - STAGES.length);
  // Edits and variants have stages of their own, and only some of the usual ones.
  const isUsual = began.every((name) => STAGES.includes(name));
  const optional = ['grasp', 'rehearse'];
  const names = ended || !isUsual ? began : [...began, ...STAGES.filter((name) => !began.includes(name) && !optional.includes(name))];
  return names
    .sort((a, b) => order(a) - order(b))
    .map((name) => {
      const parts = stages.filter((one) => one.stage === name);
      const finished = parts.filter((one) => one.state === 'finished').length;
      const image = imageOf(artifacts.filter((artifact) => artifact.stage === name));
      return {
        stage: name,
        state: !parts.length ? 'waiting' : finished === parts.length ? 'finished' : ended ? 'failed' : 'running',
        finished,
        parts: parts.length,
        cached: parts.length > 0 && parts.every((one) => one.cached),
        retries: parts.reduce((sum, one) => sum + Math.max(0, one.runs - 1), 0),
        computed_ms: parts.reduce((sum, one) => sum + (one.elapsed_ms ?? 0), 0),
        ...(image && { image }),
      };
    });
}
