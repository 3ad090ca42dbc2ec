/** Who uses the page, and the dialog for the login. */
import { signal } from '@preact/signals';
import { useState } from 'preact/hooks';
import { getJson, loggedIn, loginNeeded, sendJson } from './api/fetch';
import type { Scope, Session } from './api/types';
import { Dialog } from './ui/dialog';

export const session = signal<Session | undefined>(undefined);

/** Whether the one who uses the page may do what a scope covers. */
export function may(scope: Scope): boolean {
  return session.value?.scopes.includes(scope) ?? false;
}

export async function loadSession(): Promise<void> {
  try {
    session.value = await getJson<Session>('/session');
  } catch (error) {
    if ((error as { status?: number }).status !== 401) throw error;
    loginNeeded.value = true;
  }
}

/** Tabs of a browser have one session: a login in one of them is one in all. */
const channel = new BroadcastChannel('tabletopgen-session');
channel.onmessage = () => {
  if (loginNeeded.value) void loadSession().then(loggedIn);
};

export async function logOut(): Promise<void> {
  await sendJson('DELETE', '/session');
  location.reload();
}

/** Asks for a key over whatever page is open; the page goes on where it was. */
export function Login() {
  const [key, setKey] = useState('');
  const [error, setError] = useState('');
  const [busy, setBusy] = useState(false);
  if (!loginNeeded.value) return null;
  const submit = async (event: Event) => {
    event.preventDefault();
    setBusy(true);
    setError('');
    try {
      await sendJson('POST', '/session', { key: key.trim() });
      setKey('');
      await loadSession();
      loggedIn();
      channel.postMessage('logged in');
    } catch (refused) {
      setError((refused as Error).message);
    }
    setBusy(false);
  };
  return (
    <Dialog title="Log in" closable={false} onClose={() => {}}>
      <form onSubmit={submit} class="stack">
        <p>This server asks for a key. The browser keeps a session, not the key, and your page stays as it is.</p>
        <label>
          Key
          <input
            type="password"
            autoComplete="current-password"
            placeholder="tt_…"
            required
            value={key}
            onInput={(event) => setKey(event.currentTarget.value)}
            aria-invalid={error !== ''}
            aria-describedby="login-error"
          />
        </label>
        <p id="login-error" class="field-error" role="alert">
          {error}
        </p>
        <button type="submit" class="primary" disabled={busy}>
          {busy ? 'Checking…' : 'Log in'}
        </button>
        <p class="hint">
          An operator makes keys with <code>tabletopgen keys create</code>, or on the page Operate.
        </p>
      </form>
    </Dialog>
  );
}
