/** The checks of a certificate: each measurement beside its threshold. */
import { degrees, length, percent, significant } from '../format';
import type { Report, SceneDocument } from './documents';

export interface Check {
  title: string;
  /** Null for measurements that the verdict does not depend on. */
  passes: boolean | null;
  measured: string;
  asked: string;
  /** The body that decides, if one does. */
  worst?: string | undefined;
  /** The measurement over the threshold that it must not exceed (`most`) or must reach (`least`). */
  share?: number;
  bound?: 'most' | 'least';
}

interface Extreme {
  value: number;
  name: string | undefined;
}

/** The entry with the largest value, or zero of nothing. */
function largest<T extends { name: string }>(list: T[], value: (one: T) => number): Extreme {
  return list.reduce<Extreme>(
    (best, one) => (value(one) > best.value || best.name === undefined ? { value: value(one), name: one.name } : best),
    {
      value: 0,
      name: undefined,
    },
  );
}

function smallest<T extends { name: string }>(list: T[], value: (one: T) => number): Extreme {
  const found = largest(list, (one) => -value(one));
  return { ...found, value: -found.value };
}

/** The largest difference of the formats from the scene, over its tolerance. */
export function parityShare(parity: Report['parity']): { share: number; what: string } {
  let worst = { share: 0, what: '' };
  for (const format of ['usd', 'urdf', 'mjcf', 'sdf', 'glb'] as const) {
    for (const [name, deviation] of Object.entries(parity[format])) {
      const tolerance = parity.tolerances[name];
      if (deviation === null || tolerance === undefined || tolerance === null || tolerance === 0) continue;
      if (deviation / tolerance > worst.share)
        worst = { share: deviation / tolerance, what: `${format.toUpperCase()}, ${name.replace(/_(m|rad)$/, '').replaceAll('_', ' ')}` };
    }
  }
  return worst;
}

/** All checks in the order of the report. */
export function checksOf(report: Report, scene: Pick<SceneDocument, 'instances' | 'table'>): Check[] {
  const { thresholds: limits, objects, bodies, fidelity } = report;
  const fails = (code: string) => report.reasons.some((reason) => reason.code === code);
  const of = (number: number) => `${number} of ${objects.length}`;

  const deepest = report.collisions.reduce((most, pair) => Math.max(most, pair.depth_m), 0);
  const support = smallest(
    objects.filter((object) => object.support_margin_m !== null),
    (object) => object.support_margin_m!,
  );
  const supported = objects.filter((object) => (object.support_margin_m ?? -1) >= 0).length;
  const moved = largest(objects, (object) => Math.max(object.moved.after_shipping.distance_m, object.overlap_m) / object.rest_limit_m);
  const mover = objects.find((object) => object.name === moved.name);
  const edge = smallest(objects, (object) => object.outline_margin_m);
  const closed = bodies.filter((body) => body.watertight).length;
  const uncoveredLimit = (body: { size_m: number[] }) => Math.max(limits.uncovered_m, limits.uncovered_share * Math.max(...body.size_m));
  const uncovered = largest(bodies, (body) => body.uncovered_m / uncoveredLimit(body));
  const uncoveredBody = bodies.find((body) => body.name === uncovered.name);
  const excess = largest(bodies, (body) => body.hull_excess_m);
  const open = smallest(bodies, (body) => body.hull_fit.open_share);
  const dense = largest(bodies, (body) => body.density_kg_m3);
  const light = smallest(bodies, (body) => body.density_kg_m3);
  const rough = largest([scene.table, ...scene.instances], (body) => body.friction.static);
  const parity = parityShare(report.parity);
  const judged = (passes: boolean) => (fidelity.is_judged === false ? null : passes);

  return [
    {
      title: 'No bodies collide',
      passes: !fails('collision'),
      measured: report.collisions.length
        ? `${report.collisions.length} of ${report.pairs} pairs, deepest ${length(deepest)}`
        : `none of ${report.pairs} pairs`,
      asked: `none deeper than ${length(limits.penetration_m)} or ${percent(limits.wall_share)} of the wall`,
      worst: report.collisions.find((pair) => pair.depth_m === deepest)?.a,
      share: deepest / limits.penetration_m,
      bound: 'most',
    },
    {
      title: 'Every object is supported from below',
      passes: !fails('not_supported'),
      measured: support.name ? `${of(supported)}, least margin ${length(support.value)}` : of(supported),
      asked: `center of mass above the contacts, widened by ${length(limits.support_dilation_m)}`,
      worst: support.name,
    },
    {
      title: 'Every object stays at rest',
      passes: !fails('not_at_rest'),
      measured: mover
        ? `moves ${length(mover.moved.after_shipping.distance_m)}, turns ${degrees(mover.moved.after_shipping.angle_rad)}`
        : 'no objects',
      asked: mover
        ? `less than ${length(mover.rest_limit_m)} (${percent(limits.rest_side_share)} of its side) and ${degrees(limits.rest_rotation_rad)} in ${significant(limits.dss_duration_s)} s`
        : '',
      worst: moved.name,
      share: moved.value,
      bound: 'most',
    },
    {
      title: 'No object reaches over the edge',
      passes: !fails('over_the_edge'),
      measured: `least margin ${length(edge.value)}`,
      asked: `at most ${length(limits.outline_m)} beyond the outline`,
      worst: edge.name,
    },
    {
      title: 'Every mesh is closed',
      passes: !fails('open_mesh'),
      measured: `${closed} of ${bodies.length}`,
      asked: 'every edge has a face on either side',
      worst: bodies.find((body) => !body.watertight)?.name,
    },
    {
      title: 'Hulls cover their mesh',
      passes: !fails('missing_collider'),
      measured: uncoveredBody ? `${length(uncoveredBody.uncovered_m)} outside` : '–',
      asked: uncoveredBody ? `at most ${length(uncoveredLimit(uncoveredBody))}` : '',
      worst: uncovered.name,
      share: uncovered.value,
      bound: 'most',
    },
    {
      title: 'Hulls do not stick out',
      passes: !fails('protruding_collider'),
      measured: length(excess.value),
      asked: `at most ${length(limits.hull_excess_m)}`,
      worst: excess.name,
      share: excess.value / limits.hull_excess_m,
      bound: 'most',
    },
    {
      title: 'Hulls leave openings open',
      passes: !fails('closed_opening'),
      measured: `${percent(open.value)} of an opening`,
      asked: `at least ${percent(limits.open_share)}`,
      worst: open.name,
      share: open.value / limits.open_share,
      bound: 'least',
    },
    {
      title: 'Densities are plausible',
      passes: !fails('implausible_density'),
      measured: `${significant(light.value)} to ${significant(dense.value)} kg/m³`,
      asked: `${significant(limits.density_kg_m3[0])} to ${significant(limits.density_kg_m3[1])} kg/m³`,
      worst: dense.name,
      share: dense.value / limits.density_kg_m3[1],
      bound: 'most',
    },
    {
      title: 'Friction is plausible',
      passes: !fails('implausible_friction'),
      measured: `static up to ${significant(rough.value)}`,
      asked: `at most ${significant(limits.friction)}`,
      worst: rough.name,
      share: rough.value / limits.friction,
      bound: 'most',
    },
    {
      title: 'Outlines agree with the reference image',
      passes: judged(fidelity.silhouette_iou >= limits.silhouette_iou),
      measured: `overlap ${significant(fidelity.silhouette_iou)}`,
      asked: `at least ${significant(limits.silhouette_iou)}`,
      share: fidelity.silhouette_iou / limits.silhouette_iou,
      bound: 'least',
    },
    {
      title: 'The scene shows what the image shows',
      passes: judged(fidelity.missed.share <= limits.missed_share),
      measured: `${percent(fidelity.missed.share)} of its pixels missed`,
      asked: `at most ${percent(limits.missed_share)}`,
      share: fidelity.missed.share / limits.missed_share,
      bound: 'most',
    },
    {
      title: 'The image shows what the scene shows',
      passes: judged(fidelity.invented.share <= limits.invented_share),
      measured: `${percent(fidelity.invented.share)} of its pixels invented`,
      asked: `at most ${percent(limits.invented_share)}`,
      share: fidelity.invented.share / limits.invented_share,
      bound: 'most',
    },
    {
      title: 'All formats hold the same scene',
      passes: true,
      measured: parity.what ? `largest difference: ${parity.what}` : 'no difference',
      asked: 'within the tolerance of each quantity',
      share: parity.share,
      bound: 'most',
    },
  ];
}

/** Bodies that a reason of the verdict names. */
export function accused(report: Report): Set<string> {
  return new Set(report.reasons.flatMap((reason) => reason.bodies));
}
