/** One clock for all that is played: play, pause, seek, and single frames. */
import { useEffect, useRef, useState } from 'preact/hooks';
import { fixed } from '../format';
import { useShortcuts } from '../keys';
import { address, setQuery } from '../router';

export interface Clock {
  time_s: number;
  playing: boolean;
  seek: (time_s: number) => void;
  toggle: () => void;
}

/** A clock from 0 to `duration_s`; it begins at `?t=` of the address. */
export function useClock(duration_s: number, frame_s: number): Clock {
  const [time_s, setTime] = useState(() => Number(address.value.query.get('t')) || 0);
  const [playing, setPlaying] = useState(false);
  const at = useRef(time_s);
  const seek = (wanted: number) => {
    at.current = Math.min(Math.max(0, wanted), duration_s);
    setTime(at.current);
  };
  const toggle = () => {
    if (!playing && at.current >= duration_s - frame_s / 2) seek(0);
    setPlaying(!playing);
  };
  useEffect(() => {
    if (!playing) {
      setQuery({ t: at.current ? fixed(at.current, 2) : '' });
      return;
    }
    let last = performance.now();
    let frame = 0;
    const turn = (now: number) => {
      at.current = Math.min(duration_s, at.current + (now - last) / 1000);
      last = now;
      setTime(at.current);
      if (at.current >= duration_s) setPlaying(false);
      else frame = requestAnimationFrame(turn);
    };
    frame = requestAnimationFrame(turn);
    return () => cancelAnimationFrame(frame);
  }, [playing, duration_s]);
  useShortcuts(
    [
      { key: ' ', what: 'Play or pause', run: toggle },
      { key: 'ArrowRight', what: 'One second on', run: () => seek(at.current + 1) },
      { key: 'ArrowLeft', what: 'One second back', run: () => seek(at.current - 1) },
      { key: '.', what: 'One frame on', run: () => seek(at.current + frame_s) },
      { key: ',', what: 'One frame back', run: () => seek(at.current - frame_s) },
    ],
    [playing, duration_s, frame_s],
  );
  return { time_s, playing, seek, toggle };
}

export function ClockBar({ clock, duration_s }: { clock: Clock; duration_s: number }) {
  return (
    <div class="row clock">
      <button type="button" onClick={clock.toggle}>
        {clock.playing ? 'Pause' : 'Play'}
      </button>
      <input
        type="range"
        min={0}
        max={duration_s}
        step={0.01}
        value={clock.time_s}
        aria-label="Time in seconds"
        onInput={(event) => clock.seek(event.currentTarget.valueAsNumber)}
      />
      <span class="number hint">
        {fixed(clock.time_s, 2)} of {fixed(duration_s, 2)} s
      </span>
    </div>
  );
}
