/** Loading of data for a component, with its refusal and a way to load again. */
import { useCallback, useEffect, useRef, useState } from 'preact/hooks';

export interface Loaded<T> {
  value: T | undefined;
  error: Error | undefined;
  loading: boolean;
  reload: () => void;
  /** Replaces the value at once, for a change that the server will confirm. */
  set: (value: T) => void;
}

/** Loads when `key` changes, and keeps the value of the same key while it loads again. A null key loads nothing. */
export function useLoad<T>(key: string | null, load: (signal: AbortSignal) => Promise<T>): Loaded<T> {
  const [state, setState] = useState<{ key: string | null; value?: T; error?: Error; loading: boolean }>({
    key: null,
    loading: key !== null,
  });
  const [round, setRound] = useState(0);
  const latest = useRef(load);
  latest.current = load;
  useEffect(() => {
    if (key === null) return;
    const control = new AbortController();
    setState((old) => (old.key === key ? { ...old, loading: true } : { key, loading: true }));
    latest.current(control.signal).then(
      (value) => !control.signal.aborted && setState({ key, value, loading: false }),
      (error) =>
        !control.signal.aborted &&
        setState((old) => ({ key, ...(old.value !== undefined && { value: old.value }), error, loading: false })),
    );
    return () => control.abort();
  }, [key, round]);
  const reload = useCallback(() => setRound((old) => old + 1), []);
  const set = useCallback((value: T) => setState((old) => ({ ...old, value })), []);
  const fresh = state.key === key;
  return {
    value: fresh ? state.value : undefined,
    error: fresh ? state.error : undefined,
    loading: key !== null && (!fresh || state.loading),
    reload,
    set,
  };
}

/** Calls `run` once, `delay` milliseconds after the last change of `inputs`. */
export function useSettled(inputs: unknown[], delay: number, run: (signal: AbortSignal) => void): void {
  useEffect(() => {
    const control = new AbortController();
    const timer = setTimeout(() => run(control.signal), delay);
    return () => {
      clearTimeout(timer);
      control.abort();
    };
  }, inputs);
}
