/** The viewer with its controls: camera, ruler, hulls, comparison with the reference image, and physics. */
import { useEffect, useRef, useState } from 'preact/hooks';
import type { Scene } from '../api/types';
import { length } from '../format';
import { useShortcuts } from '../keys';
import type { FromPhysics } from '../physics/messages';
import { Physics } from '../physics/physics';
import { address } from '../router';
import { announce } from '../ui/announce';
import type { SceneDocument } from './documents';
import { bundleUrl, fileUrl, hullUrls } from './scene_files';
import { type Label, Viewer } from './viewer';

interface Props {
  scene: Scene;
  document: SceneDocument;
  selected: string | undefined;
  accused: Set<string>;
  onSelect: (name: string | undefined) => void;
  /** Bodies of the parent to show as glass. */
  ghosts: { scene: Scene; names: Set<string> } | undefined;
}

type Mode = 'view' | 'measure' | 'compare' | 'physics';

export function ViewerPanel({ scene, document: doc, selected, accused, onSelect, ghosts }: Props) {
  const host = useRef<HTMLDivElement>(null);
  const viewer = useRef<Viewer>(undefined);
  const [state, setState] = useState<'loading' | 'ready' | 'no-webgl' | string>('loading');
  const [labels, setLabels] = useState<Label[]>([]);
  const [mode, setMode] = useState<Mode>('view');
  const [grid, setGrid] = useState(false);
  const [hulls, setHulls] = useState(false);
  const [apart, setApart] = useState(0);
  const pick = useRef(onSelect);
  pick.current = onSelect;

  useEffect(() => {
    let made: Viewer;
    try {
      made = new Viewer(host.current!, address.value.query.get('light') === 'plain');
    } catch {
      setState('no-webgl');
      return;
    }
    viewer.current = made;
    made.onPick = (name) => pick.current(name);
    made.onLabels = setLabels;
    made.load(doc, fileUrl(scene, 'glb/scene.glb')).then(
      () => setState('ready'),
      (error: Error) => setState(`The model did not load: ${error.message}`),
    );
    return () => {
      viewer.current = undefined;
      made.dispose();
    };
  }, [doc.id]);

  const ready = state === 'ready';
  useEffect(() => viewer.current?.select(selected), [selected, ready]);
  useEffect(() => viewer.current?.accuse(accused), [accused, ready]);
  useEffect(() => viewer.current?.showGrid(grid), [grid, ready]);
  useEffect(() => viewer.current?.measure(mode === 'measure'), [mode, ready]);
  useEffect(() => viewer.current?.lock(mode === 'compare'), [mode, ready]);
  useEffect(() => {
    if (mode !== 'compare') viewer.current?.showGrid(grid);
  }, [mode]);
  useEffect(() => {
    if (!ready) return;
    if (hulls)
      viewer.current?.showHulls(hullUrls(scene)).catch((error: Error) => announce(`The hulls did not load: ${error.message}`, 'bad'));
    else viewer.current?.hideHulls();
  }, [hulls, ready]);
  useEffect(() => viewer.current?.explode(apart), [apart]);
  useEffect(() => {
    if (!ready) return;
    if (ghosts)
      viewer.current
        ?.showGhosts(fileUrl(ghosts.scene, 'glb/scene.glb'), ghosts.names)
        .catch((error: Error) => announce(`The parent did not load: ${error.message}`, 'bad'));
    else viewer.current?.hideGhosts();
  }, [ghosts, ready]);

  const toggle = (wanted: Mode) => setMode((old) => (old === wanted ? 'view' : wanted));
  useShortcuts(
    [
      { key: '0', what: 'View from the camera of the image', run: () => viewer.current?.referenceView() },
      { key: 't', what: 'View from above', run: () => viewer.current?.topView() },
      { key: 'm', what: 'Measure between two points', run: () => toggle('measure') },
      { key: 'k', what: 'Grid and ruler in centimeters', run: () => setGrid((old) => !old) },
      { key: 'h', what: 'Collision hulls', run: () => setHulls((old) => !old) },
      { key: 'i', what: 'Compare with the reference image', run: () => toggle('compare') },
      { key: 'p', what: 'Physics', run: () => toggle('physics') },
    ],
    [],
  );

  const { width_px, height_px } = doc.camera;
  const anyHulls = hullUrls(scene).size > 0;
  const wide = width_px / height_px;
  return (
    <section class="viewer card" aria-label="Viewer">
      <div class="stage" style={{ aspectRatio: String(wide), maxWidth: `calc(70vh * ${wide})` }}>
        {state === 'no-webgl' ? (
          <figure class="fallback">
            <img src={fileUrl(scene, 'preview/hero.png')} alt="The finished scene" />
            <figcaption class="notice">This browser has no WebGL, so here is an image instead of the model.</figcaption>
          </figure>
        ) : (
          <>
            <div
              ref={host}
              class="canvas"
              role="img"
              aria-label={`Model of the scene with ${doc.instances.length} objects. The list of objects beside it has the same content.`}
            />
            {state === 'loading' && <p class="over">Loading the model…</p>}
            {state !== 'loading' && !ready && <p class="over notice bad">{state}</p>}
            <div class="labels" aria-hidden="true">
              {labels.map((label, index) => label.at && <Floating key={index} label={label} />)}
            </div>
            {mode === 'compare' && <Comparison url={fileUrl(scene, 'preview/reference.png')} box={boxOf(doc, selected)} />}
          </>
        )}
      </div>
      {ready && (
        <>
          <div class="row tools">
            <button type="button" onClick={() => viewer.current?.referenceView()} disabled={mode === 'compare'}>
              Image camera
            </button>
            <button type="button" onClick={() => viewer.current?.topView()} disabled={mode === 'compare'}>
              From above
            </button>
            <button type="button" aria-pressed={grid} onClick={() => setGrid(!grid)}>
              Grid
            </button>
            <button type="button" aria-pressed={mode === 'measure'} onClick={() => toggle('measure')}>
              Measure
            </button>
            <button
              type="button"
              aria-pressed={hulls}
              onClick={() => setHulls(!hulls)}
              disabled={!anyHulls}
              title={anyHulls ? '' : 'This scene has no files of hulls of its own.'}
            >
              Hulls
            </button>
            <button type="button" aria-pressed={mode === 'compare'} onClick={() => toggle('compare')}>
              Compare
            </button>
            <button type="button" aria-pressed={mode === 'physics'} onClick={() => toggle('physics')}>
              Physics
            </button>
          </div>
          {hulls && (
            <label class="slider">
              Move hulls apart
              <input
                type="range"
                min={0}
                max={1}
                step={0.01}
                value={apart}
                onInput={(event) => setApart(event.currentTarget.valueAsNumber)}
              />
            </label>
          )}
          {mode === 'measure' && <p class="hint">Click two points on the objects or the table.</p>}
          {mode === 'physics' && viewer.current && (
            <PhysicsPanel scene={scene} document={doc} viewer={viewer.current} selected={selected} onSelect={onSelect} />
          )}
        </>
      )}
    </section>
  );
}

/** A text at a place of the canvas. */
function Floating({ label }: { label: Label }) {
  const [x, y] = label.at!;
  return (
    <span class={`floating ${label.kind}`} style={{ left: `${x}px`, top: `${y}px` }}>
      {label.text}
    </span>
  );
}

/** Where an object is in the reference image, in percent of its sides. */
function boxOf({ camera, instances }: SceneDocument, name: string | undefined) {
  const box = instances.find((instance) => instance.name === name)?.image.bbox_px;
  if (!box) return undefined;
  const [x0, y0, x1, y1] = box;
  const [x, y] = [100 / camera.width_px, 100 / camera.height_px];
  return { left: `${x0 * x}%`, top: `${y0 * y}%`, width: `${(x1 - x0) * x}%`, height: `${(y1 - y0) * y}%` };
}

/** The reference image over the model, up to a line that is moved, and the box of the selected object. */
function Comparison({ url, box }: { url: string; box: ReturnType<typeof boxOf> }) {
  const [at, setAt] = useState(50);
  const [difference, setDifference] = useState(false);
  useShortcuts([{ key: 'b', what: 'Blink between image and model', run: () => setAt((old) => (old < 50 ? 100 : 0)) }], []);
  return (
    <div class="comparison">
      <img
        src={url}
        alt="Reference image"
        style={difference ? { mixBlendMode: 'difference' } : { clipPath: `inset(0 ${100 - at}% 0 0)` }}
      />
      {!difference && <span class="line" style={{ left: `${at}%` }} aria-hidden="true" />}
      {box && <span class="box" style={box} aria-hidden="true" />}
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

const PUSH_S = 0.2;

/** MuJoCo on the scene's own MJCF: pushes, shakes, and how far each object went. */
function PhysicsPanel({
  scene,
  document: doc,
  viewer,
  selected,
  onSelect,
}: {
  scene: Scene;
  document: SceneDocument;
  viewer: Viewer;
  selected: string | undefined;
  onSelect: (name: string) => void;
}) {
  const [state, setState] = useState('Starting');
  const [running, setRunning] = useState(true);
  const [time, setTime] = useState(0);
  const [drift, setDrift] = useState<{ name: string; m: number }[]>([]);
  const physics = useRef<Physics>(undefined);
  useEffect(() => {
    let names: string[] = [];
    let start: Float32Array | undefined;
    let shown = 0;
    const receive = (message: FromPhysics) => {
      switch (message.kind) {
        case 'progress':
          setState(message.text);
          break;
        case 'failed':
          setState(`Failed: ${message.message}`);
          break;
        case 'ready':
          names = message.bodies;
          setState('ready');
          made.send({ kind: 'run', on: true });
          break;
        case 'poses':
          start ??= message.poses;
          viewer.setPoses(names, message.poses);
          // The numbers are read by people; four times a second is enough.
          if (performance.now() - shown > 250 || message.time_s === 0) {
            shown = performance.now();
            setTime(message.time_s);
            const moved = names.map((name, index) => ({
              name,
              m: Math.hypot(...[0, 1, 2].map((axis) => message.poses[7 * index + axis]! - start![7 * index + axis]!)),
            }));
            setDrift(moved.filter((one) => doc.instances.some((instance) => instance.name === one.name)).sort((a, b) => b.m - a.m));
          }
      }
    };
    const made = new Physics(new URL(bundleUrl(scene, 'mjcf'), location.href).href, receive);
    physics.current = made;
    return () => {
      made.end();
      viewer.resetPoses();
    };
  }, [scene.id]);

  const target = doc.instances.find((instance) => instance.name === selected) ?? doc.instances[0];
  const push = (x: number, y: number) => {
    if (!target) return;
    // As strong as the weight, but enough to overcome friction, whatever the object weighs.
    const newtons = target.mass_kg * 9.81 * (target.friction.static + 0.6);
    physics.current?.send({ kind: 'push', body: target.name, force: [x * newtons, y * newtons, 0], seconds: PUSH_S });
  };
  const run = (on: boolean) => {
    setRunning(on);
    physics.current?.send({ kind: 'run', on });
  };
  if (state !== 'ready') {
    return state.startsWith('Failed') ? (
      <p class="notice bad" role="alert">
        {state}
      </p>
    ) : (
      <p class="waiting" role="status">
        <span class="spinner" aria-hidden="true" /> {state}…
      </p>
    );
  }
  return (
    <div class="physics" aria-label="Physics" role="group">
      <div class="row">
        <button type="button" aria-pressed={!running} onClick={() => run(!running)}>
          {running ? 'Pause' : 'Run'}
        </button>
        <button type="button" onClick={() => physics.current?.send({ kind: 'shake' })}>
          Shake the table
        </button>
        <button type="button" onClick={() => physics.current?.send({ kind: 'reset' })}>
          Reset
        </button>
        <label class="inline">
          Push
          <select value={target?.name} onChange={(event) => onSelect(event.currentTarget.value)} aria-label="Object to push">
            {doc.instances.map((instance) => (
              <option key={instance.name} value={instance.name}>
                {instance.name}
              </option>
            ))}
          </select>
        </label>
        <button type="button" onClick={() => push(-1, 0)} aria-label="Push to the left">
          ←
        </button>
        <button type="button" onClick={() => push(1, 0)} aria-label="Push to the right">
          →
        </button>
        <button type="button" onClick={() => push(0, 1)} aria-label="Push to the back">
          ↑
        </button>
        <button type="button" onClick={() => push(0, -1)} aria-label="Push to the front">
          ↓
        </button>
        <span class="spring" />
        <span class="number hint" data-time={time}>
          {time.toFixed(1)} s
        </span>
      </div>
      <p class="chips">
        <span class="label">Moved</span>
        {drift.slice(0, 8).map((one) => (
          <span class="chip number" key={one.name} data-drift={one.m}>
            {one.name} {length(one.m)}
          </span>
        ))}
      </p>
      <p class="hint">MuJoCo runs the MJCF of this scene in the browser, as you would download it.</p>
    </div>
  );
}
