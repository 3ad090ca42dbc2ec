/** Parts of a text by the meaning that the server found in them. */
import type { TextAccount } from './api/types';

export interface TextPart {
  text: string;
  kind: 'plain' | 'understood' | 'unrecognized';
}

/** Offsets in UTF-16 units by offsets in bytes of UTF-8; `result[byte]` is defined at starts of characters. */
function unitsByByte(text: string): number[] {
  const units: number[] = [];
  let byte = 0;
  let unit = 0;
  for (const character of text) {
    units[byte] = unit;
    const point = character.codePointAt(0)!;
    byte += point < 0x80 ? 1 : point < 0x800 ? 2 : point < 0x10000 ? 3 : 4;
    unit += character.length;
  }
  units[byte] = unit;
  return units;
}

/** Splits `text` at the spans of its account. Spans that do not fit the text are left out: it has changed since. */
export function partsOf(text: string, account: TextAccount | null): TextPart[] {
  if (!account) return [{ text, kind: 'plain' }];
  const units = unitsByByte(text);
  const marks = [
    ...account.understood.map((part) => ({ ...part.span, kind: 'understood' as const })),
    ...account.unrecognized.map((part) => ({ ...part.span, kind: 'unrecognized' as const })),
  ]
    .map((span) => ({ start: units[span.start], end: units[span.end], text: span.text, kind: span.kind }))
    .filter((mark) => mark.start !== undefined && mark.end !== undefined && text.slice(mark.start, mark.end) === mark.text)
    .sort((a, b) => a.start! - b.start!);
  const parts: TextPart[] = [];
  let at = 0;
  for (const mark of marks) {
    if (mark.start! < at) continue;
    if (mark.start! > at) parts.push({ text: text.slice(at, mark.start), kind: 'plain' });
    parts.push({ text: mark.text, kind: mark.kind });
    at = mark.end!;
  }
  if (at < text.length) parts.push({ text: text.slice(at), kind: 'plain' });
  return parts;
}

const REASONS: Record<string, string> = {
  unknown_object: 'the catalog has no such object',
  unknown_word: 'unknown word',
  not_placeable: 'cannot stand on a table',
  out_of_range: 'out of the range that is supported',
  not_supported: 'not supported',
  contradiction: 'contradicts another part',
  no_referent: 'refers to nothing in the text',
  not_expressible: 'cannot be expressed in a scene',
  not_in_image: 'not in the image',
  shown_by_image: 'the image decides this',
};

/** Why a part of the text has no effect, in words. */
export function reasonInWords(reason: string): string {
  return REASONS[reason] ?? reason.replaceAll('_', ' ');
}
