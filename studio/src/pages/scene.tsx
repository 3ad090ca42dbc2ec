/** A scene: viewer, objects, certificate, stages, downloads, code, edits and tasks. */
import type { ComponentType } from 'preact';
import { useEffect, useState } from 'preact/hooks';
import { useEvents } from '../api/events';
import { getJson, Refusal, sendJson } from '../api/fetch';
import type { Scene } from '../api/types';
import { dateTime, short } from '../format';
import { useLoad } from '../load';
import { address, href, navigate, setQuery } from '../router';
import { accused } from '../scene/certificate';
import { CertificateCard, Reasons } from '../scene/certificate_card';
import { CodePanel } from '../scene/code_panel';
import { DifferencePanel } from '../scene/difference_panel';
import { differences } from '../scene/difference';
import type { Report, SceneDocument } from '../scene/documents';
import { Downloads } from '../scene/downloads';
import { EditPanel } from '../scene/edit_panel';
import { ObjectTree } from '../scene/object_tree';
import { fileUrl } from '../scene/scene_files';
import { StageStrip } from '../scene/stage_strip';
import { AgainFrom, StageTimeline } from '../scene/stage_timeline';
import { TasksPanel } from '../scene/tasks_panel';
import { hasFiles, isOver, titleOf } from '../scene/title';
import { may } from '../session';
import { announce } from '../ui/announce';
import { Absent, CopyButton, Failed, Panel, SceneBadge, Tabs, Waiting } from '../ui/parts';
import { Review } from '../ui/review';

type ViewerPanelType = typeof import('../scene/viewer_panel').ViewerPanel;

const TABS = [
  { id: 'objects', title: 'Objects' },
  { id: 'certificate', title: 'Certificate' },
  { id: 'stages', title: 'Stages' },
  { id: 'download', title: 'Download' },
  { id: 'code', title: 'Code' },
  { id: 'edit', title: 'Edit' },
  { id: 'tasks', title: 'Robot' },
  { id: 'parent', title: 'Changes' },
] as const;
type Tab = (typeof TABS)[number]['id'];

export default function ScenePage({ id }: { id: string }) {
  const path = `/scenes/${id}`;
  const scene = useLoad(path, (signal) => getJson<Scene>(path, signal));
  useEvents((event) => event.scene_id === id || event.job_id === scene.value?.job?.id, scene.reload, [id, scene.value?.job?.id]);
  const isDeleted = scene.error instanceof Refusal && scene.error.status === 410;
  if (!scene.value || isDeleted) return scene.error ? <Absent title="Scene" error={scene.error} again={scene.reload} /> : <Waiting what="the scene" />;
  return (
    <div class="scene-page">
      <Head scene={scene.value} reload={scene.reload} />
      {hasFiles(scene.value) ? <Finished scene={scene.value} onChange={scene.reload} /> : <Unfinished scene={scene.value} onChange={scene.reload} />}
    </div>
  );
}

function Head({ scene, reload }: { scene: Scene; reload: () => void }) {
  const act = async (what: () => Promise<unknown>) => {
    try {
      await what();
      reload();
    } catch (refused) {
      announce((refused as Error).message, 'bad');
    }
  };
  const { job } = scene;
  const remove = () => {
    if (!confirm('Delete this scene and its files? This cannot be undone.')) return;
    void act(async () => {
      await sendJson('DELETE', `/scenes/${scene.id}`);
      navigate('/gallery');
    });
  };
  return (
    <header class="scene-head">
      <h1>{titleOf(scene)}</h1>
      <div class="row">
        <SceneBadge scene={scene} />
        <span class="hint">
          seed <span class="number">{scene.seed}</span>, {dateTime(scene.created_at)}
          {scene.parent && (
            <>
              , from <a href={href(`/scenes/${scene.parent}`)}>its parent</a>
            </>
          )}
        </span>
        <code class="hint">{short(scene.id)}</code>
        <CopyButton text={scene.id} label="Copy id" />
        <span class="spring" />
        {hasFiles(scene) && <Review scene={scene} onChange={reload} />}
        {!isOver(scene) && job && may('submit') && (
          <button
            type="button"
            disabled={job.state === 'cancelling'}
            onClick={() => void act(() => sendJson('POST', `/jobs/${job.id}/cancel`))}
          >
            Cancel
          </button>
        )}
        {job && !hasFiles(scene) && ['failed', 'cancelled'].includes(job.state) && may('submit') && (
          <button type="button" onClick={() => void act(() => sendJson('POST', `/jobs/${job.id}/retry`, {}))}>
            Try again
          </button>
        )}
        {may('delete') && scene.state !== 'deleted' && (
          <button type="button" class="quiet danger" onClick={remove}>
            Delete
          </button>
        )}
      </div>
    </header>
  );
}

function Unfinished({ scene, onChange }: { scene: Scene; onChange: () => void }) {
  return (
    <section class="card progress" aria-label="Progress">
      {scene.failure && <p class="notice bad">{scene.failure.message}</p>}
      {scene.state === 'deleted' && <p>The files of this scene were deleted.</p>}
      {scene.job?.queue_position !== undefined && <p class="hint">Number {scene.job.queue_position} of your scenes in the queue.</p>}
      <StageStrip scene={scene} />
      <AgainFrom scene={scene} onChange={onChange} />
    </section>
  );
}

function Finished({ scene, onChange }: { scene: Scene; onChange: () => void }) {
  const documents = useLoad(`${scene.id} documents`, async (signal) => {
    const [document, report] = await Promise.all([
      getJson<SceneDocument>(fileUrl(scene, 'scene.json'), signal),
      getJson<Report>(fileUrl(scene, 'report.json'), signal),
    ]);
    return { document, report };
  });
  const parent = useLoad(scene.parent ? `${scene.parent} parent` : null, async (signal) => {
    const made = await getJson<Scene>(`/scenes/${scene.parent}`, signal);
    return { scene: made, document: await getJson<SceneDocument>(fileUrl(made, 'scene.json'), signal) };
  });
  const [selected, setSelected] = useState<string>();
  const [ghosts, setGhosts] = useState(true);
  const wanted = address.value.query.get('tab') as Tab | null;
  const tabs = TABS.filter((tab) => tab.id !== 'parent' || scene.parent);
  const tab: Tab = tabs.some((one) => one.id === wanted) ? wanted! : 'objects';

  const [ViewerPanel, setViewerPanel] = useState<ViewerPanelType>();
  useEffect(() => {
    // three is most of this page's bytes; the text does not wait for it.
    import('../scene/viewer_panel').then((module) => setViewerPanel(() => module.ViewerPanel as ComponentType as ViewerPanelType));
  }, []);
  // A new set at every drawing would make the viewer draw its outlines again.
  const [fails, setFails] = useState<Set<string>>(new Set());
  useEffect(() => {
    if (documents.value) setFails(accused(documents.value.report));
  }, [documents.value]);
  const [glass, setGlass] = useState<{ scene: Scene; names: Set<string> }>();
  useEffect(() => {
    if (!parent.value || !documents.value || tab !== 'parent' || !ghosts) return setGlass(undefined);
    const moved = differences(parent.value.document, documents.value.document).filter((row) => row.what !== 'same' && row.what !== 'added');
    setGlass({ scene: parent.value.scene, names: new Set(moved.map((row) => row.name)) });
  }, [parent.value, documents.value, tab === 'parent' && ghosts]);

  if (documents.error) return <Failed error={documents.error} again={documents.reload} />;
  if (!documents.value) return <Waiting what="the files of the scene" />;
  const { document: doc, report } = documents.value;
  return (
    <div class="columns">
      <div class="left">
        {report.verdict === 'quarantine' && <Reasons report={report} onSelect={setSelected} />}
        {ViewerPanel ? (
          <ViewerPanel scene={scene} document={doc} selected={selected} accused={fails} onSelect={setSelected} ghosts={glass} />
        ) : (
          <section class="viewer card">
            <div class="stage" style={{ aspectRatio: `${doc.camera.width_px} / ${doc.camera.height_px}` }}>
              <p class="over">Loading the viewer…</p>
            </div>
          </section>
        )}
      </div>
      <div class="right card">
        <Tabs label="Parts of the scene" tabs={[...tabs]} value={tab} onChange={(id) => setQuery({ tab: id === 'objects' ? '' : id })} />
        <Panel id={tab}>
          {tab === 'objects' && <ObjectTree scene={scene} document={doc} report={report} accused={fails} selected={selected} onSelect={setSelected} />}
          {tab === 'certificate' && <CertificateCard report={report} document={doc} onSelect={setSelected} />}
          {tab === 'stages' && <StageTimeline scene={scene} onChange={onChange} />}
          {tab === 'download' && <Downloads scene={scene} />}
          {tab === 'code' && <CodePanel scene={scene} />}
          {tab === 'edit' && <EditPanel scene={scene} />}
          {tab === 'tasks' && <TasksPanel scene={scene} />}
          {tab === 'parent' &&
            (parent.value ? (
              <DifferencePanel parent={parent.value.document} child={doc} ghosts={ghosts} onGhosts={setGhosts} onSelect={setSelected} />
            ) : parent.error ? (
              <Failed error={parent.error} />
            ) : (
              <Waiting what="the parent" />
            ))}
        </Panel>
      </div>
    </div>
  );
}
