/** For operators: queue, keys, webhooks, record of changes, limits. */
import { useState } from 'preact/hooks';
import { useEvents } from '../api/events';
import { getJson, sendJson } from '../api/fetch';
import type { AuditPage, DeliveryPage, Job, Key, Queue, Scope, Version, Webhook, WebhookList } from '../api/types';
import { ago, bytes, count, dateTime, short, words } from '../format';
import { useLoad } from '../load';
import { usePaged } from '../paged';
import { address, href, setQuery } from '../router';
import { may, session } from '../session';
import { announce } from '../ui/announce';
import { Badge, CopyButton, Empty, Failed, More, Panel, Table, Tabs, type Tone, Waiting } from '../ui/parts';

const TABS = [
  { id: 'queue', title: 'Queue' },
  { id: 'keys', title: 'Keys' },
  { id: 'webhooks', title: 'Webhooks' },
  { id: 'audit', title: 'Changes' },
  { id: 'limits', title: 'Limits' },
] as const;
type Tab = (typeof TABS)[number]['id'];

export default function Operate() {
  const wanted = address.value.query.get('tab') as Tab | null;
  const tab = TABS.some((one) => one.id === wanted) ? wanted! : 'queue';
  return (
    <div class="narrow">
      <h1>Operate</h1>
      <Tabs label="Parts" tabs={[...TABS]} value={tab} onChange={(id) => setQuery({ tab: id === 'queue' ? '' : id })} />
      <Panel id={tab}>
        {tab === 'queue' && <QueuePanel />}
        {tab === 'keys' && <Keys />}
        {tab === 'webhooks' && <Webhooks />}
        {tab === 'audit' && <Audit />}
        {tab === 'limits' && <Limits />}
      </Panel>
    </div>
  );
}

/** Runs a change, and tells of its refusal. */
async function attempt(what: () => Promise<unknown>, then: () => void): Promise<void> {
  try {
    await what();
    then();
  } catch (refused) {
    announce((refused as Error).message, 'bad');
  }
}

export const JOB_TONES: Record<Job['state'], Tone> = {
  queued: 'busy',
  running: 'busy',
  cancelling: 'warn',
  succeeded: 'good',
  failed: 'bad',
  cancelled: 'bad',
};

function QueuePanel() {
  const queue = useLoad('/queue', (signal) => getJson<Queue>('/queue', signal));
  const jobs = usePaged<Job>('/jobs?page_size=30', 'jobs');
  useEvents(
    () => true,
    () => {
      queue.reload();
      jobs.reload();
    },
    [],
    1500,
  );
  return (
    <div class="stack">
      {queue.error && <Failed error={queue.error} again={queue.reload} />}
      {queue.value && (
        <>
          {queue.value.paused && (
            <p class="notice warn">
              Paused since {dateTime(queue.value.paused.since)}: {queue.value.paused.reason}
            </p>
          )}
          {queue.value.storage !== 'ok' && <p class="notice bad">The storage is {queue.value.storage}: nothing new is taken.</p>}
          <dl class="metrics">
            {queue.value.kinds.map((kind) => (
              <div key={kind.kind}>
                <dt>{words(kind.kind)}</dt>
                <dd class="number">
                  {kind.running} <span class="hint">running, {kind.waiting} waiting</span>
                </dd>
              </div>
            ))}
          </dl>
          {queue.value.kinds.length === 0 && <p class="hint">Nothing waits and nothing runs.</p>}
          {queue.value.workers.map((worker) => (
            <p key={worker.id}>
              <code>{worker.id}</code>{' '}
              <span class="hint">
                has {count(worker.jobs.length, 'job')} since {ago(worker.since)}
              </span>
            </p>
          ))}
        </>
      )}
      {jobs.error && <Failed error={jobs.error} again={jobs.reload} />}
      <Table caption="Newest jobs" head={['Job', 'Kind', 'State', 'Of', 'Begun', '']}>
        {jobs.items.map((job) => (
          <tr key={job.id}>
            <td>
              <code>{short(job.id)}</code>
            </td>
            <td>{words(job.kind)}</td>
            <td>
              <Badge tone={JOB_TONES[job.state]}>{words(job.state)}</Badge>
              {job.failure && <span class="hint"> {job.failure.message}</span>}
            </td>
            <td>
              {job.recording_id ? (
                <a href={href(`/recordings/${job.recording_id}`)}>recording</a>
              ) : job.dataset_id ? (
                <a href={href(`/datasets/${job.dataset_id}`)}>dataset</a>
              ) : job.kind === 'execute_task' ? (
                <a href={href(`/executions/${job.id}`)}>execution</a>
              ) : job.scene_id ? (
                <a href={href(`/scenes/${job.scene_id}`)}>scene</a>
              ) : null}
            </td>
            <td class="hint">{ago(job.created_at)}</td>
            <td>
              {['queued', 'running'].includes(job.state) && may('submit') && (
                <button type="button" onClick={() => void attempt(() => sendJson('POST', `/jobs/${job.id}/cancel`), jobs.reload)}>
                  Cancel
                </button>
              )}
            </td>
          </tr>
        ))}
      </Table>
      <More token={jobs.next} busy={jobs.loading} load={jobs.more} />
    </div>
  );
}

const SCOPES: { scope: Scope; what: string }[] = [
  { scope: 'read', what: 'see scenes and results' },
  { scope: 'submit', what: 'make, edit and label' },
  { scope: 'delete', what: 'delete' },
  { scope: 'operate', what: 'see the queue and metrics' },
  { scope: 'admin', what: 'make keys, see changes' },
];

function Keys() {
  const keys = usePaged<Key>('/keys', 'keys');
  const [name, setName] = useState('');
  const [scopes, setScopes] = useState<Scope[]>(['read', 'submit']);
  const [days, setDays] = useState('');
  const [made, setMade] = useState<Key>();
  const [error, setError] = useState<Error>();
  const make = async (event: Event) => {
    event.preventDefault();
    setError(undefined);
    try {
      setMade(await sendJson<Key>('POST', '/keys', { name, scopes, ...(days && { expires_in_s: Number(days) * 86400 }) }));
      setName('');
      keys.reload();
    } catch (refused) {
      setError(refused as Error);
    }
  };
  const revoke = (key: Key) =>
    confirm(`Revoke the key “${key.name}”? Programs that use it stop working at once.`) &&
    void attempt(() => sendJson('DELETE', `/keys/${key.id}`), keys.reload);
  if (keys.error) return <Failed error={keys.error} again={keys.reload} />;
  return (
    <div class="stack">
      <form class="card stack" onSubmit={make}>
        <div class="row">
          <label class="inline">
            Name
            <input
              required
              maxLength={100}
              value={name}
              placeholder="training machine"
              onInput={(event) => setName(event.currentTarget.value)}
            />
          </label>
          <label class="inline">
            Expires in days
            <input
              type="number"
              class="small"
              min={1}
              value={days}
              placeholder="never"
              onInput={(event) => setDays(event.currentTarget.value)}
            />
          </label>
        </div>
        <fieldset>
          <legend>The key may</legend>
          <div class="row">
            {SCOPES.map(({ scope, what }) => (
              <label class="check" key={scope} title={scope}>
                <input
                  type="checkbox"
                  checked={scopes.includes(scope)}
                  onChange={(event) =>
                    setScopes((old) => (event.currentTarget.checked ? [...old, scope] : old.filter((one) => one !== scope)))
                  }
                />
                {what}
              </label>
            ))}
          </div>
        </fieldset>
        {error && <Failed error={error} />}
        <div class="row">
          <button type="submit" class="primary" disabled={!scopes.length}>
            Make the key
          </button>
        </div>
        {made?.key && (
          <p class="notice" role="status">
            Copy it now; it is shown only once: <code>{made.key}</code> <CopyButton text={made.key} />
          </p>
        )}
      </form>
      <Table caption="Keys" head={['Name', 'May', 'Made', 'Used', 'Expires', '']}>
        {keys.items.map((key) => (
          <tr key={key.id}>
            <td>{key.name}</td>
            <td>{key.scopes.join(', ')}</td>
            <td class="hint">{ago(key.created_at)}</td>
            <td class="hint">{key.last_used_at ? ago(key.last_used_at) : 'never'}</td>
            <td class="hint">{key.expires_at ? dateTime(key.expires_at) : 'never'}</td>
            <td>
              {key.revoked_at ? (
                <Badge tone="bad">revoked</Badge>
              ) : (
                <button type="button" class="danger" onClick={() => revoke(key)}>
                  Revoke
                </button>
              )}
            </td>
          </tr>
        ))}
      </Table>
      <More token={keys.next} busy={keys.loading} load={keys.more} />
    </div>
  );
}

const HOOK_EVENTS: Webhook['events'] = [
  'scene.succeeded',
  'scene.quarantined',
  'scene.failed',
  'scene.cancelled',
  'job.failed',
  'batch.ended',
  'recording.ended',
  'dataset.ended',
];

function Webhooks() {
  const hooks = useLoad('/webhooks', (signal) => getJson<WebhookList>('/webhooks', signal));
  const [url, setUrl] = useState('');
  const [events, setEvents] = useState<Webhook['events']>([]);
  const [made, setMade] = useState<Webhook>();
  const [error, setError] = useState<Error>();
  const make = async (event: Event) => {
    event.preventDefault();
    setError(undefined);
    try {
      setMade(await sendJson<Webhook>('POST', '/webhooks', { url, events }));
      setUrl('');
      hooks.reload();
    } catch (refused) {
      setError(refused as Error);
    }
  };
  if (hooks.error) return <Failed error={hooks.error} again={hooks.reload} />;
  return (
    <div class="stack">
      <form class="card stack" onSubmit={make}>
        <label>
          Address that is called
          <input
            type="url"
            required
            pattern="https://.*"
            value={url}
            placeholder="https://example.org/tabletopgen"
            onInput={(event) => setUrl(event.currentTarget.value)}
          />
        </label>
        <fieldset>
          <legend>Events; none means all</legend>
          <div class="row">
            {HOOK_EVENTS.map((name) => (
              <label class="check" key={name}>
                <input
                  type="checkbox"
                  checked={events.includes(name)}
                  onChange={(event) =>
                    setEvents((old) => (event.currentTarget.checked ? [...old, name] : old.filter((one) => one !== name)))
                  }
                />
                {name}
              </label>
            ))}
          </div>
        </fieldset>
        {error && <Failed error={error} />}
        <div class="row">
          <button type="submit" class="primary">
            Add the webhook
          </button>
        </div>
        {made?.secret && (
          <p class="notice" role="status">
            Copy the key of the signatures now; it is shown only once: <code>{made.secret}</code> <CopyButton text={made.secret} />
          </p>
        )}
      </form>
      {!hooks.value && hooks.loading && <Waiting what="webhooks" />}
      {hooks.value?.webhooks.length === 0 && <Empty>No webhooks.</Empty>}
      {hooks.value?.webhooks.map((hook) => (
        <Hook key={hook.id} hook={hook} reload={hooks.reload} />
      ))}
    </div>
  );
}

function Hook({ hook, reload }: { hook: Webhook; reload: () => void }) {
  const [open, setOpen] = useState(false);
  const path = `/webhooks/${hook.id}`;
  const deliveries = useLoad(open ? `${path}/deliveries` : null, (signal) => getJson<DeliveryPage>(`${path}/deliveries`, signal));
  const toggled = hook.state === 'enabled' ? 'disabled' : 'enabled';
  return (
    <section class="card stack" aria-label={hook.url}>
      <div class="row">
        <code>{hook.url}</code>
        <Badge tone={hook.state === 'enabled' ? 'good' : 'bad'}>{hook.state}</Badge>
        <span class="hint">{hook.events.join(', ') || 'all events'}</span>
        <span class="spring" />
        <button
          type="button"
          onClick={() =>
            void attempt(
              () => sendJson('POST', `${path}/test`),
              () => setOpen(true),
            )
          }
        >
          Test
        </button>
        <button
          type="button"
          onClick={() =>
            void attempt(() => sendJson('PATCH', path, { state: toggled }, { 'content-type': 'application/merge-patch+json' }), reload)
          }
        >
          {hook.state === 'enabled' ? 'Disable' : 'Enable'}
        </button>
        <button
          type="button"
          class="danger"
          onClick={() => confirm('Delete this webhook?') && void attempt(() => sendJson('DELETE', path), reload)}
        >
          Delete
        </button>
      </div>
      {hook.disabled_reason && <p class="notice warn">{hook.disabled_reason}</p>}
      <details open={open} onToggle={(event) => setOpen(event.currentTarget.open)}>
        <summary>Deliveries</summary>
        {deliveries.error && <Failed error={deliveries.error} />}
        {deliveries.value && (
          <Table caption="Deliveries" head={['Event', 'State', 'Attempts', 'Answer', 'When', '']}>
            {deliveries.value.deliveries.map((delivery) => (
              <tr key={delivery.id}>
                <td>{delivery.event}</td>
                <td>{words(delivery.state)}</td>
                <td class="number">{delivery.attempts}</td>
                <td class="hint">{delivery.last_attempt?.error ?? delivery.last_attempt?.status ?? ''}</td>
                <td class="hint">{ago(delivery.created_at)}</td>
                <td>
                  <button
                    type="button"
                    onClick={() => void attempt(() => sendJson('POST', `${path}/deliveries/${delivery.id}/replay`), deliveries.reload)}
                  >
                    Send again
                  </button>
                </td>
              </tr>
            ))}
          </Table>
        )}
      </details>
    </section>
  );
}

function Audit() {
  const audit = usePaged<AuditPage['entries'][number]>('/audit', 'entries');
  if (audit.error) return <Failed error={audit.error} again={audit.reload} />;
  if (!audit.ready) return <Waiting what="the record" />;
  return (
    <div class="stack">
      <div class="row">
        <span class="hint">Changes and attempts at changes, newest first.</span>
        <span class="spring" />
        <a class="button" href="/audit/lines" download="audit.jsonl">
          Download
        </a>
      </div>
      <Table caption="Record of changes" head={['When', 'Who', 'What', 'Subject', 'Answer']}>
        {audit.items.map((entry) => (
          <tr key={entry.id}>
            <td class="hint">{dateTime(entry.at)}</td>
            <td>
              {entry.principal} <span class="hint">{entry.address}</span>
            </td>
            <td>{words(entry.action.replace(/([A-Z])/g, ' $1').toLowerCase())}</td>
            <td>
              <code>{entry.subject}</code>
            </td>
            <td class="number">{entry.status}</td>
          </tr>
        ))}
      </Table>
      <More token={audit.next} busy={audit.loading} load={audit.more} />
    </div>
  );
}

function Limits() {
  const version = useLoad('/version', (signal) => getJson<Version>('/version', signal));
  const who = session.value;
  if (!who) return <Waiting what="the session" />;
  const facts: [string, string][] = [
    ['Server', version.value ? `${version.value.name} ${version.value.version}` : ''],
    ['You are', who.principal],
    ['Tenant', who.tenant],
    ['You may', who.scopes.join(', ')],
    ['Login', who.authentication],
    ['Session ends', who.expires_at ? dateTime(who.expires_at) : 'never'],
    ['Largest image', `${bytes(who.limits.max_image_bytes)}, ${(who.limits.max_image_pixels / 1e6).toFixed(0)} megapixels`],
    ['Largest request', bytes(who.limits.max_body_bytes)],
    ['Longest text', count(who.limits.max_text_chars, 'character')],
  ];
  return (
    <dl class="facts card">
      {facts.map(([name, value]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>{value}</dd>
        </div>
      ))}
    </dl>
  );
}
