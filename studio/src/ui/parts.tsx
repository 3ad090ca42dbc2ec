/** Small parts of all pages. */
import type { ComponentChildren } from 'preact';
import { useRef, useState } from 'preact/hooks';
import { Refusal } from '../api/fetch';
import { sentence } from '../format';
import type { Scene } from '../api/types';
import { announce } from './announce';

/** A refusal of the server: what was wrong, and the sentence for each field. */
export function Failed({ error, again }: { error: Error; again?: () => void }) {
  const errors = error instanceof Refusal ? error.errors : [];
  return (
    <div class="notice bad" role="alert">
      <p>{sentence(error.message)}</p>
      {errors.length > 0 && (
        <ul>
          {errors.map((one) => (
            <li key={one.pointer}>
              {one.pointer && <code>{one.pointer}</code>} {one.detail}
            </li>
          ))}
        </ul>
      )}
      {again && (
        <button type="button" onClick={again}>
          Try again
        </button>
      )}
    </div>
  );
}

/** A page whose subject does not load, or is no longer there. */
export function Absent({ title, error, again }: { title: string; error: Error; again: () => void }) {
  const isGone = error instanceof Refusal && [404, 410].includes(error.status);
  return (
    <>
      <h1>{title}</h1>
      <Failed error={error} {...(!isGone && { again })} />
    </>
  );
}

export function Waiting({ what }: { what: string }) {
  return (
    <p class="waiting" role="status">
      <span class="spinner" aria-hidden="true" /> Loading {what}…
    </p>
  );
}

export function Empty({ children }: { children: ComponentChildren }) {
  return <div class="empty">{children}</div>;
}

export type Tone = 'good' | 'warn' | 'bad' | 'busy' | 'plain';
const SIGNS: Record<Tone, string> = { good: '✓', warn: '!', bad: '✕', busy: '…', plain: '' };

/** A state as a word with a sign, so that color is not needed to read it. */
export function Badge({ tone, children }: { tone: Tone; children: ComponentChildren }) {
  return (
    <span class={`badge ${tone}`}>
      {SIGNS[tone] && <span aria-hidden="true">{SIGNS[tone]}</span>}
      {children}
    </span>
  );
}

/** The verdict about a scene, or what it is waiting for. */
export function SceneBadge({ scene }: { scene: Pick<Scene, 'state' | 'verdict' | 'job'> }) {
  if (scene.state === 'deleted') return <Badge tone="plain">Deleted</Badge>;
  if (scene.verdict === 'pass') return <Badge tone="good">Pass</Badge>;
  if (scene.verdict === 'quarantine') return <Badge tone="warn">Quarantine</Badge>;
  if (scene.state === 'failed') return <Badge tone="bad">{scene.job?.state === 'cancelled' ? 'Canceled' : 'Failed'}</Badge>;
  if (scene.job?.state === 'running') return <Badge tone="busy">Running</Badge>;
  if (scene.job?.state === 'cancelled') return <Badge tone="bad">Canceled</Badge>;
  return <Badge tone="busy">Waiting</Badge>;
}

/** Copies a text, also where the browser has no clipboard interface (pages without https). */
async function copyText(text: string): Promise<void> {
  if (navigator.clipboard) return navigator.clipboard.writeText(text);
  const area = document.createElement('textarea');
  area.value = text;
  document.body.append(area);
  area.select();
  const copied = document.execCommand('copy');
  area.remove();
  if (!copied) throw new Error('The browser did not copy; select the text and copy it by hand.');
}

export function CopyButton({ text, label = 'Copy' }: { text: string; label?: string }) {
  const [done, setDone] = useState(false);
  const timer = useRef<ReturnType<typeof setTimeout>>(undefined);
  const copy = async () => {
    try {
      await copyText(text);
      setDone(true);
      clearTimeout(timer.current);
      timer.current = setTimeout(() => setDone(false), 1500);
    } catch (error) {
      announce((error as Error).message, 'bad');
    }
  };
  return (
    <button type="button" class="quiet" onClick={copy}>
      {done ? 'Copied' : label}
    </button>
  );
}

/** Tabs that arrow keys move through. */
export function Tabs<T extends string>({
  tabs,
  value,
  onChange,
  label,
}: {
  tabs: { id: T; title: string }[];
  value: T;
  onChange: (id: T) => void;
  label: string;
}) {
  const move = (event: KeyboardEvent) => {
    const step = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
    if (!step) return;
    event.preventDefault();
    const next = tabs[(tabs.findIndex((tab) => tab.id === value) + step + tabs.length) % tabs.length]!;
    onChange(next.id);
    (event.currentTarget as HTMLElement).querySelector<HTMLElement>(`#tab-${next.id}`)?.focus();
  };
  return (
    <div class="tabs" role="tablist" aria-label={label} onKeyDown={move}>
      {tabs.map((tab) => (
        <button
          key={tab.id}
          type="button"
          role="tab"
          id={`tab-${tab.id}`}
          aria-selected={tab.id === value}
          aria-controls={`panel-${tab.id}`}
          tabIndex={tab.id === value ? 0 : -1}
          onClick={() => onChange(tab.id)}
        >
          {tab.title}
        </button>
      ))}
    </div>
  );
}

export function Panel({ id, children }: { id: string; children: ComponentChildren }) {
  return (
    <div role="tabpanel" id={`panel-${id}`} aria-labelledby={`tab-${id}`} class="panel" tabIndex={0}>
      {children}
    </div>
  );
}

/** A table that scrolls by itself on narrow screens. */
export function Table({ head, children, caption }: { head: string[]; children: ComponentChildren; caption: string }) {
  return (
    <div class="table" role="region" aria-label={caption} tabIndex={0}>
      <table>
        <caption class="unseen">{caption}</caption>
        <thead>
          <tr>
            {head.map((title, index) =>
              title ? (
                <th key={index} scope="col">
                  {title}
                </th>
              ) : (
                <td key={index} />
              ),
            )}
          </tr>
        </thead>
        <tbody>{children}</tbody>
      </table>
    </div>
  );
}

/** Button that loads the next page of a list. */
export function More({ token, busy, load }: { token: string | null | undefined; busy: boolean; load: () => void }) {
  if (!token) return null;
  return (
    <button type="button" class="more" disabled={busy} onClick={load}>
      {busy ? 'Loading…' : 'Show more'}
    </button>
  );
}
