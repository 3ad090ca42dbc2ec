/** The objects as a tree of supports, linked with the viewer. */
import type { ComponentChildren } from 'preact';
import { count, degrees, fixed, length, mass, percent, significant } from '../format';
import type { Scene } from '../api/types';
import { Badge } from '../ui/parts';
import type { Instance, Report, SceneDocument } from './documents';
import { imagesOf } from './scene_files';
import { STAGE_TITLES } from './stages';

interface Props {
  scene: Scene;
  document: SceneDocument;
  report: Report | undefined;
  accused: Set<string>;
  selected: string | undefined;
  onSelect: (name: string | undefined) => void;
}

export function ObjectTree({ scene, document: doc, report, accused, selected, onSelect }: Props) {
  const childrenOf = (name: string) => doc.instances.filter((instance) => instance.support.parent === name);
  const branch = (name: string, depth: number): ComponentChildren =>
    childrenOf(name).map((instance) => (
      <li key={instance.name}>
        <button
          type="button"
          class="node"
          style={{ paddingLeft: `${8 + depth * 16}px` }}
          aria-expanded={selected === instance.name}
          onClick={() => onSelect(selected === instance.name ? undefined : instance.name)}
        >
          <span class="label">{instance.label}</span>
          <span class="hint">{instance.support.relation === 'in' ? `in ${name}` : instance.name}</span>
          {instance.stand_in && <Badge tone="plain">stand-in</Badge>}
          {accused.has(instance.name) && <Badge tone="bad">fails</Badge>}
          <span class="spring" />
          <span class="number hint">{mass(instance.mass_kg)}</span>
        </button>
        {selected === instance.name && <Details scene={scene} instance={instance} report={report} />}
        {childrenOf(instance.name).length > 0 && <ul>{branch(instance.name, depth + 1)}</ul>}
      </li>
    ));
  return (
    <ul class="tree">
      <li>
        <p class="node root">
          <span class="label">{doc.table.label}</span>
          <span class="spring" />
          <span class="number hint">
            {doc.table.size_m.map((value) => Math.round(value * 100)).join(' × ')} cm, {mass(doc.table.mass_kg)}
          </span>
        </p>
        <ul>{branch(doc.table.name, 0)}</ul>
      </li>
    </ul>
  );
}

function Details({ scene, instance, report }: { scene: Scene; instance: Instance; report: Report | undefined }) {
  const images = imagesOf(scene, instance.name);
  const certificate = report?.objects.find((object) => object.name === instance.name);
  const health = report?.bodies.find((body) => body.name === instance.name);
  const vector = (values: number[], factor: number) => values.map((value) => fixed(value * factor, 1)).join(', ');
  const facts: [string, ComponentChildren][] = [
    ['Size', `${vector(instance.size_m, 100)} cm`],
    ['Position', `${vector(instance.translation_m, 100)} cm`],
    ['Rotation about z', instance.yaw_rad === null ? 'undefined here' : degrees(instance.yaw_rad)],
    [
      'Symmetry',
      instance.symmetry_order === 0
        ? 'round'
        : instance.symmetry_order === 1
          ? 'none'
          : `every ${significant(360 / instance.symmetry_order)}°`,
    ],
    ['Mass', mass(instance.mass_kg)],
    ['Center of mass', `${vector(instance.center_of_mass_m, 100)} cm`],
    ['Inertia', `${instance.inertia_diagonal_kg_m2.map((value) => significant(value * 1e4, 2)).join(', ')} kg cm²`],
    ['Friction', `static ${significant(instance.friction.static)}, dynamic ${significant(instance.friction.dynamic)}`],
    ['Restitution', significant(instance.restitution)],
    ['Hulls', health ? `${instance.hulls}; ${percent(health.hull_fit.air_share)} air` : instance.hulls],
    ...(health ? ([['Density', `${significant(health.density_kg_m3)} kg/m³`]] as [string, string][]) : []),
    ...(certificate
      ? ([
          ['Moved in the check', `${length(certificate.moved.after_shipping.distance_m)}, limit ${length(certificate.rest_limit_m)}`],
          ['Outline overlap', significant(certificate.silhouette_iou)],
          ['Mesh by', `${instance.provenance.mesh_by} (${certificate.method})`],
        ] as [string, string][])
      : []),
    ['License', instance.provenance.licence],
    ...(instance.stand_in
      ? ([['Stands for', `${instance.stands_for ?? instance.label}, shown as ${instance.shown_as ?? 'a plain shape'}`]] as [
          string,
          string,
        ][])
      : []),
  ];
  return (
    <div class="details">
      <dl class="facts">
        {facts.map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd class="number">{value}</dd>
          </div>
        ))}
      </dl>
      {images.length > 0 && (
        <details>
          <summary>{count(images.length, 'image')} of its stages</summary>
          <ul class="images">
            {images.map((image) => (
              <li key={image.name}>
                <a href={image.url} target="_blank" rel="noreferrer">
                  <img src={image.url} alt={image.name} loading="lazy" />
                </a>
                <span class="hint">{STAGE_TITLES[image.stage] ?? image.stage}</span>
              </li>
            ))}
          </ul>
        </details>
      )}
      {instance.provenance.notes.length > 0 && (
        <ul class="hint">
          {instance.provenance.notes.map((note) => (
            <li key={note}>{note}</li>
          ))}
        </ul>
      )}
    </div>
  );
}
