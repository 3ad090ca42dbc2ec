/** One batch: progress, yield, and its results line by line. */
import { useEvents } from '../api/events';
import { getJson, request, sendJson } from '../api/fetch';
import type { Batch } from '../api/types';
import { partsOfBatch, yieldOf } from '../batch_parts';
import { ago, count, duration, percent, short, significant, words } from '../format';
import { useLoad } from '../load';
import { href } from '../router';
import { may } from '../session';
import { announce } from '../ui/announce';
import { Absent, Badge, Failed, Table, Waiting } from '../ui/parts';
import { YieldBar } from '../ui/yield_bar';

interface Result {
  custom_id: string | null;
  scene_id: string | null;
  state: string;
  verdict: string | null;
  error: { code: string; message: string } | null;
  stages_s: number;
}

/** Lines that the page shows; the download has all. */
const SHOWN = 200;

async function linesOf(path: string, signal: AbortSignal): Promise<Result[]> {
  const text = await (await request(path, { signal })).text();
  return text
    .split('\n', SHOWN)
    .filter(Boolean)
    .map((line) => JSON.parse(line));
}

export default function BatchPage({ id }: { id: string }) {
  const path = `/batches/${id}`;
  const batch = useLoad(path, (signal) => getJson<Batch>(path, signal));
  const ended =
    (batch.value?.request_counts.total ?? 0) - (batch.value?.request_counts.pending ?? 0) - (batch.value?.request_counts.running ?? 0);
  const output = useLoad(batch.value ? `${path}/output ${ended}` : null, (signal) => linesOf(`${path}/output`, signal));
  const errors = useLoad(batch.value ? `${path}/errors ${ended}` : null, (signal) => linesOf(`${path}/errors`, signal));
  useEvents((event) => event.kind.startsWith('job_'), batch.reload, [], 1500);
  if (!batch.value) return batch.error ? <Absent title="Batch" error={batch.error} again={batch.reload} /> : <Waiting what="the batch" />;
  const { value } = batch;
  const share = yieldOf(value.request_counts);
  const act = async (what: 'cancel' | 'retry') => {
    try {
      await sendJson('POST', `${path}/${what}`, what === 'retry' ? {} : undefined);
      batch.reload();
    } catch (refused) {
      announce((refused as Error).message, 'bad');
    }
  };
  return (
    <div class="narrow">
      <h1>{value.name ?? `Batch ${short(value.id)}`}</h1>
      <div class="row">
        <Badge tone={value.state === 'finished' ? 'good' : value.state === 'cancelled' ? 'bad' : 'busy'}>{words(value.state)}</Badge>
        <span class="hint">
          {count(value.request_counts.total, 'request')}, begun {ago(value.created_at)}
          {share !== undefined && `; ${percent(share)} of those that ended passed`}
        </span>
        <span class="spring" />
        {value.state === 'running' && may('submit') && (
          <button type="button" onClick={() => void act('cancel')}>
            Cancel
          </button>
        )}
        {value.request_counts.failed > 0 && may('submit') && (
          <button type="button" onClick={() => void act('retry')}>
            Try failed ones again
          </button>
        )}
        <a class="button" href={href(`/gallery?label=batch:${value.id}`)}>
          Gallery
        </a>
        <a class="button" href={value.links.output} download={`${value.name ?? 'batch'}.jsonl`}>
          Results
        </a>
        <a class="button" href={value.links.errors} download={`${value.name ?? 'batch'}.errors.jsonl`}>
          Errors
        </a>
      </div>
      <section class="card" aria-label="Progress">
        <YieldBar parts={partsOfBatch(value.request_counts)} label="Results" />
        {value.estimate && (
          <p class="hint">
            {significant(value.estimate.scenes_per_hour)} scenes an hour; {duration(value.estimate.time_left_s * 1000)} left
          </p>
        )}
      </section>
      {output.error && <Failed error={output.error} />}
      <Table caption={`Results, the first ${SHOWN}`} head={['Request', 'Scene', 'Result', 'Stages']}>
        {[...(errors.value ?? []), ...(output.value ?? [])].slice(0, SHOWN).map((result, index) => (
          <tr key={index}>
            <td>{result.custom_id ?? '–'}</td>
            <td>{result.scene_id ? <a href={href(`/scenes/${result.scene_id}`)}>{short(result.scene_id)}</a> : '–'}</td>
            <td>
              <Badge tone={result.verdict === 'pass' ? 'good' : result.verdict === 'quarantine' ? 'warn' : 'bad'}>
                {result.verdict ?? words(result.state)}
              </Badge>
              {result.error && <span class="hint"> {result.error.message}</span>}
            </td>
            <td class="number">{significant(result.stages_s)} s</td>
          </tr>
        ))}
      </Table>
    </div>
  );
}
