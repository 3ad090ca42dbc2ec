/** Numbers of episodes from the tables of a LeRobot dataset. */
import { parquetReadObjects } from 'hyparquet';
import { getJson, request } from '../api/fetch';
import type { Series } from '../ui/plot';
import type { FormatFiles } from './episode_files';

export interface EpisodeSeries {
  index: number;
  frames: number;
  task_index: number;
  state: Series[];
  action: Series[];
}

interface Info {
  fps: number;
  features: Record<string, { names?: string[] | Record<string, string[]> | null }>;
}

export interface Tables {
  fps: number;
  episodes: Map<number, EpisodeSeries>;
}

interface Row {
  episode_index: bigint | number;
  task_index?: bigint | number;
  'observation.state': ArrayLike<number>;
  action: ArrayLike<number>;
}

const COLUMNS = ['episode_index', 'task_index', 'observation.state', 'action'];

function namesOf(info: Info, feature: string, width: number): string[] {
  const given = info.features[feature]?.names;
  const names = Array.isArray(given) ? given : given ? Object.values(given).flat() : [];
  return Array.from({ length: width }, (_, index) => names[index] ?? `${feature} ${index}`);
}

function seriesOf(rows: Row[], column: 'observation.state' | 'action', info: Info): Series[] {
  const width = rows[0]?.[column]?.length ?? 0;
  return namesOf(info, column, width).map((name, index) => ({ name, values: Float32Array.from(rows, (row) => row[column][index]!) }));
}

/** Reads all tables of a format. Recordings of thousands of episodes have several, of some megabytes each. */
export async function readTables(files: FormatFiles, signal: AbortSignal): Promise<Tables> {
  const info = await getJson<Info>(files.info!.url, signal);
  const byEpisode = new Map<number, Row[]>();
  for (const table of files.tables) {
    const file = await (await request(table.url, { signal })).arrayBuffer();
    for (const row of (await parquetReadObjects({ file, columns: COLUMNS })) as Row[]) {
      const index = Number(row.episode_index);
      const rows = byEpisode.get(index) ?? [];
      byEpisode.set(index, rows);
      rows.push(row);
    }
  }
  const episodes = new Map<number, EpisodeSeries>();
  for (const [index, rows] of byEpisode) {
    episodes.set(index, {
      index,
      frames: rows.length,
      task_index: Number(rows[0]!.task_index ?? 0),
      state: seriesOf(rows, 'observation.state', info),
      action: seriesOf(rows, 'action', info),
    });
  }
  return { fps: info.fps, episodes };
}

/** Series of joints among others, by the unit in their names. */
export function ofUnit(series: Series[], unit: '_rad' | '_m'): Series[] {
  return series.filter((one) => one.name.endsWith(unit));
}

/** Share of frames in which nothing of the state changes by more than a ten-thousandth. */
export function stillShare(series: Series[]): number {
  const frames = series[0]?.values.length ?? 0;
  if (frames < 2) return 1;
  let still = 0;
  for (let frame = 1; frame < frames; frame++) {
    if (series.every(({ values }) => Math.abs(values[frame]! - values[frame - 1]!) < 1e-4)) still++;
  }
  return still / (frames - 1);
}

/** Root mean square of the third difference of the joints, over the frames' time to the third. */
export function jerk(series: Series[], fps: number): number {
  let sum = 0;
  let number = 0;
  for (const { values } of series) {
    for (let frame = 3; frame < values.length; frame++) {
      const third = values[frame]! - 3 * values[frame - 1]! + 3 * values[frame - 2]! - values[frame - 3]!;
      sum += (third * fps ** 3) ** 2;
      number++;
    }
  }
  return number ? Math.sqrt(sum / number) : 0;
}
