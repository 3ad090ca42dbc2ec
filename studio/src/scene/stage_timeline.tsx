/** The timeline of stages as bars, and the calls of remote models. */
import { useState } from 'preact/hooks';
import { sendJson } from '../api/fetch';
import type { Scene } from '../api/types';
import { count, duration, significant } from '../format';
import { may } from '../session';
import { announce } from '../ui/announce';
import { StageStrip } from './stage_strip';
import { STAGE_TITLES } from './stages';
import { timelineOf } from './timeline';
import { isOver } from './title';

export function StageTimeline({ scene, onChange }: { scene: Scene; onChange: () => void }) {
  const { rows, shown_ms, gaps } = timelineOf(scene.stages ?? []);
  const { spending } = scene;
  return (
    <div class="timeline">
      <StageStrip scene={scene} />
      <p class="hint">
        {duration(shown_ms)} from the first to the last stage
        {gaps.length > 0 && `, without ${count(gaps.length, 'idle gap')} of ${duration(gaps.reduce((sum, gap) => sum + gap.ms, 0))}`}. A
        thin line is a result that was found, not computed.
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
      <AgainFrom scene={scene} onChange={onChange} />
      {spending && spending.calls.length > 0 && (
        <p>
          {count(spending.calls.length, 'call')} of remote models for {significant(spending.spent_usd)} of{' '}
          {significant(spending.budget_usd)} USD.
        </p>
      )}
    </div>
  );
}

/** Runs a scene again from a stage on; stages before it are found, not computed. A scene that is ready stays as it is. */
export function AgainFrom({ scene, onChange }: { scene: Scene; onChange: () => void }) {
  const names = [...new Set((scene.stages ?? []).map((stage) => stage.stage))];
  const [from, setFrom] = useState('');
  if (!scene.job || scene.state !== 'failed' || !isOver(scene) || !may('submit') || !names.length) return null;
  const send = async (event: Event) => {
    event.preventDefault();
    try {
      await sendJson('POST', `/jobs/${scene.job!.id}/retry`, { from_stage: from || names[0] });
      onChange();
    } catch (refused) {
      announce((refused as Error).message, 'bad');
    }
  };
  return (
    <form class="row" onSubmit={send}>
      <label class="inline">
        Compute again from
        <select value={from || names[0]} onChange={(event) => setFrom(event.currentTarget.value)}>
          {names.map((name) => (
            <option key={name} value={name}>
              {STAGE_TITLES[name] ?? name}
            </option>
          ))}
        </select>
      </label>
      <button type="submit">Run again</button>
    </form>
  );
}
