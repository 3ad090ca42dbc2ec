/** MuJoCo on the scene's own MJCF: pushes, shakes, and how far each object went. */
import { useEffect, useRef, useState } from 'preact/hooks';
import type { Scene } from '../api/types';
import { length } from '../format';
import type { FromPhysics } from '../physics/messages';
import { Physics } from '../physics/physics';
import type { SceneDocument } from './documents';
import { bundleUrl } from './scene_files';
import type { Viewer } from './viewer';

const PUSH_S = 0.2;

export function PhysicsPanel({
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
