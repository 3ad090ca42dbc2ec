/** The address of the page: `/studio/...`, kept in the history of the browser. */
import { signal } from '@preact/signals';

const BASE = '/studio';

export interface Address {
  /** Path below `/studio`, such as `/scenes/ID`. */
  path: string;
  query: URLSearchParams;
}

function current(): Address {
  const path = location.pathname.startsWith(BASE) ? location.pathname.slice(BASE.length) : '/';
  return { path: path.replace(/\/+$/, '') || '/', query: new URLSearchParams(location.search) };
}

export const address = signal<Address>(current());

addEventListener('popstate', () => {
  address.value = current();
});

/** Where a link to a path below `/studio` leads. */
export function href(path: string): string {
  return BASE + path;
}

export function navigate(path: string): void {
  history.pushState(null, '', href(path));
  const before = address.value.path;
  address.value = current();
  if (address.value.path !== before) {
    scrollTo(0, 0);
    // A reader of the screen goes on at the top of the new page.
    document.querySelector<HTMLElement>('main')?.focus({ preventScroll: true });
  }
}

/** Changes parameters of the address in place; an empty value removes one. */
export function setQuery(changes: Record<string, string>): void {
  const query = new URLSearchParams(address.value.query);
  for (const [name, value] of Object.entries(changes)) {
    if (value) query.set(name, value);
    else query.delete(name);
  }
  const text = query.toString();
  history.replaceState(null, '', location.pathname + (text ? `?${text}` : ''));
  address.value = current();
}

/** Follows links within the page without loading it again. */
export function followLinks(): void {
  addEventListener('click', (event) => {
    if (event.defaultPrevented || event.button !== 0 || event.metaKey || event.ctrlKey || event.shiftKey) return;
    const link = (event.target as Element).closest?.('a');
    if (!link || link.target || link.hasAttribute('download') || link.origin !== location.origin) return;
    if (!link.pathname.startsWith(`${BASE}/`)) return;
    event.preventDefault();
    navigate(link.pathname.slice(BASE.length) + link.search);
  });
}
