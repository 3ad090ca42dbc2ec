/** The timeline of stages as bars, and the calls of remote models. */
import type { Scene } from '../api/types';
import { count, duration, significant } from '../format';
import { StageStrip } from './stage_strip';
import { STAGE_TITLES } from './stages';
import { timelineOf } from './timeline';

export function StageTimeline({ scene }: { scene: Scene }) {
  const { rows, shown_ms, gaps } = timelineOf(scene.stages ?? []);
  const { spending } = scene;
  return (
    <div class="timeline">
      <StageStrip scene={scene} />
      <p class="hint">
        {duration(shown_ms)} from the first to the last stage
        {gaps.length > 0 && `, without ${count(gaps.length, 'idle gap')} of ${duration(gaps.reduce((sum, gap) => sum + gap.ms, 0))}`}. A thin line is a result that was found, not computed.
      </p>
      <ol>
        {rows.map((row) => (
          <li key={row.stage}>
            <span class="title">{STAGE_TITLES[row.stage] ?? row.stage}</span>
            <span class="lane" role="img" aria-label={`${count(row.spans.length, 'part')}, computed for ${duration(row.computed_ms)}`}>
              {row.spans.map((span, index) => (
                <span
                  key={index}
                  class={span.cached ? 'cached' : span.runs > 1 ? 'retried' : ''}
                  title={`${span.instance ?? STAGE_TITLES[row.stage] ?? row.stage}: ${span.cached ? 'found' : duration(span.elapsed_ms)}${span.runs > 1 ? `, run ${span.runs} times` : ''}`}
                  style={{ left: `${span.from * 100}%`, width: `${span.width * 100}%` }}
                />
              ))}
              {gaps.map((gap, index) => (
                <i key={index} style={{ left: `${gap.at * 100}%` }} />
              ))}
            </span>
            <span class="number hint">{row.spans.every((span) => span.cached) ? 'found' : duration(row.computed_ms)}</span>
          </li>
        ))}
      </ol>
      {spending && spending.calls.length > 0 && (
        <p>
          {count(spending.calls.length, 'call')} of remote models for {significant(spending.spent_usd)} of {significant(spending.budget_usd)} USD.
        </p>
      )}
    </div>
  );
}
