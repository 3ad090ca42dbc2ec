/** The first page: one field for a text or an image, the scene in progress, and recent scenes. */
import { useEffect, useRef, useState } from 'preact/hooks';
import { useEvents } from '../api/events';
import { getJson, Refusal, sendJson } from '../api/fetch';
import { optionsSchema, type Schema } from '../api/settings';
import type { Scene, ScenePage, TextAccount } from '../api/types';
import { ago, count } from '../format';
import { useShortcuts } from '../keys';
import { useLoad, useSettled } from '../load';
import { href } from '../router';
import { StageStrip } from '../scene/stage_strip';
import { hasFiles, isOver, titleOf } from '../scene/title';
import { may, session } from '../session';
import { type Draft, imageFault, submit, validate } from '../submit_scene';
import { partsOf, reasonInWords } from '../text_spans';
import { announce } from '../ui/announce';
import { OptionsForm, type Values } from '../ui/options_form';
import { Failed, SceneBadge } from '../ui/parts';
import { Thumbnail } from '../ui/thumbnail';

const EXAMPLES = [
  'A round table with a bowl of three apples, two mugs and a teapot',
  'A desk with a laptop, a mug and two books',
  'Breakfast for two: plates with forks on the left and knives on the right',
];

export function Submit() {
  const [text, setText] = useState('');
  const [image, setImage] = useState<File>();
  const [seed, setSeed] = useState('');
  const [options, setOptions] = useState<Values>({});
  const [account, setAccount] = useState<TextAccount | null>(null);
  const [error, setError] = useState<Error>();
  const [sending, setSending] = useState<number>();
  const [current, setCurrent] = useState<string>();
  const field = useRef<HTMLTextAreaElement>(null);

  const draft: Draft = { text, image, seed: seed === '' ? undefined : Number(seed), options };
  const isEmpty = !text.trim() && !image;

  useSettled([text, seed, options, image], 300, (signal) => {
    if (!text.trim()) {
      setAccount(null);
      setError(undefined);
      return;
    }
    validate(draft, signal).then(
      (valid) => {
        setAccount(valid.text);
        setError(undefined);
      },
      (refused) => {
        if (signal.aborted) return;
        setAccount(null);
        setError(refused);
      },
    );
  });

  const take = (file: File | undefined) => {
    if (!file) return;
    const fault = imageFault(file, session.value?.limits);
    if (fault) announce(fault, 'bad');
    else setImage(file);
  };
  useShortcuts([{ key: '/', what: 'Write in the field', run: () => field.current?.focus() }], []);

  const send = async () => {
    if (isEmpty || sending !== undefined) return;
    setSending(0);
    setError(undefined);
    try {
      const scene = await submit(draft, setSending);
      setCurrent(scene.id);
    } catch (refused) {
      setError(refused as Error);
    }
    setSending(undefined);
  };

  const errorAt = (pointer: string) => (error instanceof Refusal ? error.at(pointer) : undefined);
  return (
    <div class="submit">
      <h1>New scene</h1>
      <DropTarget onFile={take} />
      <form
        class="composer card"
        onSubmit={(event) => {
          event.preventDefault();
          void send();
        }}
        onKeyDown={(event) => {
          if (event.key === 'Enter' && (event.ctrlKey || event.metaKey)) {
            event.preventDefault();
            void send();
          }
        }}
      >
        <label for="text" class="unseen">
          What is on the table
        </label>
        <div class="marked">
          <Marks text={text} account={account} />
          <textarea
            id="text"
            ref={field}
            rows={3}
            value={text}
            maxLength={session.value?.limits.max_text_chars}
            placeholder={image ? 'What is in the image (optional)' : 'What is on the table? Write a sentence, or drop or paste an image.'}
            onInput={(event) => setText(event.currentTarget.value)}
            aria-describedby="account"
            autofocus
          />
        </div>
        {image && <ImageChip file={image} onRemove={() => setImage(undefined)} />}
        <div class="row">
          <label class="button">
            Image…
            <input
              type="file"
              class="unseen"
              accept="image/png,image/jpeg,image/webp"
              onChange={(event) => {
                take(event.currentTarget.files?.[0]);
                event.currentTarget.value = '';
              }}
            />
          </label>
          <label class="inline">
            Seed
            <input
              type="number"
              min={0}
              step={1}
              placeholder="random"
              value={seed}
              onInput={(event) => setSeed(event.currentTarget.value)}
              class="seed"
            />
          </label>
          <span class="spring" />
          <span class="hint keys-hint">Ctrl + Enter</span>
          <button type="submit" class="primary" disabled={isEmpty || sending !== undefined || !may('submit')}>
            {sending === undefined ? 'Make the scene' : image ? `Sending ${Math.round(sending * 100)} %` : 'Sending…'}
          </button>
        </div>
        <OptionsDisclosure values={options} onChange={setOptions} errorAt={errorAt} />
      </form>
      <div id="account" aria-live="polite">
        {error ? <Failed error={error} /> : <Account text={text} account={account} onReplace={setText} />}
        {isEmpty && (
          <p class="examples">
            Try{' '}
            {EXAMPLES.map((example) => (
              <button type="button" class="quiet" key={example} onClick={() => setText(example)}>
                {example}
              </button>
            ))}
          </p>
        )}
      </div>
      {current && <Progress id={current} onClose={() => setCurrent(undefined)} />}
      <Recent current={current} />
    </div>
  );
}

/** The text behind the field, with the parts that have no effect underlined. */
function Marks({ text, account }: { text: string; account: TextAccount | null }) {
  return (
    <div class="marks" aria-hidden="true">
      {partsOf(text, account).map((part, index) => (part.kind === 'unrecognized' ? <mark key={index}>{part.text}</mark> : part.text))}
      {'\n'}
    </div>
  );
}

/** What the server makes of the text: the objects, and the words without effect. */
function Account({ text, account, onReplace }: { text: string; account: TextAccount | null; onReplace: (text: string) => void }) {
  if (!account) return null;
  const objects = new Map<string, number>();
  for (const part of account.understood) {
    if (part.category) objects.set(part.category, Math.max(objects.get(part.category) ?? 0, part.objects?.length ?? 1));
  }
  return (
    <div class="account">
      {objects.size > 0 && (
        <p class="chips">
          <span class="label">Understood</span>
          {[...objects].map(([category, number]) => (
            <span class="chip" key={category}>
              {number > 1 && <b>{number} × </b>}
              {category.replaceAll('_', ' ')}
            </span>
          ))}
          {account.stand_ins.length > 0 && (
            <span class="hint">{count(account.stand_ins.length, 'stand-in')} for what the catalog lacks</span>
          )}
        </p>
      )}
      {account.unrecognized.map((part) => {
        const nearest = part.nearest_by_spelling ?? part.nearest_by_meaning;
        return (
          <p key={part.span.start} class="without-effect">
            <mark>{part.span.text}</mark> has no effect: {reasonInWords(part.reason)}.{' '}
            {nearest && (
              <button type="button" class="quiet" onClick={() => onReplace(text.replace(part.span.text, nearest.replaceAll('_', ' ')))}>
                Use “{nearest.replaceAll('_', ' ')}”
              </button>
            )}
          </p>
        );
      })}
    </div>
  );
}

function ImageChip({ file, onRemove }: { file: File; onRemove: () => void }) {
  const [url, setUrl] = useState<string>();
  useEffect(() => {
    const made = URL.createObjectURL(file);
    setUrl(made);
    return () => URL.revokeObjectURL(made);
  }, [file]);
  return (
    <p class="image-chip">
      {url && <img src={url} alt="The image of the request" />}
      <span>{file.name}</span>
      <button type="button" class="quiet" onClick={onRemove}>
        Remove
      </button>
    </p>
  );
}

/** Takes files that are dropped anywhere on the page, or pasted. */
function DropTarget({ onFile }: { onFile: (file: File | undefined) => void }) {
  const [over, setOver] = useState(false);
  const latest = useRef(onFile);
  latest.current = onFile;
  useEffect(() => {
    const hasFile = (event: DragEvent) => event.dataTransfer?.types.includes('Files');
    const drag = (event: DragEvent) => {
      if (!hasFile(event)) return;
      event.preventDefault();
      setOver(true);
    };
    const leave = (event: DragEvent) => event.relatedTarget === null && setOver(false);
    const drop = (event: DragEvent) => {
      if (!hasFile(event)) return;
      event.preventDefault();
      setOver(false);
      latest.current(event.dataTransfer?.files[0]);
    };
    const paste = (event: ClipboardEvent) => latest.current([...(event.clipboardData?.files ?? [])][0]);
    addEventListener('dragover', drag);
    addEventListener('dragleave', leave);
    addEventListener('drop', drop);
    addEventListener('paste', paste);
    return () => {
      removeEventListener('dragover', drag);
      removeEventListener('dragleave', leave);
      removeEventListener('drop', drop);
      removeEventListener('paste', paste);
    };
  }, []);
  return over ? <div class="drop">Drop the image</div> : null;
}

function OptionsDisclosure({
  values,
  onChange,
  errorAt,
}: {
  values: Values;
  onChange: (values: Values) => void;
  errorAt: (pointer: string) => string | undefined;
}) {
  const [open, setOpen] = useState(false);
  const schema = useLoad(open ? '/settings/schema' : null, async (signal) =>
    optionsSchema(await getJson<Schema>('/settings/schema', signal)),
  );
  const changed = Object.keys(values).length;
  return (
    <details open={open} onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>Options{changed > 0 && ` (${changed} changed)`}</summary>
      {schema.error && <Failed error={schema.error} again={schema.reload} />}
      {schema.value && <OptionsForm schema={schema.value} values={values} onChange={onChange} errorAt={errorAt} />}
    </details>
  );
}

function Progress({ id, onClose }: { id: string; onClose: () => void }) {
  const scene = useLoad(`/scenes/${id}`, (signal) => getJson<Scene>(`/scenes/${id}`, signal));
  useEvents((event) => event.scene_id === id || event.job_id === scene.value?.job?.id, scene.reload, [id, scene.value?.job?.id]);
  const element = useRef<HTMLElement>(null);
  useEffect(() => {
    element.current?.scrollIntoView({ block: 'nearest' });
  }, [id]);
  if (scene.error && !scene.value) return <Failed error={scene.error} again={scene.reload} />;
  if (!scene.value) return null;
  const { job, failure } = scene.value;
  const over = isOver(scene.value);
  const cancel = async () => {
    try {
      await sendJson('POST', `/jobs/${job!.id}/cancel`);
      scene.reload();
    } catch (refused) {
      announce((refused as Error).message, 'bad');
    }
  };
  return (
    <section class="card progress" aria-label="Scene in progress" ref={element}>
      <header class="row">
        <SceneBadge scene={scene.value} />
        <a href={href(`/scenes/${id}`)} class="scene-title">
          {titleOf(scene.value)}
        </a>
        <span class="spring" />
        {!over && job && (
          <button type="button" onClick={() => void cancel()} disabled={job.state === 'cancelling'}>
            {job.state === 'cancelling' ? 'Canceling…' : 'Cancel'}
          </button>
        )}
        {over && hasFiles(scene.value) && (
          <a class="button primary" href={href(`/scenes/${id}`)}>
            Open the scene
          </a>
        )}
        {over && (
          <button type="button" class="quiet" onClick={onClose} aria-label="Close">
            ✕
          </button>
        )}
      </header>
      {failure && <p class={`notice ${hasFiles(scene.value) ? 'warn' : 'bad'}`}>{failure.message}</p>}
      {job?.queue_position !== undefined && job.state === 'queued' && (
        <p class="hint">Number {job.queue_position} of your scenes in the queue.</p>
      )}
      <StageStrip scene={scene.value} />
    </section>
  );
}

function Recent({ current }: { current: string | undefined }) {
  const path = '/scenes?page_size=9';
  const page = useLoad(`${path} ${current ?? ''}`, (signal) => getJson<ScenePage>(path, signal));
  useEvents((event) => event.kind.startsWith('job_'), page.reload, []);
  if (page.error) return <Failed error={page.error} again={page.reload} />;
  const scenes = page.value?.scenes.filter((scene) => scene.id !== current).slice(0, 8) ?? [];
  if (!scenes.length) return null;
  return (
    <section aria-label="Recent scenes" class="recent">
      <header class="row">
        <h2>Recent scenes</h2>
        <span class="spring" />
        <a href={href('/gallery')}>All scenes</a>
      </header>
      <ul class="cards">
        {scenes.map((scene) => (
          <li key={scene.id} class="card scene">
            <a href={href(`/scenes/${scene.id}`)}>
              <Thumbnail scene={scene} />
              <span class="scene-title">{titleOf(scene)}</span>
            </a>
            <p class="row">
              <SceneBadge scene={scene} />
              {scene.summary && <span class="hint">{count(scene.summary.objects ?? 0, 'object')}</span>}
              <span class="spring" />
              <time class="hint" dateTime={scene.created_at}>
                {ago(scene.created_at)}
              </time>
            </p>
          </li>
        ))}
      </ul>
    </section>
  );
}
