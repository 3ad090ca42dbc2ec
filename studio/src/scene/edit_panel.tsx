/** Edits by a sentence, and variants. Both make new scenes. */
import { useState } from 'preact/hooks';
import { idempotencyKey, sendJson } from '../api/fetch';
import type { Scene, ValidatedEdit, Variants } from '../api/types';
import { count, length, sentence } from '../format';
import { useSettled } from '../load';
import { href, navigate } from '../router';
import { may } from '../session';
import { Failed } from '../ui/parts';

export function EditPanel({ scene }: { scene: Scene }) {
  const [text, setText] = useState('');
  const [valid, setValid] = useState<ValidatedEdit>();
  const [error, setError] = useState<Error>();
  const [busy, setBusy] = useState(false);
  const body = { text, ...(scene.verdict === 'quarantine' && { allow_quarantined: true }) };
  useSettled([text, scene.id], 350, (signal) => {
    setValid(undefined);
    setError(undefined);
    if (!text.trim()) return;
    sendJson<ValidatedEdit>('POST', `/scenes/${scene.id}/edits/validate`, body, {}, signal).then(
      setValid,
      (refused) => !signal.aborted && setError(refused),
    );
  });
  const send = async (event: Event) => {
    event.preventDefault();
    setBusy(true);
    try {
      const made = await sendJson<Scene>('POST', `/scenes/${scene.id}/edits`, body, idempotencyKey());
      navigate(`/scenes/${made.id}`);
    } catch (refused) {
      setError(refused as Error);
    }
    setBusy(false);
  };
  const prediction = valid?.prediction;
  return (
    <div class="stack edit">
      <form onSubmit={send} class="stack">
        <label>
          What to change
          <input
            value={text}
            placeholder="move the teapot to the left of the bowl"
            onInput={(event) => setText(event.currentTarget.value)}
            aria-describedby="edit-result"
          />
        </label>
        <div id="edit-result" aria-live="polite">
          {error && <Failed error={error} />}
          {prediction && (
            <div class="notice">
              {prediction.operations.map((operation, index) => (
                <p key={index}>{sentence(operation.sentence)}</p>
              ))}
              {prediction.moved.map((moved) => (
                <p key={moved.name} class="hint">
                  {moved.name} moves by {length(moved.distance_m)} as well: {moved.cause}
                </p>
              ))}
              {prediction.undetermined.length > 0 && (
                <p class="hint">{count(prediction.undetermined.length, 'object')} will be made and placed when the edit runs.</p>
              )}
            </div>
          )}
          {valid && !prediction && <p class="hint">The sentence is understood.</p>}
        </div>
        <div class="row">
          <button type="submit" class="primary" disabled={busy || !valid || !may('submit')}>
            {busy ? 'Sending…' : 'Make the edited scene'}
          </button>
          <span class="hint">
            This scene stays as it is. <a href={href(`/gallery?parent=${scene.id}`)}>Scenes made from it</a>
          </span>
        </div>
      </form>
      <VariantsForm scene={scene} />
    </div>
  );
}

const SWITCHES = ['layout', 'meshes', 'colors', 'materials', 'table', 'light', 'camera'] as const;
const SHARES = ['sizes', 'mass', 'friction'] as const;

function VariantsForm({ scene }: { scene: Scene }) {
  const [number, setNumber] = useState(4);
  const [randomize, setRandomize] = useState<Record<string, boolean | number>>({ layout: true });
  const [made, setMade] = useState<Variants>();
  const [error, setError] = useState<Error>();
  const [busy, setBusy] = useState(false);
  const send = async (event: Event) => {
    event.preventDefault();
    setBusy(true);
    setError(undefined);
    try {
      const body = { count: number, randomize, ...(scene.verdict === 'quarantine' && { allow_quarantined: true }) };
      setMade(await sendJson<Variants>('POST', `/scenes/${scene.id}/variants`, body, idempotencyKey()));
    } catch (refused) {
      setError(refused as Error);
    }
    setBusy(false);
  };
  const change = (name: string, value: boolean | number) => setRandomize((old) => ({ ...old, [name]: value }));
  return (
    <form onSubmit={send} class="stack variants">
      <h2>Variants</h2>
      <fieldset>
        <legend>What differs</legend>
        <div class="row">
          {SWITCHES.map((name) => (
            <label class="check" key={name}>
              <input type="checkbox" checked={randomize[name] === true} onChange={(event) => change(name, event.currentTarget.checked)} />
              {name}
            </label>
          ))}
        </div>
        <div class="row">
          {SHARES.map((name) => (
            <label class="inline" key={name}>
              {name} ±
              <input
                type="number"
                class="small"
                min={0}
                max={name === 'sizes' ? 30 : 50}
                value={Math.round(Number(randomize[name] ?? 0) * 100)}
                onInput={(event) => change(name, (event.currentTarget.valueAsNumber || 0) / 100)}
              />
              %
            </label>
          ))}
        </div>
      </fieldset>
      {error && <Failed error={error} />}
      <div class="row">
        <label class="inline">
          Number
          <input
            type="number"
            class="small"
            min={1}
            max={1000}
            value={number}
            onInput={(event) => setNumber(event.currentTarget.valueAsNumber || 1)}
          />
        </label>
        <button type="submit" disabled={busy || !may('submit')}>
          {busy ? 'Sending…' : `Make ${count(number, 'variant')}`}
        </button>
      </div>
      {made && (
        <p role="status">
          {count(made.scenes.length, 'variant')} in the queue{made.remaining > 0 && `; ${made.remaining} found no room there`}.{' '}
          <a href={href(`/gallery?parent=${scene.id}`)}>Show them</a>
        </p>
      )}
    </form>
  );
}
