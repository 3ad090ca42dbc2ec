/** Batches: a recipe for many scenes, and the yield of each batch. */
import { useState } from 'preact/hooks';
import { useEvents } from '../api/events';
import { idempotencyKey, sendJson, withQuery } from '../api/fetch';
import type { Batch } from '../api/types';
import { partsOfBatch, recipeOf, sizeOf, yieldOf } from '../batch_parts';
import { ago, count, percent, short, words } from '../format';
import { usePaged } from '../paged';
import { href, navigate } from '../router';
import { may } from '../session';
import { Badge, Empty, Failed, More, Waiting } from '../ui/parts';
import { YieldBar } from '../ui/yield_bar';

export default function Batches() {
  const list = usePaged<Batch>('/batches', 'batches');
  useEvents((event) => event.kind.startsWith('job_'), list.reload, [], 3000);
  return (
    <div class="narrow">
      <h1>Batches</h1>
      <Recipe />
      {list.error && <Failed error={list.error} again={list.reload} />}
      {!list.ready && list.loading && <Waiting what="batches" />}
      {list.ready && list.items.length === 0 && <Empty>There are no batches yet.</Empty>}
      <ul class="rows">
        {list.items.map((batch) => {
          const share = yieldOf(batch.request_counts);
          return (
            <li key={batch.id} class="card">
              <div class="row">
                <a href={href(`/batches/${batch.id}`)} class="strong">
                  {batch.name ?? `Batch ${short(batch.id)}`}
                </a>
                <Badge tone={batch.state === 'finished' ? 'good' : batch.state === 'cancelled' ? 'bad' : 'busy'}>
                  {words(batch.state)}
                </Badge>
                <span class="hint">{count(batch.request_counts.total, 'request')}</span>
                <span class="spring" />
                {share !== undefined && <span class="number">{percent(share)} passed</span>}
                <time class="hint" dateTime={batch.created_at}>
                  {ago(batch.created_at)}
                </time>
              </div>
              <YieldBar parts={partsOfBatch(batch.request_counts)} label="Results" />
            </li>
          );
        })}
      </ul>
      <More token={list.next} busy={list.loading} load={list.more} />
    </div>
  );
}

function Recipe() {
  const [name, setName] = useState('');
  const [templates, setTemplates] = useState('');
  const [slots, setSlots] = useState('');
  const [first, setFirst] = useState(0);
  const [seeds, setSeeds] = useState(1);
  const [error, setError] = useState<Error>();
  const [busy, setBusy] = useState(false);
  let recipe: Record<string, unknown> | undefined;
  let fault = '';
  try {
    recipe = recipeOf(templates, slots, first, seeds);
  } catch (wrong) {
    fault = (wrong as Error).message;
  }
  const number = recipe ? sizeOf(recipe) : 0;
  const send = async (event: Event) => {
    event.preventDefault();
    setBusy(true);
    setError(undefined);
    try {
      const batch = await sendJson<Batch>('POST', withQuery('/batches', { name: name.trim() }), recipe, idempotencyKey());
      navigate(`/batches/${batch.id}`);
    } catch (refused) {
      setError(refused as Error);
    }
    setBusy(false);
  };
  return (
    <details class="card recipe">
      <summary>New batch</summary>
      <form onSubmit={send} class="stack">
        <label>
          Sentences, one a line; words in braces are slots
          <textarea
            rows={3}
            required
            value={templates}
            placeholder="A desk with a {color} mug and two {item}"
            onInput={(event) => setTemplates(event.currentTarget.value)}
          />
        </label>
        <label>
          Values of the slots
          <textarea
            rows={2}
            value={slots}
            placeholder={'color: red, blue\nitem: spoons, forks'}
            onInput={(event) => setSlots(event.currentTarget.value)}
            aria-invalid={fault !== ''}
          />
        </label>
        {fault && <p class="field-error">{fault}</p>}
        <div class="row">
          <label class="inline">
            First seed
            <input
              type="number"
              class="small"
              min={0}
              value={first}
              onInput={(event) => setFirst(event.currentTarget.valueAsNumber || 0)}
            />
          </label>
          <label class="inline">
            Seeds of each
            <input
              type="number"
              class="small"
              min={1}
              value={seeds}
              onInput={(event) => setSeeds(event.currentTarget.valueAsNumber || 1)}
            />
          </label>
          <label class="inline">
            Name
            <input value={name} onInput={(event) => setName(event.currentTarget.value)} />
          </label>
          <span class="spring" />
          <button type="submit" class="primary" disabled={busy || !number || !may('submit')}>
            {busy ? 'Sending…' : number ? `Make ${count(number, 'scene')}` : 'Make the scenes'}
          </button>
        </div>
        {error && <Failed error={error} />}
      </form>
    </details>
  );
}
