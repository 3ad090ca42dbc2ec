/** Numbers over time as lines, with a cursor that is moved by pointer and keys. */
import { fixed } from '../format';

export interface Series {
  name: string;
  values: ArrayLike<number>;
}

const WIDTH = 800;
const HEIGHT = 180;
const MAX_POINTS = 500;

/** The path of a line through its values, thinned to what a screen can show. */
export function pathOf(values: ArrayLike<number>, low: number, high: number): string {
  const step = Math.max(1, Math.ceil(values.length / MAX_POINTS));
  const parts: string[] = [];
  for (let index = 0; index < values.length; index += step) {
    const x = values.length > 1 ? (index / (values.length - 1)) * WIDTH : 0;
    const y = HEIGHT - ((values[index]! - low) / (high - low || 1)) * HEIGHT;
    parts.push(`${parts.length ? 'L' : 'M'}${x.toFixed(1)} ${y.toFixed(1)}`);
  }
  return parts.join('');
}

export function rangeOf(series: Series[]): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (const { values } of series) {
    for (let index = 0; index < values.length; index++) {
      low = Math.min(low, values[index]!);
      high = Math.max(high, values[index]!);
    }
  }
  return low <= high ? [low, high] : [0, 1];
}

export function Plot({
  title,
  unit,
  series,
  duration_s,
  time_s,
  onSeek,
}: {
  title: string;
  unit: string;
  series: Series[];
  duration_s: number;
  time_s: number;
  onSeek: (time_s: number) => void;
}) {
  const [low, high] = rangeOf(series);
  const share = duration_s ? Math.min(1, time_s / duration_s) : 0;
  const seek = (event: PointerEvent) => {
    if (event.type === 'pointermove' && event.buttons !== 1) return;
    const box = (event.currentTarget as Element).getBoundingClientRect();
    onSeek(Math.min(1, Math.max(0, (event.clientX - box.left) / box.width)) * duration_s);
  };
  return (
    <figure class="plot">
      <figcaption>
        {title} <span class="hint">{unit}</span>
      </figcaption>
      <div class="frame">
        <span class="scale number" aria-hidden="true">
          <span>{fixed(high, 2)}</span>
          <span>{fixed(low, 2)}</span>
        </span>
        <svg
          viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
          preserveAspectRatio="none"
          role="img"
          aria-label={`${title} over ${fixed(duration_s, 1)} seconds`}
          onPointerDown={seek}
          onPointerMove={seek}
        >
          {low < 0 && high > 0 && (
            <line class="zero" x1={0} x2={WIDTH} y1={HEIGHT + (low / (high - low)) * HEIGHT} y2={HEIGHT + (low / (high - low)) * HEIGHT} />
          )}
          {series.map((one, index) => (
            <path key={one.name} d={pathOf(one.values, low, high)} class={`line line-${index % 8}`} />
          ))}
          <line class="cursor" x1={share * WIDTH} x2={share * WIDTH} y1={0} y2={HEIGHT} />
        </svg>
      </div>
      <ul class="legend number">
        {series.map((one, index) => (
          <li key={one.name}>
            <i class={`line-${index % 8}`} aria-hidden="true" /> {one.name}{' '}
            <b>{fixed(one.values[Math.min(one.values.length - 1, Math.round(share * (one.values.length - 1)))] ?? 0, 2)}</b>
          </li>
        ))}
      </ul>
    </figure>
  );
}
