/** A version of a dataset: its statistics, files and verification. */
import { useEvents } from '../api/events';
import { getJson, sendJson } from '../api/fetch';
import type { Dataset, DatasetFiles } from '../api/types';
import { bytes, count, dateTime, percent, significant, words } from '../format';
import { useLoad } from '../load';
import { may } from '../session';
import { announce } from '../ui/announce';
import { Bars, type BarItem } from '../ui/bars';
import { Absent, Badge, Failed, Waiting } from '../ui/parts';
import { DATASET_TONES } from './datasets';

interface Distribution {
  unit: string;
  count: number;
  min: number | null;
  max: number | null;
  median: number | null;
  /** Bin `k` holds values from `edges[k]` up to `edges[k + 1]`. */
  edges: number[];
  counts: number[];
}

/** `statistics.json` of a version, as far as the page reads it. */
interface Statistics {
  scenes: number;
  objects: number;
  splits: { name: string; scenes: number; share: number; objects: number }[];
  categories: { category: string; objects: number; scenes: number }[];
  objects_per_scene: Distribution;
  mass_kg: Distribution;
  largest_extent_m: Distribution;
  table_shapes: Record<string, number>;
  licences: Record<string, number>;
  yield_share: number | null;
}

export default function DatasetPage({ id }: { id: string }) {
  const path = `/datasets/${id}`;
  const dataset = useLoad(path, (signal) => getJson<Dataset>(path, signal));
  useEvents((event) => event.dataset_id === id || event.job_id === dataset.value?.job_id, dataset.reload, [id, dataset.value?.job_id]);
  const finished = dataset.value?.state === 'finished';
  const statistics = useLoad(finished ? `${path} statistics` : null, (signal) =>
    getJson<Statistics>(dataset.value!.links.statistics, signal),
  );
  const files = useLoad(finished ? `${path} files` : null, (signal) => getJson<DatasetFiles>(dataset.value!.links.files, signal));
  if (!dataset.value) return dataset.error ? <Absent title="Dataset" error={dataset.error} again={dataset.reload} /> : <Waiting what="the dataset" />;
  const { value } = dataset;
  const verification = value.verification;
  const verify = async () => {
    try {
      await sendJson('POST', `${path}/verify`);
      dataset.reload();
    } catch (refused) {
      announce((refused as Error).message, 'bad');
    }
  };
  return (
    <div class="narrow">
      <h1>
        {value.name}
        {value.version !== null && ` v${value.version}`}
      </h1>
      <div class="row">
        <Badge tone={DATASET_TONES[value.state]}>{words(value.state)}</Badge>
        <span class="hint">{dateTime(value.created_at)}</span>
        {value.digest && (
          <code class="hint" title={`SHA-256 of the manifest: ${value.digest}`}>
            {value.digest.slice(0, 12)}
          </code>
        )}
        <span class="spring" />
        {finished && (
          <>
            <a class="button" href={value.links.archive} download>
              Archive
            </a>
            <a class="button" href={value.links.statistics_page} target="_blank" rel="noreferrer">
              Statistics page
            </a>
            {may('submit') && (
              <button
                type="button"
                onClick={() => void verify()}
                disabled={verification?.state === 'queued' || verification?.state === 'running'}
              >
                Verify
              </button>
            )}
          </>
        )}
      </div>
      {value.failure && <p class="notice bad">{value.failure.message}</p>}
      {value.progress && (
        <p class="hint">
          {value.progress.done} of {value.progress.all} steps
        </p>
      )}
      {verification && (
        <p class={`notice ${verification.found && !verification.found.intact ? 'bad' : ''}`}>
          {verification.state !== 'finished' || !verification.found
            ? 'Every byte is being read again…'
            : verification.found.intact
              ? `Verified: ${count(verification.found.scenes, 'scene')} with ${bytes(verification.found.bytes)} are intact.`
              : `${count(verification.found.fault_count, 'fault')}: the dataset is damaged.`}
        </p>
      )}
      {statistics.error && <Failed error={statistics.error} />}
      {statistics.value && <StatisticsCards statistics={statistics.value} />}
      {files.value && (
        <details class="card">
          <summary>{count(files.value.files.length, 'file')}</summary>
          <ul class="files">
            {files.value.files.map((file) => (
              <li key={file.path}>
                <a href={file.url} target="_blank" rel="noreferrer">
                  {file.path}
                </a>
                <span class="number hint">{bytes(file.size)}</span>
                <code class="hint">{file.sha256.slice(0, 10)}</code>
              </li>
            ))}
          </ul>
        </details>
      )}
    </div>
  );
}

function StatisticsCards({ statistics }: { statistics: Statistics }) {
  const items = (record: Record<string, number>): BarItem[] =>
    Object.entries(record)
      .sort((a, b) => b[1] - a[1])
      .map(([name, value]) => ({ name: name.replaceAll('_', ' '), value }));
  return (
    <>
      <dl class="metrics">
        {(
          [
            ['Scenes', statistics.scenes],
            ['Objects', statistics.objects],
            ['Categories', statistics.categories.length],
            ...(statistics.yield_share !== null ? [['Yield', percent(statistics.yield_share)] as const] : []),
          ] as const
        ).map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd class="number">{value}</dd>
          </div>
        ))}
      </dl>
      <div class="tiles">
        <Bars title="Splits" items={statistics.splits.map((split) => ({ name: split.name, value: split.scenes }))} />
        <Bars
          title="Categories"
          items={statistics.categories.map((one) => ({ name: one.category.replaceAll('_', ' '), value: one.objects }))}
        />
        <Bars title="Tables" items={items(statistics.table_shapes)} />
        <Bars title="Licenses" items={items(statistics.licences)} />
        <Histogram title="Objects of a scene" distribution={statistics.objects_per_scene} />
        <Histogram title="Mass" distribution={statistics.mass_kg} />
        <Histogram title="Largest extent" distribution={statistics.largest_extent_m} />
      </div>
    </>
  );
}

function Histogram({ title, distribution }: { title: string; distribution: Distribution }) {
  const { counts, edges, unit, median, min, max } = distribution;
  const most = Math.max(1, ...counts);
  return (
    <section class="card">
      <h2>{title}</h2>
      <div class="histogram" role="img" aria-label={`${title}: ${counts.map((number, bin) => `${number} from ${edges[bin]}`).join(', ')}`}>
        {counts.map((number, bin) => (
          <span key={bin} title={`${edges[bin]} to ${edges[bin + 1]} ${unit}: ${number}`} style={{ height: `${(number / most) * 100}%` }} />
        ))}
      </div>
      <p class="row hint number">
        <span>{edges[0]}</span>
        <span class="spring" />
        <span>
          {edges.at(-1)} {unit}
        </span>
      </p>
      {median !== null && (
        <p class="hint number">
          Median {significant(median)}, {significant(min ?? 0)} to {significant(max ?? 0)} {unit}
        </p>
      )}
    </section>
  );
}
