/** Masks of the objects in the reference image: uncompressed COCO run lengths. */

export interface InstanceMask {
  id: string;
  visible: {
    /** Height, then width. */
    size: [number, number];
    /** Runs down the columns, the columns from the left, of background and object in turn. */
    counts: number[];
  };
}

/** A part of a column: x, y of its first pixel, and its length. */
export type Run = [x: number, y: number, length: number];

/** The objects by their pixels. */
export class MaskIndex {
  readonly width: number;
  readonly height: number;
  readonly #runs = new Map<string, Run[]>();

  constructor(masks: InstanceMask[]) {
    [this.height, this.width] = masks[0]?.visible.size ?? [1, 1];
    for (const { id, visible } of masks) this.#runs.set(id, columns(visible.counts, this.height));
  }

  runs(name: string): Run[] {
    return this.#runs.get(name) ?? [];
  }

  /** The object at a place, in shares of width and height. */
  at(x: number, y: number): string | undefined {
    const [column, row] = [Math.floor(x * this.width), Math.floor(y * this.height)];
    for (const [name, runs] of this.#runs) {
      if (runs.some(([at, top, length]) => at === column && row >= top && row < top + length)) return name;
    }
    return undefined;
  }
}

/** Runs of the object, cut where columns end. */
function columns(counts: number[], height: number): Run[] {
  const runs: Run[] = [];
  let at = 0;
  counts.forEach((count, index) => {
    const end = at + count;
    if (index % 2 === 1) {
      for (let from = at; from < end; ) {
        const y = from % height;
        const length = Math.min(height - y, end - from);
        runs.push([(from - y) / height, y, length]);
        from += length;
      }
    }
    at = end;
  });
  return runs;
}
