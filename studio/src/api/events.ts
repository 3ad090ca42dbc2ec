/**
 * One stream of events for all tabs of a browser.
 *
 * A browser opens at most six connections to a server of HTTP/1.1, and each stream occupies one. The tab that holds the
 * lock has the stream and passes events on to the others. Where the browser has no locks (a page without https at
 * another host than this computer), a tab has its own stream while it is visible.
 */
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { askForLogin } from './fetch';
import type { TenantEvent } from './types';

export type StreamState = 'connecting' | 'live' | 'interrupted';
export const streamState = signal<StreamState>('connecting');

const listeners = new Set<(event: TenantEvent | 'anything') => void>();
const channel = new BroadcastChannel('tabletopgen-events');

/** Tells the parts of the page what happened, or that anything may have happened. */
function tell(event: TenantEvent | 'anything'): void {
  for (const listener of listeners) listener(event);
}

/** Id of the last event, from which a new leader goes on. */
let cursor = '';

type Message = { event: TenantEvent; id: string } | { state: StreamState; id: string; isBack?: boolean } | 'how is it?';

/** Whether this tab has the stream. */
let leads = false;

channel.onmessage = ({ data }: MessageEvent<Message>) => {
  if (data === 'how is it?') {
    if (leads) share(streamState.value);
    return;
  }
  cursor = data.id;
  if ('state' in data) {
    streamState.value = data.state;
    if (data.isBack) tell('anything');
  } else {
    streamState.value = 'live';
    tell(data.event);
  }
};

function share(state: StreamState, isBack = false): void {
  streamState.value = state;
  channel.postMessage({ state, id: cursor, isBack } satisfies Message);
  if (isBack) tell('anything');
}

/** Keeps a stream open until `ended`; after a refusal it asks whether the login has ended. */
async function stream(ended: AbortSignal): Promise<void> {
  leads = true;
  while (!ended.aborted) {
    await new Promise<void>((closed) => {
      const source = new EventSource(cursor ? `/events?after=${encodeURIComponent(cursor)}` : '/events');
      const close = () => {
        source.close();
        closed();
      };
      ended.addEventListener('abort', close, { once: true });
      // Meanwhile requests may have failed, and a stream that knows no event yet begins with the next one.
      source.onopen = () => share('live', streamState.value !== 'connecting');
      source.onerror = () => {
        share('interrupted');
        if (source.readyState === EventSource.CLOSED) close();
      };
      const receive = (message: MessageEvent<string>) => {
        cursor = message.lastEventId;
        const event: TenantEvent = JSON.parse(message.data);
        channel.postMessage({ event, id: cursor } satisfies Message);
        tell(event);
      };
      for (const kind of KINDS) source.addEventListener(kind, receive);
      source.onmessage = receive;
    });
    if (ended.aborted) return;
    const session = await fetch('/session').catch(() => undefined);
    if (session?.status === 401) await askForLogin();
    else await new Promise((resolve) => setTimeout(resolve, 5000));
  }
}

/** The names of events of jobs and of recordings; an EventSource tells only of names that it is asked for. */
const KINDS: TenantEvent['kind'][] = [
  'job_queued',
  'job_started',
  'job_retrying',
  'job_orphaned',
  'job_released',
  'job_cancelling',
  'job_cancelled',
  'job_failed',
  'job_succeeded',
  'stage_started',
  'stage_progress',
  'stage_finished',
  'queued',
  'running',
  'attempt',
  'attempt_lost',
  'restarted',
  'assembling',
  'finished',
  'failed',
  'cancelled',
];

/** Begins to listen; called once. */
export function listen(): void {
  channel.postMessage('how is it?' satisfies Message);
  if (navigator.locks) {
    void navigator.locks.request('tabletopgen-events', () => stream(new AbortController().signal));
    return;
  }
  let control: AbortController | undefined;
  const follow = () => {
    control?.abort();
    control = undefined;
    if (document.visibilityState === 'visible') void stream((control = new AbortController()).signal);
  };
  document.addEventListener('visibilitychange', follow);
  follow();
}

/** Calls `react` at events that `concerns` selects and after interruptions, at most once in `pause` milliseconds. */
export function useEvents(concerns: (event: TenantEvent) => boolean, react: () => void, inputs: unknown[], pause = 250): void {
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    const listener = (event: TenantEvent | 'anything') => {
      if (event !== 'anything' && !concerns(event)) return;
      timer ??= setTimeout(() => {
        timer = undefined;
        react();
      }, pause);
    };
    listeners.add(listener);
    return () => {
      listeners.delete(listener);
      clearTimeout(timer);
    };
  }, inputs);
}
