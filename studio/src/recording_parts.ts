/** A recording in words, and its attempts by outcome. */
import type { Recording } from './api/types';
import { short } from './format';
import type { Tone } from './ui/parts';
import type { Part } from './ui/yield_bar';

export const RECORDING_TONES: Record<Recording['state'], Tone> = {
  queued: 'busy',
  running: 'busy',
  finished: 'good',
  failed: 'bad',
  cancelled: 'bad',
};

export function titleOfRecording(recording: Pick<Recording, 'id' | 'order'>): string {
  const { title, task, tasks } = recording.order;
  const first = task ?? tasks?.[0];
  const text = typeof first === 'string' ? first : first?.instruction;
  const more = tasks && tasks.length > 1 ? ` and ${tasks.length - 1} more` : '';
  return title ?? (text ? text + more : `Recording ${short(recording.id)}`);
}

export function partsOfRecording(recording: Pick<Recording, 'attempts'>): Part[] {
  return Object.entries(recording.attempts)
    .sort(([a], [b]) => (a === 'success' ? -1 : b === 'success' ? 1 : a.localeCompare(b)))
    .map(([outcome, number]) => ({
      name: outcome === 'success' ? 'succeeded' : outcome.replaceAll('_', ' '),
      number,
      tone: outcome === 'success' ? 'good' : 'bad',
    }));
}

/** Episodes whose length is far from the median: beyond four times the median deviation, and beyond a fifth. */
export function outliers(lengths: number[]): Set<number> {
  const median = (values: number[]) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)] ?? 0;
  const center = median(lengths);
  const spread = median(lengths.map((one) => Math.abs(one - center)));
  const limit = Math.max(4 * spread, center / 5);
  return new Set(lengths.flatMap((one, index) => (Math.abs(one - center) > limit ? [index] : [])));
}
