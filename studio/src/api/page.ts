/** Answers of the routes that exist for the page. */

export interface SceneFiles {
  files: { name: string; size_bytes: number; sha256: string; media_type: string; link: string }[];
}

/** Counts of scenes by what the filters know. */
export interface Facets {
  total: number;
  state: Record<string, number>;
  verdict: Record<string, number>;
  kind: Record<string, number>;
  category: Record<string, number>;
  label: Record<string, number>;
}

/** What waits, what runs, and where. */
export interface Queue {
  paused: { reason: string; since: string } | null;
  kinds: { kind: string; waiting: number; running: number }[];
  workers: { id: string; since: string; jobs: { job_id: string; kind: string; scene_id: string | null; since: string }[] }[];
  storage: 'ok' | 'full' | 'unavailable';
}
