/** Differences between a scene and the one that it was made from. */
import type { Instance, Metrics, SceneDocument } from './documents';

export interface Difference {
  name: string;
  label: string;
  what: 'added' | 'removed' | 'moved' | 'changed' | 'same';
  /** Displacement of the origin in the world, meters. */
  dx: number;
  dy: number;
  dz: number;
  /** Rotation about the vertical axis, -pi..pi; null where either has none. */
  dyaw: number | null;
  /** Child over parent. */
  massRatio: number;
  sizeRatio: number;
  frictionRatio: number;
}

/** Movements below these are noise of the settling. */
const STILL_M = 1e-4;
const STILL_RAD = 1e-3;

function wrapped(angle: number): number {
  return angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
}

function compare(before: Instance, after: Instance): Difference {
  const [dx, dy, dz] = after.translation_m.map((value, axis) => value - before.translation_m[axis]!) as [number, number, number];
  const dyaw = before.yaw_rad === null || after.yaw_rad === null ? null : wrapped(after.yaw_rad - before.yaw_rad);
  const massRatio = after.mass_kg / before.mass_kg;
  const sizeRatio = Math.max(...after.size_m) / Math.max(...before.size_m);
  const frictionRatio = after.friction.dynamic / before.friction.dynamic;
  const isMoved = Math.hypot(dx, dy, dz) > STILL_M || Math.abs(dyaw ?? 0) > STILL_RAD;
  const isOther = before.label !== after.label || [massRatio, sizeRatio, frictionRatio].some((ratio) => Math.abs(ratio - 1) > 1e-6);
  return {
    name: after.name,
    label: after.label,
    what: isOther ? 'changed' : isMoved ? 'moved' : 'same',
    dx,
    dy,
    dz,
    dyaw,
    massRatio,
    sizeRatio,
    frictionRatio,
  };
}

/** One row per object of either scene: first what differs, then what is the same. */
export function differences(parent: SceneDocument, child: SceneDocument): Difference[] {
  const before = new Map(parent.instances.map((instance) => [instance.name, instance]));
  const after = new Map(child.instances.map((instance) => [instance.name, instance]));
  const only = (instance: Instance, what: 'added' | 'removed'): Difference => ({
    name: instance.name,
    label: instance.label,
    what,
    dx: 0,
    dy: 0,
    dz: 0,
    dyaw: null,
    massRatio: 1,
    sizeRatio: 1,
    frictionRatio: 1,
  });
  const rows = [
    ...child.instances.map((instance) => {
      const old = before.get(instance.name);
      return old ? compare(old, instance) : only(instance, 'added');
    }),
    ...parent.instances.filter((instance) => !after.has(instance.name)).map((instance) => only(instance, 'removed')),
  ];
  const order = ['added', 'removed', 'changed', 'moved', 'same'];
  return rows.sort((a, b) => order.indexOf(a.what) - order.indexOf(b.what));
}

/** Metrics that differ, child minus parent. */
export function metricChanges(parent: Metrics, child: Metrics): { name: keyof Metrics; before: number; after: number }[] {
  return (Object.keys(child) as (keyof Metrics)[])
    .filter((name) => Math.abs(child[name] - parent[name]) > 1e-9)
    .map((name) => ({ name, before: parent[name], after: child[name] }));
}
