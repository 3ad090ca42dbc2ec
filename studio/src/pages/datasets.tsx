/** Datasets: a freeze of scenes by a label, and the versions there are. */
import { useState } from 'preact/hooks';
import { useEvents } from '../api/events';
import { idempotencyKey, sendJson } from '../api/fetch';
import type { Dataset } from '../api/types';
import { ago, count, words } from '../format';
import { usePaged } from '../paged';
import { href, navigate } from '../router';
import { may } from '../session';
import { Badge, Empty, Failed, More, type Tone, Waiting } from '../ui/parts';

export const DATASET_TONES: Record<Dataset['state'], Tone> = { queued: 'busy', running: 'busy', finished: 'good', failed: 'bad' };

/** Number of scenes of a version, where the server states it. */
export function scenesOf(dataset: Dataset): number | undefined {
  const scenes = (dataset.summary?.counts as Record<string, unknown> | undefined)?.scenes;
  return typeof scenes === 'number' ? scenes : undefined;
}

export default function Datasets() {
  const list = usePaged<Dataset>('/datasets', 'datasets');
  useEvents((event) => Boolean(event.dataset_id), list.reload, [], 1000);
  return (
    <div class="narrow">
      <h1>Datasets</h1>
      <Freeze />
      {list.error && <Failed error={list.error} again={list.reload} />}
      {!list.ready && list.loading && <Waiting what="datasets" />}
      {list.ready && list.items.length === 0 && (
        <Empty>There are no datasets yet. A dataset is a version of a set of scenes that does not change.</Empty>
      )}
      <ul class="rows">
        {list.items.map((dataset) => (
          <li key={dataset.id} class="card row">
            <a class="strong" href={href(`/datasets/${dataset.id}`)}>
              {dataset.name}
              {dataset.version !== null && ` v${dataset.version}`}
            </a>
            <Badge tone={DATASET_TONES[dataset.state]}>{words(dataset.state)}</Badge>
            {dataset.progress && (
              <span class="hint number">
                {dataset.progress.done} of {dataset.progress.all}
              </span>
            )}
            <span class="spring" />
            {scenesOf(dataset) !== undefined && <span class="hint">{count(scenesOf(dataset)!, 'scene')}</span>}
            <time class="hint" dateTime={dataset.created_at}>
              {ago(dataset.created_at)}
            </time>
          </li>
        ))}
      </ul>
      <More token={list.next} busy={list.loading} load={list.more} />
    </div>
  );
}

function Freeze() {
  const [name, setName] = useState('');
  const [source, setSource] = useState<'label' | 'batch'>('label');
  const [value, setValue] = useState('review:accept');
  const [verdict, setVerdict] = useState('pass');
  const [error, setError] = useState<Error>();
  const [busy, setBusy] = useState(false);
  const send = async (event: Event) => {
    event.preventDefault();
    setBusy(true);
    setError(undefined);
    try {
      const dataset = await sendJson<Dataset>('POST', '/datasets', { name, [source]: value, filter: { verdict } }, idempotencyKey());
      navigate(`/datasets/${dataset.id}`);
    } catch (refused) {
      setError(refused as Error);
    }
    setBusy(false);
  };
  return (
    <details class="card recipe">
      <summary>Freeze scenes into a dataset</summary>
      <form onSubmit={send} class="stack">
        <div class="fields">
          <label>
            Name
            <input
              required
              pattern="[a-z0-9_\-]+"
              maxLength={64}
              value={name}
              placeholder="kitchen"
              onInput={(event) => setName(event.currentTarget.value)}
            />
          </label>
          <label>
            Scenes with
            <select
              value={source}
              onChange={(event) => {
                setSource(event.currentTarget.value as 'label');
                setValue(event.currentTarget.value === 'label' ? 'review:accept' : '');
              }}
            >
              <option value="label">the label</option>
              <option value="batch">the batch</option>
            </select>
          </label>
          <label>
            {source === 'label' ? 'Label, key:value' : 'Id of the batch'}
            <input required value={value} onInput={(event) => setValue(event.currentTarget.value)} />
          </label>
          <label>
            Verdict
            <select value={verdict} onChange={(event) => setVerdict(event.currentTarget.value)}>
              <option>pass</option>
              <option>quarantine</option>
              <option>any</option>
            </select>
          </label>
        </div>
        {error && <Failed error={error} />}
        <div class="row">
          <button type="submit" class="primary" disabled={busy || !may('submit')}>
            {busy ? 'Sending…' : 'Freeze'}
          </button>
          <span class="hint">Split into train, validation and test by 8 : 1 : 1, without shared texts, images or ancestors.</span>
        </div>
      </form>
    </details>
  );
}
