/** All recordings, and their progress. */
import { useEvents } from '../api/events';
import type { Recording } from '../api/types';
import { ago, count } from '../format';
import { usePaged } from '../paged';
import { partsOfRecording, RECORDING_TONES, titleOfRecording } from '../recording_parts';
import { href } from '../router';
import { Badge, Empty, Failed, More, Waiting } from '../ui/parts';
import { YieldBar } from '../ui/yield_bar';
import { words } from '../format';

export default function Recordings() {
  const list = usePaged<Recording>('/episodes', 'recordings');
  useEvents((event) => Boolean(event.recording_id), list.reload, [], 2000);
  return (
    <div class="narrow">
      <h1>Recordings</h1>
      {list.error && <Failed error={list.error} again={list.reload} />}
      {!list.ready && list.loading && <Waiting what="recordings" />}
      {list.ready && list.items.length === 0 && (
        <Empty>
          There are no recordings yet. Open a scene of the <a href={href('/gallery?verdict=pass')}>gallery</a>, and record a task on its
          page “Robot”.
        </Empty>
      )}
      <ul class="rows">
        {list.items.map((recording) => (
          <li key={recording.id} class="card">
            <div class="row">
              <a class="strong" href={href(`/recordings/${recording.id}`)}>
                {titleOfRecording(recording)}
              </a>
              <Badge tone={RECORDING_TONES[recording.state]}>{words(recording.state)}</Badge>
              <span class="spring" />
              <span class="hint">
                {recording.dataset
                  ? `${count(recording.dataset.episodes, 'episode')}, ${count(recording.dataset.frames, 'frame')}`
                  : `${recording.progress.successes} of ${recording.progress.wanted}`}
              </span>
              <time class="hint" dateTime={recording.created_at}>
                {ago(recording.created_at)}
              </time>
            </div>
            <YieldBar parts={partsOfRecording(recording)} label="Attempts" />
          </li>
        ))}
      </ul>
      <More token={list.next} busy={list.loading} load={list.more} />
    </div>
  );
}
