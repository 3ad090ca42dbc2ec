/** Stages over time: where a job spent its time. */
import type { Stage } from '../api/types';
import { STAGES } from './stages';

export interface Span {
  /** Share of the width where it begins, and its own share, 0 to 1. */
  from: number;
  width: number;
  instance?: string | undefined;
  elapsed_ms: number;
  cached: boolean;
  runs: number;
}

export interface TimelineRow {
  stage: string;
  spans: Span[];
  computed_ms: number;
}

export interface Timeline {
  rows: TimelineRow[];
  /** From the first start to the last end, without idle gaps that are folded. */
  shown_ms: number;
  /** Idle gaps: where they stand, and how long they are. */
  gaps: { at: number; ms: number }[];
}

/** Idle times that are longer than this, and than a fifth of the rest, are folded. */
const MIN_GAP_MS = 1000;

export function timelineOf(stages: Stage[]): Timeline {
  const timed = stages
    .map((stage) => {
      const start = Date.parse(stage.started_at);
      // A result that was found took no time in this job.
      return { stage, start, end: start + (stage.cached ? 0 : (stage.elapsed_ms ?? 0)) };
    })
    .sort((a, b) => a.start - b.start);
  if (!timed.length) return { rows: [], shown_ms: 0, gaps: [] };
  const busy: [number, number][] = [];
  for (const { start, end } of timed) {
    const last = busy.at(-1);
    if (last && start <= last[1]) last[1] = Math.max(last[1], end);
    else busy.push([start, end]);
  }
  const total = busy.reduce((sum, [start, end]) => sum + end - start, 0);
  const folded: { at: number; ms: number }[] = [];
  for (let index = 1; index < busy.length; index++) {
    const ms = busy[index]![0] - busy[index - 1]![1];
    if (ms > Math.max(MIN_GAP_MS, total / 5)) folded.push({ at: busy[index]![0], ms });
  }
  const origin = busy[0]![0];
  const place = (time: number) => time - origin - folded.filter((gap) => gap.at <= time).reduce((sum, gap) => sum + gap.ms, 0);
  const shown = Math.max(1, place(Math.max(...timed.map((one) => one.end))));
  const order = (name: string) => (STAGES.includes(name) ? STAGES.indexOf(name) : -1);
  const names = [...new Set(timed.map((one) => one.stage.stage))].sort((a, b) => order(a) - order(b));
  return {
    shown_ms: shown,
    gaps: folded.map((gap) => ({ at: place(gap.at) / shown, ms: gap.ms })),
    rows: names.map((name) => {
      const spans = timed
        .filter((one) => one.stage.stage === name)
        .map(({ stage, start, end }) => ({
          from: place(start) / shown,
          width: (end - start) / shown,
          instance: stage.instance,
          elapsed_ms: stage.elapsed_ms ?? 0,
          cached: stage.cached,
          runs: stage.runs,
        }));
      return { stage: name, spans, computed_ms: spans.reduce((sum, span) => sum + (span.cached ? 0 : span.elapsed_ms), 0) };
    }),
  };
}
