/** The frame of all pages: navigation, session, login and help. */
import type { ComponentType } from 'preact';
import { useEffect, useState } from 'preact/hooks';
import { streamState } from './api/events';
import { Help, helpOpen } from './keys';
import { Submit } from './pages/submit';
import { address, href } from './router';
import { logOut, Login, session } from './session';
import { Announcements } from './ui/announce';
import { Failed, Waiting } from './ui/parts';

interface Route {
  pattern: RegExp;
  title: string;
  load: () => Promise<{ default: ComponentType<{ id: string }> }>;
}

/** Pages that are loaded when they are opened. */
const ROUTES: Route[] = [
  { pattern: /^\/scenes\/([0-9a-f-]{36})$/, title: 'Scene', load: () => import('./pages/scene') },
  { pattern: /^\/gallery$/, title: 'Gallery', load: () => import('./pages/gallery') },
  { pattern: /^\/batches$/, title: 'Batches', load: () => import('./pages/batches') },
  { pattern: /^\/batches\/([0-9a-f-]{36})$/, title: 'Batch', load: () => import('./pages/batch') },
  { pattern: /^\/recordings$/, title: 'Recordings', load: () => import('./pages/recordings') },
  { pattern: /^\/recordings\/([0-9a-f-]{36})$/, title: 'Recording', load: () => import('./pages/recording') },
  { pattern: /^\/executions\/([0-9a-f-]{36})$/, title: 'Execution', load: () => import('./pages/execution') },
  { pattern: /^\/datasets$/, title: 'Datasets', load: () => import('./pages/datasets') },
  { pattern: /^\/datasets\/([0-9a-f-]{36})$/, title: 'Dataset', load: () => import('./pages/dataset') },
  { pattern: /^\/operate$/, title: 'Operate', load: () => import('./pages/operate') },
];

const LINKS = [
  { path: '/', title: 'New scene' },
  { path: '/gallery', title: 'Gallery' },
  { path: '/batches', title: 'Batches' },
  { path: '/recordings', title: 'Recordings' },
  { path: '/datasets', title: 'Datasets' },
  { path: '/operate', title: 'Operate' },
];

function Later({ route, id }: { route: Route; id: string }) {
  const [Page, setPage] = useState<ComponentType<{ id: string }>>();
  const [error, setError] = useState<Error>();
  useEffect(() => {
    let left = false;
    route.load().then(
      (module) => !left && setPage(() => module.default),
      () => !left && setError(new Error('This part of the page did not load. The server may have been updated: load the page again.')),
    );
    return () => {
      left = true;
    };
  }, [route]);
  if (error) return <Failed error={error} again={() => location.reload()} />;
  return Page ? <Page id={id} key={id} /> : <Waiting what="the page" />;
}

function Page() {
  const { path } = address.value;
  const found = ROUTES.map((route) => ({ route, match: route.pattern.exec(path) })).find((one) => one.match);
  useEffect(() => {
    const title = path === '/' ? 'New scene' : (found?.route.title ?? 'Not found');
    document.title = `${title} · tabletopgen`;
  }, [path]);
  if (path === '/') return <Submit />;
  if (found) return <Later route={found.route} id={found.match![1] ?? ''} key={found.route.title} />;
  return (
    <>
      <h1>Not found</h1>
      <p>
        There is no page at this address. <a href={href('/')}>Make a scene</a> or open the <a href={href('/gallery')}>gallery</a>.
      </p>
    </>
  );
}

const STREAM = { connecting: 'Connecting to the server', live: 'Connected', interrupted: 'No connection; the page tries again' };

export function App() {
  const { path } = address.value;
  const who = session.value;
  return (
    <>
      <a
        class="skip"
        href="#main"
        onClick={(event) => {
          event.preventDefault();
          document.getElementById('main')?.focus();
        }}
      >
        Skip to the content
      </a>
      <header class="bar">
        <a class="name" href={href('/')}>
          <img src="/studio/icon.svg" alt="" width="20" height="20" /> tabletopgen
        </a>
        <nav aria-label="Pages">
          {LINKS.map((link) => (
            <a
              key={link.path}
              href={href(link.path)}
              aria-current={path === link.path || (link.path !== '/' && path.startsWith(`${link.path}/`)) ? 'page' : undefined}
            >
              {link.title}
            </a>
          ))}
        </nav>
        <span class={`stream ${streamState.value}`} title={STREAM[streamState.value]}>
          <span class="unseen">{STREAM[streamState.value]}</span>
        </span>
        {who?.kind === 'session' && (
          <button type="button" class="quiet who" onClick={() => void logOut()} title={`${who.principal}, ${who.tenant}`}>
            Log out
          </button>
        )}
        <button type="button" class="quiet" onClick={() => (helpOpen.value = true)} aria-label="Keys and help">
          ?
        </button>
      </header>
      <main id="main" tabIndex={-1}>
        <Page />
      </main>
      <Announcements />
      <Login />
      <Help />
    </>
  );
}
