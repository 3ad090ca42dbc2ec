/** Replay of what the certificate saw: the scene under gravity, from its poses or from those that were found first. */
import { useEffect, useState } from 'preact/hooks';
import { getJson } from '../api/fetch';
import { length } from '../format';
import { useLoad } from '../load';
import { ClockBar, useClock } from '../ui/clock';
import { farthest, posesAt, type Track, type Tracks } from './track';
import type { Viewer } from './viewer';

export function ReplayPanel({ url, viewer }: { url: string; viewer: Viewer }) {
  const { value: tracks, error } = useLoad(url, (signal) => getJson<Tracks>(url, signal));
  const [aligned, setAligned] = useState(false);
  if (error) {
    return (
      <p class="notice bad" role="alert">
        The replay did not load: {error.message}
      </p>
    );
  }
  if (!tracks) {
    return (
      <p class="waiting" role="status">
        <span class="spinner" aria-hidden="true" /> Loading the replay…
      </p>
    );
  }
  const track = (aligned && tracks.from_aligned) || tracks.from_shipped;
  return (
    <div class="physics" aria-label="Replay" role="group">
      <div class="row">
        <button type="button" aria-pressed={!aligned} onClick={() => setAligned(false)}>
          From the finished poses
        </button>
        {tracks.from_aligned && (
          <button type="button" aria-pressed={aligned} onClick={() => setAligned(true)}>
            From the poses of the image
          </button>
        )}
      </div>
      <Player key={String(aligned)} track={track} rate_hz={tracks.rate_hz} duration_s={tracks.duration_s} viewer={viewer} />
    </div>
  );
}

function Player({ track, rate_hz, duration_s, viewer }: { track: Track; rate_hz: number; duration_s: number; viewer: Viewer }) {
  const clock = useClock(duration_s, 1 / rate_hz);
  const names = Object.keys(track);
  useEffect(() => viewer.setPoses(names, posesAt(track, names, rate_hz, clock.time_s)), [clock.time_s]);
  useEffect(() => () => viewer.resetPoses(), []);
  return (
    <>
      <ClockBar clock={clock} duration_s={duration_s} />
      <p class="hint" data-farthest={farthest(track)}>
        {names.length === 0
          ? 'This simulation diverged, so there is nothing to show.'
          : `Nothing moves farther than ${length(farthest(track))} in this simulation.`}
      </p>
    </>
  );
}
