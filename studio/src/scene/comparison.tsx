/** The reference image over the model, up to a line that is moved, with the masks of the objects. */
import { useEffect, useRef, useState } from 'preact/hooks';
import { getJson } from '../api/fetch';
import type { Scene } from '../api/types';
import { useShortcuts } from '../keys';
import { useLoad } from '../load';
import type { SceneDocument } from './documents';
import { type InstanceMask, MaskIndex } from './masks';
import { artifactUrl, fileUrl } from './scene_files';

interface Props {
  scene: Scene;
  document: SceneDocument;
  selected: string | undefined;
  onSelect: (name: string | undefined) => void;
}

/** A box of the image in percent of its sides. */
function boxOf({ camera, instances }: SceneDocument, name: string | undefined) {
  const box = instances.find((instance) => instance.name === name)?.image.bbox_px;
  if (!box) return undefined;
  const [x0, y0, x1, y1] = box;
  const [x, y] = [100 / camera.width_px, 100 / camera.height_px];
  return { left: `${x0 * x}%`, top: `${y0 * y}%`, width: `${(x1 - x0) * x}%`, height: `${(y1 - y0) * y}%` };
}

export function Comparison({ scene, document: doc, selected, onSelect }: Props) {
  const [at, setAt] = useState(50);
  const [difference, setDifference] = useState(false);
  const [pointed, setPointed] = useState<string>();
  useShortcuts([{ key: 'b', what: 'Blink between image and model', run: () => setAt((old) => (old < 50 ? 100 : 0)) }], []);
  // Edits and variants have no masks of their own; their boxes are drawn.
  const url = artifactUrl(scene, 'segment/masks.json') ?? null;
  const masks = useLoad(url, async (signal) => new MaskIndex(await getJson<InstanceMask[]>(url!, signal))).value;
  const shown = pointed ?? selected;
  const box = masks ? undefined : boxOf(doc, shown);
  const under = (event: PointerEvent | MouseEvent) => {
    const place = (event.currentTarget as HTMLElement).getBoundingClientRect();
    return masks?.at((event.clientX - place.left) / place.width, (event.clientY - place.top) / place.height);
  };
  return (
    <div class="comparison">
      <img
        src={fileUrl(scene, 'preview/reference.png')}
        alt="Reference image"
        style={difference ? { mixBlendMode: 'difference' } : { clipPath: `inset(0 ${100 - at}% 0 0)` }}
      />
      {masks && shown && <Outlined masks={masks} name={shown} />}
      {!difference && <span class="line" style={{ left: `${at}%` }} aria-hidden="true" />}
      {box && <span class="box" style={box} aria-hidden="true" />}
      {masks && (
        // The list of objects selects by keyboard what a click here selects.
        <div
          class="pointer"
          aria-hidden="true"
          data-object={pointed}
          onPointerMove={(event) => setPointed(under(event))}
          onPointerLeave={() => setPointed(undefined)}
          onClick={(event) => onSelect(under(event))}
        >
          {pointed && <span class="floating">{doc.instances.find((instance) => instance.name === pointed)?.label ?? pointed}</span>}
        </div>
      )}
      <div class="row controls">
        <span aria-hidden="true">Image</span>
        <input
          type="range"
          min={0}
          max={100}
          value={at}
          disabled={difference}
          aria-label="Share of the reference image that is shown"
          onInput={(event) => setAt(event.currentTarget.valueAsNumber)}
        />
        <span aria-hidden="true">Model</span>
        <button type="button" aria-pressed={difference} onClick={() => setDifference(!difference)}>
          Difference
        </button>
      </div>
    </div>
  );
}

/** The pixels of an object, tinted. */
function Outlined({ masks, name }: { masks: MaskIndex; name: string }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const { width, height } = masks;
    const target = canvas.current!;
    [target.width, target.height] = [width, height];
    const accent = getComputedStyle(target).color;
    const context = target.getContext('2d')!;
    context.fillStyle = accent;
    context.clearRect(0, 0, width, height);
    for (const [x, y, length] of masks.runs(name)) context.fillRect(x, y, 1, length);
  }, [masks, name]);
  return <canvas ref={canvas} class="mask" data-mask={name} aria-hidden="true" />;
}
