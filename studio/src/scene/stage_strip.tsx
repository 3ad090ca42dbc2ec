/** The stages of a job as a strip, each with the image that it made. */
import type { Scene } from '../api/types';
import { count, duration } from '../format';
import { STAGE_TITLES, stageRows, type StageRow } from './stages';

const STATES: Record<StageRow['state'], string> = { waiting: 'to come', running: 'in progress', finished: 'done', failed: 'not finished' };

function detail(row: StageRow): string {
  if (row.state === 'waiting' || row.state === 'failed') return STATES[row.state];
  if (row.state === 'running') return row.parts > 1 ? `${row.finished} of ${row.parts}` : STATES.running;
  const parts = row.parts > 1 ? `${count(row.parts, 'part')}, ` : '';
  return parts + (row.cached ? 'found' : duration(row.computed_ms));
}

export function StageStrip({ scene }: { scene: Scene }) {
  const ended = ['succeeded', 'failed', 'cancelled'].includes(scene.job?.state ?? '');
  const rows = stageRows(scene.stages ?? [], scene.artifacts ?? [], ended);
  return (
    <ol class="strip" aria-label="Stages" tabIndex={0}>
      {rows.map((row) => (
        <li key={row.stage} class={row.state}>
          <span class="image">
            {row.image ? (
              <a href={row.image.url} target="_blank" rel="noreferrer">
                <img src={row.image.url} alt={`Image of the stage ${STAGE_TITLES[row.stage] ?? row.stage}`} loading="lazy" />
              </a>
            ) : (
              <span class="mark" aria-hidden="true">
                {row.state === 'finished' ? '✓' : row.state === 'failed' ? '✕' : ''}
              </span>
            )}
          </span>
          <span class="title">{STAGE_TITLES[row.stage] ?? row.stage}</span>
          <span class="detail">{detail(row)}</span>
        </li>
      ))}
    </ol>
  );
}
