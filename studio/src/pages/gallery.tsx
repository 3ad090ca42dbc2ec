/** All scenes: filters and facets in the address, and the review by keys. */
import { useEffect, useRef, useState } from 'preact/hooks';
import { useEvents } from '../api/events';
import { getJson, withQuery } from '../api/fetch';
import type { Scene, SceneFacets, ScenePage } from '../api/types';
import { ago, count } from '../format';
import { type Filter, FILTERS, filterOf, label, searchOf } from '../gallery/filters';
import { useShortcuts } from '../keys';
import { useLoad } from '../load';
import { address, href, navigate, setQuery } from '../router';
import * as review from '../review';
import { titleOf } from '../scene/title';
import { may } from '../session';
import { announce } from '../ui/announce';
import { Badge, Empty, Failed, More, SceneBadge, Waiting } from '../ui/parts';
import { Thumbnail } from '../ui/thumbnail';

const PAGE_SIZE = 48;

export default function Gallery() {
  const filter = filterOf(address.value.query);
  const search = searchOf(filter);
  const list = useScenes(search);
  const facets = useLoad(withQuery('/scenes/facets', search), (signal) => getJson<SceneFacets>(withQuery('/scenes/facets', search), signal));
  useEvents(
    (event) => event.kind.startsWith('job_'),
    () => {
      list.refresh();
      facets.reload();
    },
    [JSON.stringify(search)],
    2000,
  );
  const { at, choose, decide, note, step } = useReview(list);
  useShortcuts(
    [
      { key: 'n', what: 'Next scene', run: () => step(1) },
      { key: 'b', what: 'Scene before', run: () => step(-1) },
      { key: 'a', what: 'Accept the scene, and go to the next', run: () => decide('accept') },
      { key: 'r', what: 'Reject the scene, and go to the next', run: () => decide('reject') },
      { key: 'o', what: 'Write a note', run: note },
      { key: 'Enter', what: 'Open the scene', run: () => list.scenes[at] && navigate(`/scenes/${list.scenes[at].id}`) },
    ],
    [at, list.scenes],
  );
  return (
    <div class="gallery">
      <header class="row">
        <h1>Gallery</h1>
        {facets.value && <span class="hint">{count(facets.value.total, 'scene')}</span>}
        <span class="spring" />
        <span class="hint keys-hint">
          <kbd>n</kbd> next, <kbd>a</kbd> accept, <kbd>r</kbd> reject, <kbd>o</kbd> note
        </span>
      </header>
      <div class="with-side">
        <Side filter={filter} facets={facets.value} />
        <div>
          <Chosen filter={filter} />
          {list.error && <Failed error={list.error} again={list.refresh} />}
          {!list.error && list.loading && list.scenes.length === 0 && <Waiting what="scenes" />}
          {!list.error && !list.loading && list.scenes.length === 0 && (
            <Empty>
              {Object.keys(search).length ? (
                'No scene fits these filters.'
              ) : (
                <>
                  There are no scenes yet. <a href={href('/')}>Make the first one.</a>
                </>
              )}
            </Empty>
          )}
          <ul class="cards" aria-label="Scenes">
            {list.scenes.map((scene, index) => (
              <Card key={scene.id} scene={scene} current={index === at} onFocus={() => choose(scene.id)} />
            ))}
          </ul>
          <More token={list.next} busy={list.loading} load={list.more} />
        </div>
      </div>
    </div>
  );
}

interface SceneList {
  scenes: Scene[];
  next: string | null;
  loading: boolean;
  error: Error | undefined;
  more: () => void;
  refresh: () => void;
  replace: (scene: Scene) => void;
}

function useScenes(search: Record<string, string>): SceneList {
  const key = JSON.stringify(search);
  const first = useLoad(key, (signal) => getJson<ScenePage>(withQuery('/scenes', { ...search, page_size: PAGE_SIZE }), signal));
  const [rest, setRest] = useState<{ key: string; scenes: Scene[]; next: string | null }>();
  const [busy, setBusy] = useState(false);
  const [changed, setChanged] = useState<Map<string, Scene>>(new Map());
  // A new first page confirms what was changed there; later pages stay as they were loaded.
  useEffect(() => {
    const confirmed = new Set(first.value?.scenes.map((scene) => scene.id));
    setChanged((old) => new Map([...old].filter(([id]) => !confirmed.has(id))));
  }, [first.value]);
  const later = rest?.key === key ? rest : undefined;
  const known = new Set(first.value?.scenes.map((scene) => scene.id));
  const scenes = [...(first.value?.scenes ?? []), ...(later?.scenes.filter((scene) => !known.has(scene.id)) ?? [])].map(
    (scene) => changed.get(scene.id) ?? scene,
  );
  const next = later ? later.next : (first.value?.next_page_token ?? null);
  return {
    scenes,
    next,
    loading: first.loading || busy,
    error: first.error,
    refresh: first.reload,
    replace: (scene) => setChanged((old) => new Map(old).set(scene.id, scene)),
    more: () => {
      setBusy(true);
      getJson<ScenePage>(withQuery('/scenes', { ...search, page_size: PAGE_SIZE, page_token: next }))
        .then(
          // The first page is kept too: new scenes push its last ones out of it.
          (page) =>
            setRest({
              key,
              scenes: [...(later?.scenes ?? first.value?.scenes ?? []), ...page.scenes],
              next: page.next_page_token ?? null,
            }),
          (error: Error) => announce(error.message, 'bad'),
        )
        .finally(() => setBusy(false));
    },
  };
}

/** The scene that keys act on. A decision shows at once, and is taken back if the server refuses it. */
function useReview(list: SceneList) {
  // New scenes move the others on, so the scene is known by its id. Keys come quicker than drawings: the reference is
  // what holds.
  const chosen = useRef<string>(undefined);
  const [, draw] = useState<string>();
  const latest = useRef(list);
  latest.current = list;
  const place = () => Math.max(0, latest.current.scenes.findIndex((scene) => scene.id === chosen.current));
  const choose = (id: string) => {
    chosen.current = id;
    draw(id);
  };
  const step = (by: number) => {
    const { scenes } = latest.current;
    const index = Math.min(Math.max(place() + by, 0), scenes.length - 1);
    if (!scenes[index]) return;
    choose(scenes[index].id);
    document.querySelectorAll<HTMLElement>('.gallery .cards > li > a')[index]?.focus();
  };
  const set = (labels: Record<string, string | null>) => {
    const scene = latest.current.scenes[place()];
    if (!scene || !may('submit')) return;
    const merged = Object.fromEntries(Object.entries({ ...scene.labels, ...labels }).filter(([, value]) => value !== null)) as Record<
      string,
      string
    >;
    list.replace({ ...scene, labels: merged });
    review.label(scene.id, labels).then(list.replace, (error: Error) => {
      list.replace(scene);
      announce(`The review was not kept: ${error.message}`, 'bad');
    });
  };
  const decide = (decision: review.Decision) => {
    set({ [review.REVIEW]: decision });
    step(1);
  };
  const note = () => {
    const scene = latest.current.scenes[place()];
    if (!scene) return;
    const text = prompt('Note about this scene', scene.labels[review.NOTE] ?? '');
    if (text !== null) set({ [review.NOTE]: text.trim() || null });
  };
  return { at: place(), choose, step, decide, note };
}

function Card({ scene, current, onFocus }: { scene: Scene; current: boolean; onFocus: () => void }) {
  const decision = scene.labels[review.REVIEW];
  return (
    <li class={`card scene ${current ? 'current' : ''}`}>
      <a href={href(`/scenes/${scene.id}`)} onFocus={onFocus} aria-current={current ? 'true' : undefined}>
        <Thumbnail scene={scene} />
        <span class="scene-title">{titleOf(scene)}</span>
      </a>
      <p class="row">
        <SceneBadge scene={scene} />
        {decision === 'accept' && <Badge tone="good">accepted</Badge>}
        {decision === 'reject' && <Badge tone="bad">rejected</Badge>}
      </p>
      <p class="row hint number">
        <span>
        {scene.summary?.objects !== undefined && count(scene.summary.objects, 'object')}
        {scene.labels[review.NOTE] && <em title={scene.labels[review.NOTE]}>, “{scene.labels[review.NOTE]}”</em>}
        </span>
        <span class="spring" />
        <time dateTime={scene.created_at}>{ago(scene.created_at)}</time>
      </p>
    </li>
  );
}

/** Search, ranges, and facets with their counts. */
function Side({ filter, facets }: { filter: Filter; facets: SceneFacets | undefined }) {
  const [text, setText] = useState(filter.q ?? '');
  const [open, setOpen] = useState(() => matchMedia('(min-width: 900px)').matches);
  useEffect(() => setText(filter.q ?? ''), [filter.q]);
  return (
    <aside aria-label="Filters">
      <form
        role="search"
        onSubmit={(event) => {
          event.preventDefault();
          setQuery({ q: text.trim() });
        }}
      >
        <label>
          <span class="unseen">Words of the request</span>
          <input
            type="search"
            placeholder="Words of the request"
            value={text}
            onInput={(event) => setText(event.currentTarget.value)}
            onBlur={() => text !== (filter.q ?? '') && setQuery({ q: text.trim() })}
          />
        </label>
      </form>
      <details open={open} onToggle={(event) => setOpen(event.currentTarget.open)}>
        <summary>Filters</summary>
        <div class="side">
          <div class="row objects">
            <span id="objects-label">Objects</span>
            {(['min_objects', 'max_objects'] as const).map((name) => (
              <input
                key={name}
                type="number"
                class="small"
                min={0}
                placeholder={name === 'min_objects' ? 'from' : 'to'}
                aria-label={name === 'min_objects' ? 'Fewest objects' : 'Most objects'}
                value={filter[name] ?? ''}
                onChange={(event) => setQuery({ [name]: event.currentTarget.value })}
              />
            ))}
          </div>
          <label class="row objects">
            Order
            <select
              value={filter.sort ?? 'newest'}
              onChange={(event) => setQuery({ sort: event.currentTarget.value === 'newest' ? '' : event.currentTarget.value })}
            >
              <option value="newest">newest first</option>
              <option value="oldest">oldest first</option>
            </select>
          </label>
          {FILTERS.filter((one) => one.facet).map(({ name, title }) => (
            <Facet
              key={name}
              name={name}
              title={title}
              chosen={filter[name]}
              counts={facets?.[name as keyof SceneFacets] as Record<string, number> | undefined}
            />
          ))}
        </div>
      </details>
    </aside>
  );
}

const SHOWN = 8;

function Facet({
  name,
  title,
  chosen,
  counts,
}: {
  name: string;
  title: string;
  chosen: string | undefined;
  counts: Record<string, number> | undefined;
}) {
  const [all, setAll] = useState(false);
  const entries = Object.entries(counts ?? {})
    .filter(([, number]) => number > 0)
    .sort((a, b) => b[1] - a[1]);
  if (!entries.length) return null;
  return (
    <fieldset class="facet">
      <legend>{title}</legend>
      <ul>
        {entries.slice(0, all ? undefined : SHOWN).map(([value, number]) => {
          const isChosen = chosen === label.toFilter(name, value);
          return (
            <li key={value}>
              <button
                type="button"
                aria-pressed={isChosen}
                onClick={() => setQuery({ [name]: isChosen ? '' : label.toFilter(name, value) })}
              >
                <span>{name === 'label' ? value : value.replaceAll('_', ' ')}</span>
                <span class="number">{number}</span>
              </button>
            </li>
          );
        })}
      </ul>
      {entries.length > SHOWN && (
        <button type="button" class="quiet" onClick={() => setAll(!all)}>
          {all ? 'Fewer' : `${entries.length - SHOWN} more`}
        </button>
      )}
    </fieldset>
  );
}

/** The filters that are set, each with a button that takes it away. */
function Chosen({ filter }: { filter: Filter }) {
  const set = FILTERS.filter(({ name }) => filter[name] && name !== 'sort');
  if (!set.length) return null;
  return (
    <p class="chips chosen">
      {set.map(({ name, title }) => (
        <button
          type="button"
          class="chip"
          key={name}
          onClick={() => setQuery({ [name]: '' })}
          aria-label={`Remove the filter ${title} ${filter[name]}`}
        >
          {title}: {filter[name]} <span aria-hidden="true">✕</span>
        </button>
      ))}
      <button type="button" class="quiet" onClick={() => setQuery(Object.fromEntries(FILTERS.map(({ name }) => [name, ''])))}>
        Remove all
      </button>
    </p>
  );
}
