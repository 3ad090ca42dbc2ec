/** A recording: its progress, and its episodes with video and joints on one clock. */
import { useEffect, useRef } from 'preact/hooks';
import { useEvents } from '../api/events';
import { getJson, sendJson, withQuery } from '../api/fetch';
import type { DatasetFile, Recording, RecordingFilePage } from '../api/types';
import { bytes, count, duration, fixed, percent, significant, words } from '../format';
import { useShortcuts } from '../keys';
import { useLoad } from '../load';
import { type EpisodeFiles, formatsOf } from '../recording/episode_files';
import { jerk, ofUnit, readTables, stillShare, type Tables } from '../recording/episode_tables';
import { outliers, partsOfRecording, RECORDING_TONES, titleOfRecording } from '../recording_parts';
import { address, href, setQuery } from '../router';
import { may } from '../session';
import { announce } from '../ui/announce';
import { ClockBar, useClock } from '../ui/clock';
import { Absent, Badge, Failed, Waiting } from '../ui/parts';
import { Plot } from '../ui/plot';
import { YieldBar } from '../ui/yield_bar';

/** Files that the page lists; a format has a few files per episode. */
const MAX_FILES = 2000;

async function filesOf(id: string, signal: AbortSignal): Promise<DatasetFile[]> {
  const files: DatasetFile[] = [];
  let token: string | null = null;
  do {
    const page: RecordingFilePage = await getJson(withQuery(`/episodes/${id}/files`, { page_size: 200, page_token: token }), signal);
    files.push(...page.files);
    token = page.next_page_token;
  } while (token && files.length < MAX_FILES);
  return files;
}

export default function RecordingPage({ id }: { id: string }) {
  const path = `/episodes/${id}`;
  const recording = useLoad(path, (signal) => getJson<Recording>(path, signal));
  useEvents((event) => event.recording_id === id, recording.reload, [id], 500);
  const finished = recording.value?.state === 'finished';
  const files = useLoad(finished ? `${path} files` : null, (signal) => filesOf(id, signal));
  if (!recording.value)
    return recording.error ? <Absent title="Recording" error={recording.error} again={recording.reload} /> : <Waiting what="the recording" />;
  const { value } = recording;
  const { progress } = value;
  const over = ['finished', 'failed', 'cancelled'].includes(value.state);
  const cancel = async () => {
    try {
      await sendJson('POST', value.links.cancel);
      recording.reload();
    } catch (refused) {
      announce((refused as Error).message, 'bad');
    }
  };
  return (
    <div class="narrow wide">
      <h1>{titleOfRecording(value)}</h1>
      <div class="row">
        <Badge tone={RECORDING_TONES[value.state]}>{words(value.state)}</Badge>
        <span class="hint">
          {value.order.robot ?? 'panda'};{' '}
          {value.dataset
            ? `${count(value.dataset.episodes, 'episode')}, ${count(value.dataset.frames, 'frame')}`
            : `${progress.successes} of ${count(progress.wanted, 'episode')}`}
          {progress.success_rate !== null && `; ${percent(progress.success_rate)} of the attempts succeeded`}
          {progress.seconds_left !== null && `; about ${duration(progress.seconds_left * 1000)} left`}
        </span>
        <a href={href(`/scenes/${value.scene_id}?tab=tasks`)}>Scene</a>
        <span class="spring" />
        {!over && may('submit') && (
          <button type="button" onClick={() => void cancel()}>
            Cancel
          </button>
        )}
        {value.dataset?.formats.map((format) => (
          <a
            class="button"
            key={format.format}
            href={format.archive}
            download
            title={`${count(format.files, 'file')}, SHA-256 ${format.sha256 ?? ''}`}
          >
            {format.format}, {bytes(format.size)}
          </a>
        ))}
      </div>
      {value.failure && <p class="notice bad">{value.failure.message}</p>}
      <YieldBar parts={partsOfRecording(value)} label="Attempts" />
      {files.error && <Failed error={files.error} again={files.reload} />}
      {finished && !files.value && !files.error && <Waiting what="the episodes" />}
      {files.value && <Episodes files={files.value} />}
    </div>
  );
}

function Episodes({ files }: { files: DatasetFile[] }) {
  const formats = formatsOf(files);
  const format = formats.find((one) => one.info && one.tables.length && one.episodes[0]?.video) ?? formats[0];
  const tables = useLoad(format?.info && format.tables.length ? format.tables.map((table) => table.sha256).join() : null, (signal) =>
    readTables(format!, signal),
  );
  const chosen = Number(address.value.query.get('episode') ?? 0);
  const current = format?.episodes[chosen];
  const choose = (index: number) => setQuery({ episode: index ? String(index) : '', t: '' });
  useShortcuts(
    [
      { key: 'n', what: 'Next episode', run: () => choose(Math.min(chosen + 1, (format?.episodes.length ?? 1) - 1)) },
      { key: 'b', what: 'Episode before', run: () => choose(Math.max(chosen - 1, 0)) },
    ],
    [chosen, format?.episodes.length],
  );
  if (!format) return <p class="hint">The files of this recording have no images of its episodes; download the archive.</p>;
  const lengths = format.episodes.map((episode) => tables.value?.episodes.get(episode.index)?.frames ?? 0);
  const far = tables.value ? outliers(lengths) : new Set<number>();
  return (
    <>
      {tables.error && <Failed error={tables.error} again={tables.reload} />}
      {current && <Player key={current.index} episode={current} tables={tables.value} />}
      <section aria-label="Episodes">
        <h2>Episodes</h2>
        <p class="hint">First to last frame of each. Marked are those of an unusual length, and those in which little moves.</p>
        <ul class="sheet">
          {format.episodes.map((episode, index) => {
            const series = tables.value?.episodes.get(episode.index);
            const still = series ? stillShare(ofUnit(series.state, '_rad')) : 0;
            return (
              <li key={episode.index}>
                <button type="button" aria-pressed={index === chosen} onClick={() => choose(index)}>
                  <span class="row">
                    <b class="number">{episode.index}</b>
                    {series && tables.value && <span class="hint number">{fixed(series.frames / tables.value.fps, 1)} s</span>}
                    {far.has(index) && <Badge tone="warn">unusual length</Badge>}
                    {still > 0.5 && <Badge tone="warn">still {percent(still)}</Badge>}
                    {series && tables.value && (
                      <span class="hint number">jerk {significant(jerk(ofUnit(series.state, '_rad'), tables.value.fps), 2)} rad/s³</span>
                    )}
                  </span>
                  {episode.strips.slice(0, 1).map((strip) => (
                    <img
                      key={strip.camera}
                      src={strip.file.url}
                      alt={`Frames of episode ${episode.index}, camera ${strip.camera}`}
                      loading="lazy"
                    />
                  ))}
                </button>
              </li>
            );
          })}
        </ul>
      </section>
    </>
  );
}

/** A video that stands where the clock stands, or plays along with it. */
function ClockedVideo({ file, time_s, playing, label }: { file: DatasetFile; time_s: number; playing: boolean; label: string }) {
  const element = useRef<HTMLVideoElement>(null);
  useEffect(() => {
    const video = element.current;
    if (!video) return;
    if (playing) void video.play().catch(() => {});
    else video.pause();
  }, [playing]);
  useEffect(() => {
    const video = element.current;
    // While it plays, only a lag that can be seen is corrected: each seek costs a key frame.
    if (video && Math.abs(video.currentTime - time_s) > (playing ? 0.15 : 0.005)) video.currentTime = time_s;
  }, [time_s, playing]);
  return <video ref={element} src={file.url} muted playsInline preload="auto" aria-label={label} />;
}

function Player({ episode, tables }: { episode: EpisodeFiles; tables: Tables | undefined }) {
  const series = tables?.episodes.get(episode.index);
  const fps = tables?.fps ?? 15;
  const duration_s = series ? series.frames / fps : 10;
  const clock = useClock(duration_s, 1 / fps);
  const cameras = episode.strips.map((strip) => strip.camera);
  return (
    <section class="card stack player" aria-label={`Episode ${episode.index}`}>
      {episode.video ? (
        <figure>
          <ClockedVideo
            file={episode.video}
            time_s={clock.time_s}
            playing={clock.playing}
            label={`Episode ${episode.index}, cameras ${cameras.join(', ')}`}
          />
          <figcaption class="hint">{cameras.join(' · ')}</figcaption>
        </figure>
      ) : (
        episode.strips.map((strip) => <img key={strip.camera} src={strip.file.url} alt={`Frames of the camera ${strip.camera}`} />)
      )}
      <ClockBar clock={clock} duration_s={duration_s} />
      {series ? (
        <div class="plots">
          {(
            [
              ['Joints, measured', 'rad', ofUnit(series.state, '_rad')],
              ['Joints, commanded', 'rad', ofUnit(series.action, '_rad')],
            ] as const
          )
            .filter(([, , list]) => list.length > 0)
            .map(([title, unit, list]) => (
              <Plot
                key={title}
                title={title}
                unit={unit}
                series={list.map((one) => ({ ...one, name: one.name.replace(/_rad$/, '') })).slice(0, 8)}
                duration_s={duration_s}
                time_s={clock.time_s}
                onSeek={clock.seek}
              />
            ))}
        </div>
      ) : (
        <p class="hint">{tables ? 'This episode has no table.' : 'Joints are shown for LeRobot formats.'}</p>
      )}
    </section>
  );
}
