/** Lists that come in pages. */
import { useState } from 'preact/hooks';
import { getJson, withQuery } from './api/fetch';
import { useLoad } from './load';

export interface Paged<T> {
  items: T[];
  /** Whether the first page has come. */
  ready: boolean;
  loading: boolean;
  error: Error | undefined;
  next: string | null;
  more: () => void;
  reload: () => void;
}

/** Items of `path`, which are under `name` in each page. */
export function usePaged<T>(path: string, name: string): Paged<T> {
  const [pages, setPages] = useState(1);
  const list = useLoad(`${path} ${pages}`, async (signal) => {
    const items: T[] = [];
    let token: string | null = null;
    for (let page = 0; page < pages; page++) {
      const answer: Record<string, unknown> = await getJson(withQuery(path, { page_token: token }), signal);
      items.push(...(answer[name] as T[]));
      token = (answer.next_page_token as string | null | undefined) ?? null;
      if (!token) break;
    }
    return { items, token };
  });
  const [kept, setKept] = useState<{ path: string; items: T[]; token: string | null }>();
  // While more pages load, those that are there stay.
  if (list.value && (kept?.path !== path || kept.items !== list.value.items)) setKept({ path, ...list.value });
  const shown = list.value ?? (kept?.path === path ? kept : undefined);
  return {
    items: shown?.items ?? [],
    ready: shown !== undefined,
    loading: list.loading,
    error: list.error,
    next: shown?.token ?? null,
    more: () => setPages((old) => old + 1),
    reload: list.reload,
  };
}
