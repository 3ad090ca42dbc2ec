/** The settle track of a scene: how its bodies moved while the certificate watched them. */

/** x, y, z in meters, then a unit quaternion x, y, z, w; `world_from_object`. */
type Row = [number, number, number, number, number, number, number];

/** Poses of each body from the start until it stays where it is. */
export type Track = Record<string, Row[]>;

/** The artifact `certify/track.json`. */
export interface Tracks {
  rate_hz: number;
  duration_s: number;
  from_shipped: Track;
  from_aligned?: Track;
}

/** Poses of the named bodies at a time, seven numbers each: position, then w, x, y, z. */
export function posesAt(track: Track, names: string[], rate_hz: number, time_s: number): Float32Array {
  const poses = new Float32Array(names.length * 7);
  names.forEach((name, index) => {
    const rows = track[name]!;
    const frame = Math.min(Math.max(0, time_s * rate_hz), rows.length - 1);
    const [before, after] = [rows[Math.floor(frame)]!, rows[Math.ceil(frame)]!];
    const share = frame - Math.floor(frame);
    // A thirtieth of a second apart, the shorter way between two rotations is nearly straight.
    const dot = before.slice(3).reduce((sum, value, axis) => sum + value * after[3 + axis]!, 0);
    const sign = dot < 0 ? -1 : 1;
    const mixed = before.map((value, axis) => value + share * ((axis < 3 ? 1 : sign) * after[axis]! - value));
    const norm = Math.hypot(...mixed.slice(3)) || 1;
    const [x, y, z, qx, qy, qz, qw] = mixed as Row;
    poses.set([x, y, z, qw / norm, qx / norm, qy / norm, qz / norm], 7 * index);
  });
  return poses;
}

/** The farthest that any body gets from its start, in meters. */
export function farthest(track: Track): number {
  const away = (rows: Row[]) => Math.max(...rows.map((row) => Math.hypot(...[0, 1, 2].map((axis) => row[axis]! - rows[0]![axis]!))));
  return Math.max(0, ...Object.values(track).map(away));
}
