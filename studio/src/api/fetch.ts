/** Requests to the server: problem documents become errors, and 401 waits for the login dialog. */
import { signal } from '@preact/signals';
import type { FieldError } from './types';

/** A refusal of the server, with its problem document (RFC 9457). */
export class Refusal extends Error {
  constructor(
    readonly status: number,
    readonly code: string,
    readonly title: string,
    detail: string,
    readonly errors: FieldError[],
  ) {
    super(detail);
  }

  /** The sentence beside a field of the request, by its JSON pointer. */
  at(pointer: string): string | undefined {
    return this.errors.find((error) => error.pointer === pointer)?.detail;
  }
}

/** Whether the dialog for the login is open. */
export const loginNeeded = signal(false);

let waiting: (() => void)[] = [];

/** Lets requests that were refused for want of a login go on. */
export function loggedIn(): void {
  loginNeeded.value = false;
  for (const resume of waiting.splice(0)) resume();
}

/** Opens the login dialog, and ends with the login. */
export function askForLogin(): Promise<void> {
  loginNeeded.value = true;
  return new Promise((resolve) => waiting.push(resolve));
}

async function refusal(response: Response): Promise<Refusal> {
  const text = await response.text();
  try {
    const problem = JSON.parse(text);
    const title = String(problem.title ?? response.statusText);
    return new Refusal(response.status, String(problem.code ?? ''), title, String(problem.detail ?? title), problem.errors ?? []);
  } catch {
    const detail = `The server answered ${response.status} ${response.statusText} without a reason.`;
    return new Refusal(response.status, '', response.statusText, detail, []);
  }
}

/** Sends a request to this server, and throws a [`Refusal`] unless it succeeds. */
export async function request(path: string, init: RequestInit = {}): Promise<Response> {
  for (;;) {
    let response: Response;
    try {
      response = await fetch(path, { credentials: 'same-origin', ...init });
    } catch (error) {
      if (init.signal?.aborted) throw error;
      throw new Refusal(0, 'unreachable', 'No answer', 'The server does not answer. Check that it runs, then try again.', []);
    }
    if (response.ok) return response;
    if (response.status !== 401 || path === '/session') throw await refusal(response);
    await askForLogin();
  }
}

export async function getJson<T>(path: string, signal?: AbortSignal): Promise<T> {
  const response = await request(path, { headers: { accept: 'application/json' }, ...(signal && { signal }) });
  return response.json();
}

/** The answer to a change; `undefined` where the server sends no content. */
export async function sendJson<T>(
  method: 'POST' | 'PATCH' | 'DELETE',
  path: string,
  body?: unknown,
  headers: Record<string, string> = {},
  signal?: AbortSignal,
): Promise<T> {
  const type: Record<string, string> = body === undefined ? {} : { 'content-type': 'application/json' };
  const response = await request(path, {
    method,
    headers: { accept: 'application/json', ...type, ...headers },
    ...(body !== undefined && { body: JSON.stringify(body) }),
    ...(signal && { signal }),
  });
  return response.status === 204 ? (undefined as T) : response.json();
}

/** A header that makes a repeated submission have one effect. */
export function idempotencyKey(): Record<string, string> {
  // `crypto.randomUUID` does not exist on pages without https.
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return { 'idempotency-key': Array.from(bytes, (byte) => byte.toString(16).padStart(2, '0')).join('') };
}

/** A path with the parameters that have a value. */
export function withQuery(path: string, query: Record<string, string | number | null | undefined>): string {
  const search = new URLSearchParams();
  for (const [name, value] of Object.entries(query)) {
    if (value !== undefined && value !== null && value !== '') search.set(name, String(value));
  }
  const text = search.toString();
  return text ? `${path}?${text}` : path;
}
