/** `scene.json` and `report.json` of a bundle, as far as the page reads them; `schemas/` describes them in full. */
import type { TextAccount } from '../api/types';

export type Vector = [number, number, number];
export type Quaternion = [number, number, number, number];

export interface Pose {
  translation_m: Vector;
  /** Unit quaternion, x, y, z, w. */
  rotation_xyzw: Quaternion;
}

interface Physical {
  name: string;
  label: string;
  size_m: Vector;
  mass_kg: number;
  center_of_mass_m: Vector;
  inertia_diagonal_kg_m2: Vector;
  principal_axes_xyzw: Quaternion;
  friction: { static: number; dynamic: number };
  restitution: number;
  hulls: number;
  mesh: string;
}

export interface Instance extends Physical, Pose {
  category: string;
  stand_in?: boolean;
  stands_for?: string;
  shown_as?: string;
  image: { bbox_px: [number, number, number, number] };
  /** About the world's vertical axis; null near the singularity. */
  yaw_rad: number | null;
  /** 1 none, n every 360/n degrees, 0 any angle. */
  symmetry_order: number;
  support: { parent: string; relation: 'on' | 'in' };
  provenance: { mesh_by: string; licence: string; notes: string[] };
}

export interface Table extends Physical {
  shape: string;
  outline_m: [number, number][];
  height_m: number;
}

export interface SceneDocument {
  format: string;
  id: string;
  seed: number;
  camera: {
    width_px: number;
    height_px: number;
    fx: number;
    fy: number;
    cx: number;
    cy: number;
    /** OpenCV axes: x right, y down, z forward. */
    world_from_camera: Pose;
  };
  table: Table;
  instances: Instance[];
  metrics: Metrics;
  text?: TextAccount;
}

export interface Metrics {
  col_o: number;
  col_s: number;
  ss: number;
  dss_aligned: number;
  dss_shipped: number;
}

interface Displacement {
  distance_m: number;
  angle_rad: number;
}

export interface ObjectCertificate {
  name: string;
  support_margin_m: number | null;
  moved: {
    by_resolve: Displacement;
    by_settling: Displacement;
    from_aligned: Displacement;
    after_shipping: Displacement;
    after_aligning: Displacement;
  };
  rest_limit_m: number;
  overlap_m: number;
  outline_margin_m: number;
  inside_outline: boolean;
  silhouette_iou: number;
  color_difference: number | null;
  method: string;
}

export interface BodyHealth {
  name: string;
  watertight: boolean;
  triangles: number;
  size_m: Vector;
  density_kg_m3: number;
  hulls: number;
  hull_excess_m: number;
  uncovered_m: number;
  hull_fit: { air_share: number; open_share: number };
}

export interface Reason {
  code: string;
  bodies: string[];
  sentence: string;
}

type Deviation = Record<string, number | null>;

export interface Report {
  verdict: 'pass' | 'quarantine';
  summary: string;
  reasons: Reason[];
  metrics: Metrics;
  pairs: number;
  fidelity: {
    is_judged?: boolean;
    silhouette_iou: number;
    color_difference: number | null;
    missed: { share: number };
    invented: { share: number };
    appearance: { similarity: number };
  };
  thresholds: {
    penetration_m: number;
    wall_share: number;
    support_dilation_m: number;
    dss_displacement_m: number;
    dss_rotation_rad: number;
    dss_duration_s: number;
    rest_side_share: number;
    rest_rotation_rad: number;
    outline_m: number;
    silhouette_iou: number;
    missed_share: number;
    invented_share: number;
    hull_excess_m: number;
    uncovered_m: number;
    uncovered_share: number;
    open_share: number;
    longest_side_m: [number, number];
    density_kg_m3: [number, number];
    friction: number;
  };
  objects: ObjectCertificate[];
  bodies: BodyHealth[];
  collisions: { a: string; b: string; depth_m: number }[];
  resolve: { rounds: number; log: string[] };
  parity: { tolerances: Deviation } & Record<'usd' | 'urdf' | 'mjcf' | 'sdf' | 'glb', Deviation>;
}
