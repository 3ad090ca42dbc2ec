/** Files of a recording by what they show. */
import type { DatasetFile } from '../api/types';

export interface EpisodeFiles {
  index: number;
  video?: DatasetFile;
  /** Frames of a camera side by side, from the first to the last. */
  strips: { camera: string; file: DatasetFile }[];
}

export interface FormatFiles {
  format: string;
  episodes: EpisodeFiles[];
  info?: DatasetFile;
  /** Tables with the numbers of all episodes. */
  tables: DatasetFile[];
}

/** The files of each format; paths begin with its name. */
export function formatsOf(files: DatasetFile[]): FormatFiles[] {
  const formats = new Map<string, FormatFiles & { byIndex: Map<number, EpisodeFiles> }>();
  for (const file of files) {
    const [format = '', ...rest] = file.path.split('/');
    const path = rest.join('/');
    const entry: FormatFiles & { byIndex: Map<number, EpisodeFiles> } = formats.get(format) ?? {
      format,
      episodes: [],
      tables: [],
      byIndex: new Map(),
    };
    formats.set(format, entry);
    const strip = /^strips\/chunk-\d+\/episode_(\d+)(?:_(.+)\.png|\.mp4)$/.exec(path);
    if (strip) {
      const index = Number(strip[1]);
      const episode = entry.byIndex.get(index) ?? { index, strips: [] };
      entry.byIndex.set(index, episode);
      if (strip[2]) episode.strips.push({ camera: strip[2], file });
      else episode.video = file;
    } else if (path === 'meta/info.json') entry.info = file;
    else if (/^data\/.*\.parquet$/.test(path)) entry.tables.push(file);
  }
  return [...formats.values()]
    .map(({ byIndex, ...format }) => ({ ...format, episodes: [...byIndex.values()].sort((a, b) => a.index - b.index) }))
    .filter((format) => format.episodes.length > 0);
}
