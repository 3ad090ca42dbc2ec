/** Results of a batch in the order in which a bar shows them. */
import type { Batch } from './api/types';
import type { Part } from './ui/yield_bar';

export function partsOfBatch(counts: Batch['request_counts']): Part[] {
  return [
    { name: 'passed', number: counts.succeeded, tone: 'good' },
    { name: 'quarantined', number: counts.quarantined, tone: 'warn' },
    { name: 'failed', number: counts.failed + counts.invalid, tone: 'bad' },
    { name: 'canceled', number: counts.cancelled, tone: 'bad' },
    { name: 'running', number: counts.running, tone: 'busy' },
    { name: 'waiting', number: counts.pending, tone: 'plain' },
    { name: 'duplicates', number: counts.duplicate, tone: 'plain' },
  ];
}

/** Passed scenes over those that came to their end; undefined before the first. */
export function yieldOf(counts: Batch['request_counts']): number | undefined {
  const ended = counts.succeeded + counts.quarantined + counts.failed;
  return ended > 0 ? counts.succeeded / ended : undefined;
}

/** A recipe from the form: a sentence per line, and lines such as `color: red, blue` for its slots. */
export function recipeOf(templates: string, slots: string, firstSeed: number, seeds: number): Record<string, unknown> {
  const lines = (text: string) =>
    text
      .split('\n')
      .map((line) => line.trim())
      .filter(Boolean);
  const values = lines(slots).map((line) => {
    const at = line.indexOf(':');
    if (at < 1) throw new Error(`“${line}” is no slot: write its name, a colon and its values, such as color: red, blue.`);
    return [
      line.slice(0, at).trim(),
      line
        .slice(at + 1)
        .split(',')
        .map((value) => value.trim())
        .filter(Boolean),
    ] as const;
  });
  return {
    templates: lines(templates),
    ...(values.length > 0 && { slots: Object.fromEntries(values) }),
    seeds: { first: firstSeed, count: seeds },
  };
}

/** Number of requests of a recipe: templates, times values of the slots that each uses, times seeds. */
export function sizeOf(recipe: Record<string, unknown>): number {
  const { templates, slots = {}, seeds } = recipe as { templates: string[]; slots?: Record<string, string[]>; seeds: { count: number } };
  const texts = templates.reduce((sum, template) => {
    const used = Object.keys(slots).filter((name) => template.includes(`{${name}}`));
    return sum + used.reduce((product, name) => product * slots[name]!.length, 1);
  }, 0);
  return texts * seeds.count;
}
