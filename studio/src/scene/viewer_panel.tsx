/** The viewer with its controls: camera, ruler, hulls, comparison with the reference image, replay, and physics. */
import { useEffect, useRef, useState } from 'preact/hooks';
import type { Scene } from '../api/types';
import { useShortcuts } from '../keys';
import { address } from '../router';
import { announce } from '../ui/announce';
import { Comparison } from './comparison';
import type { SceneDocument } from './documents';
import { PhysicsPanel } from './physics_panel';
import { ReplayPanel } from './replay_panel';
import { artifactUrl, fileUrl, hullUrls } from './scene_files';
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

type Mode = 'view' | 'measure' | 'compare' | 'replay' | 'physics';

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

  const track = artifactUrl(scene, 'certify/track.json');
  const toggle = (wanted: Mode) => setMode((old) => (old === wanted ? 'view' : wanted));
  useShortcuts(
    [
      { key: '0', what: 'View from the camera of the image', run: () => viewer.current?.referenceView() },
      { key: 't', what: 'View from above', run: () => viewer.current?.topView() },
      { key: 'm', what: 'Measure between two points', run: () => toggle('measure') },
      { key: 'k', what: 'Grid and ruler in centimeters', run: () => setGrid((old) => !old) },
      { key: 'h', what: 'Collision hulls', run: () => setHulls((old) => !old) },
      { key: 'i', what: 'Compare with the reference image', run: () => toggle('compare') },
      ...(track ? [{ key: 'l', what: 'Replay of the check under gravity', run: () => toggle('replay') }] : []),
      { key: 'p', what: 'Physics', run: () => toggle('physics') },
    ],
    [track],
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
            {mode === 'compare' && <Comparison scene={scene} document={doc} selected={selected} onSelect={onSelect} />}
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
            {track && (
              <button type="button" aria-pressed={mode === 'replay'} onClick={() => toggle('replay')}>
                Replay
              </button>
            )}
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
          {mode === 'replay' && track && viewer.current && <ReplayPanel url={track} viewer={viewer.current} />}
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
