/** What a robot did: the verdict, its predicates, and the motion on one clock. */
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import { useEvents } from '../api/events';
import { getJson, sendJson } from '../api/fetch';
import type { ExecutedTask, Job, Scene } from '../api/types';
import { degrees, fixed, length, percent, words } from '../format';
import { useLoad } from '../load';
import { href } from '../router';
import type { Pose, SceneDocument } from '../scene/documents';
import { fileUrl } from '../scene/scene_files';
import type { Viewer } from '../scene/viewer';
import { announce } from '../ui/announce';
import { ClockBar, useClock } from '../ui/clock';
import { Absent, Badge, Failed, Table, Waiting } from '../ui/parts';
import { Plot } from '../ui/plot';

type Frame = ExecutedTask['trajectory']['frames'][number];

export default function ExecutionPage({ id }: { id: string }) {
  const job = useLoad(`/jobs/${id}`, (signal) => getJson<Job>(`/jobs/${id}`, signal));
  useEvents((event) => event.job_id === id, job.reload, [id]);
  const over = job.value && ['succeeded', 'failed', 'cancelled'].includes(job.value.state);
  const result = useLoad(job.value?.state === 'succeeded' ? `/executions/${id}` : null, (signal) =>
    getJson<ExecutedTask>(`/executions/${id}`, signal),
  );
  const sceneId = job.value?.scene_id ?? null;
  if (!job.value) return job.error ? <Absent title="Execution" error={job.error} again={job.reload} /> : <Waiting what="the execution" />;
  const cancel = async () => {
    try {
      await sendJson('POST', `/jobs/${id}/cancel`);
      job.reload();
    } catch (refused) {
      announce((refused as Error).message, 'bad');
    }
  };
  return (
    <div class="narrow">
      <h1>{result.value ? result.value.task.instruction : 'Execution'}</h1>
      <div class="row">
        {result.value ? (
          <Badge tone={result.value.execution.succeeded ? 'good' : 'bad'}>
            {result.value.execution.succeeded ? 'Succeeded' : words(result.value.execution.failure ?? 'failed')}
          </Badge>
        ) : (
          <Badge tone={over ? 'bad' : 'busy'}>{words(job.value.state)}</Badge>
        )}
        {sceneId && <a href={href(`/scenes/${sceneId}?tab=tasks`)}>Scene</a>}
        <span class="spring" />
        {!over && (
          <button type="button" onClick={() => void cancel()}>
            Cancel
          </button>
        )}
      </div>
      {job.value.failure && <p class="notice bad">{job.value.failure.message}</p>}
      {!over && <Waiting what="the motion; planning and simulation take seconds" />}
      {result.error && <Failed error={result.error} again={result.reload} />}
      {result.value && <Result result={result.value} sceneId={sceneId} />}
    </div>
  );
}

function Result({ result, sceneId }: { result: ExecutedTask; sceneId: string | null }) {
  const { execution, trajectory } = result;
  const duration_s = trajectory.frames.length / trajectory.rate_hz;
  const clock = useClock(duration_s, 1 / trajectory.rate_hz);
  const frame = trajectory.frames[Math.min(trajectory.frames.length - 1, Math.floor(clock.time_s * trajectory.rate_hz))];
  const joints = useMemo(
    () =>
      trajectory.joints.map((name, joint) => ({
        name: name.replace(/^panda_/, ''),
        values: trajectory.frames.map((one) => one.joint_positions[joint]!),
      })),
    [trajectory],
  );
  const gripper = useMemo(
    () => [
      { name: 'measured', values: trajectory.frames.map((one) => one.opening_m * 1e3) },
      { name: 'target', values: trajectory.frames.map((one) => one.opening_target_m * 1e3) },
    ],
    [trajectory],
  );
  const phases = useMemo(() => phasesOf(trajectory.frames.map((one) => one.phase)), [trajectory]);
  return (
    <>
      {execution.detail && <p class="notice">{execution.detail}</p>}
      <section class="card stack" aria-label="Motion">
        {sceneId && <Replay sceneId={sceneId} result={result} frame={frame} />}
        <ClockBar clock={clock} duration_s={duration_s} />
        <div class="phases" role="img" aria-label={`Phases: ${phases.map((phase) => phase.name).join(', ')}`}>
          {phases.map((phase, index) => (
            <span key={index} class={phase.name} style={{ width: `${phase.share * 100}%` }} title={phase.name}>
              {phase.share > 0.06 ? phase.name : ''}
            </span>
          ))}
        </div>
        <Plot title="Joints" unit="rad" series={joints} duration_s={duration_s} time_s={clock.time_s} onSeek={clock.seek} />
        <Plot title="Opening of the gripper" unit="mm" series={gripper} duration_s={duration_s} time_s={clock.time_s} onSeek={clock.seek} />
      </section>
      <section class="card" aria-label="Goal">
        <h2>Goal</h2>
        <Table caption="Predicates of the goal" head={['Predicate', '', 'Measured', 'Limit', '']}>
          {execution.predicates.map((outcome, index) => {
            const value = (number: number) => (outcome.unit === 'radians' ? degrees(number) : length(number));
            return (
              <tr key={index}>
                <td>
                  {outcome.predicate.object} <b>{outcome.predicate.predicate.replaceAll('_', ' ')}</b> {outcome.predicate.target}
                </td>
                <td>
                  <Badge tone={outcome.holds ? 'good' : 'bad'}>{outcome.holds ? 'holds' : 'fails'}</Badge>
                </td>
                <td class="number">{value(outcome.measured)}</td>
                <td class="number">
                  {outcome.bound === 'at_least' ? 'at least' : 'at most'} {value(outcome.limit)}
                </td>
                <td class="hint">{outcome.reason}</td>
              </tr>
            );
          })}
        </Table>
        {execution.picks.map((pick) => (
          <p key={pick.object} class="hint">
            {pick.object} was held by {length(pick.grasp.opening_m)} with {fixed(pick.grasp.force_n, 1)} N a pad, and slipped by{' '}
            {length(pick.slip_m)}.
          </p>
        ))}
        {execution.disturbed.map((one) => (
          <p key={one.object} class="notice warn">
            {one.object} was moved by {length(one.displacement_m)} and turned by {degrees(one.rotation_rad)}.
          </p>
        ))}
        <p class="hint">
          Largest share of the robot's limits that the motion uses:{' '}
          {percent(
            Math.max(
              0,
              ...execution.limit_shares.motion.map((share) => Math.max(share.position, share.velocity, share.acceleration, share.jerk)),
            ),
          )}
        </p>
      </section>
    </>
  );
}

/** Runs of equal phases and their share of the time. */
function phasesOf(phases: string[]): { name: string; share: number }[] {
  const runs: { name: string; share: number }[] = [];
  for (const name of phases) {
    const last = runs.at(-1);
    if (last?.name === name) last.share += 1 / phases.length;
    else runs.push({ name, share: 1 / phases.length });
  }
  return runs;
}

/** The robot and the objects where they were at a time. */
function Replay({ sceneId, result, frame }: { sceneId: string; result: ExecutedTask; frame: Frame | undefined }) {
  const host = useRef<HTMLDivElement>(null);
  const viewer = useRef<Viewer>(undefined);
  const [state, setState] = useState<'loading' | 'ready' | 'without robot' | 'no-webgl'>('loading');
  const { robot, world_from_base } = result.execution;
  const documents = useLoad(sceneId, async (signal) => {
    const scene = await getJson<Scene>(`/scenes/${sceneId}`, signal);
    return { scene, document: await getJson<SceneDocument>(fileUrl(scene, 'scene.json'), signal) };
  });
  useEffect(() => {
    const { value } = documents;
    if (!value) return;
    let left = false;
    const draw = async () => {
      const module = await import('../scene/viewer');
      if (left || !host.current) return;
      let made: Viewer;
      try {
        made = new module.Viewer(host.current, true);
      } catch {
        setState('no-webgl');
        return;
      }
      viewer.current = made;
      try {
        await made.load(value.document, fileUrl(value.scene, 'glb/scene.glb'));
        await made.addRobot(`/robots/${robot}/model`, world_from_base as Pose);
        setState('ready');
      } catch (error) {
        // Robots of a later program may be unknown to this one.
        announce(`The robot is not drawn: ${(error as Error).message}`, 'bad');
        setState('without robot');
      }
    };
    void draw();
    return () => {
      left = true;
      viewer.current?.dispose();
      viewer.current = undefined;
    };
  }, [documents.value]);
  useEffect(() => {
    if (!frame) return;
    const numbers = new Float32Array(frame.object_poses.length * 7);
    frame.object_poses.forEach(({ translation_m: [x, y, z], rotation_xyzw: [qx, qy, qz, qw] }, index) =>
      numbers.set([x!, y!, z!, qw!, qx!, qy!, qz!], index * 7),
    );
    viewer.current?.setPoses(result.trajectory.objects, numbers);
    viewer.current?.moveRobot(frame.joint_positions, frame.opening_m);
  }, [frame, state]);
  if (documents.error) return <Failed error={documents.error} />;
  return (
    <div class="viewer replay">
      <div class="stage" data-replay={state}>
        <div ref={host} class="canvas" role="img" aria-label="The robot and the objects in motion" />
        {state === 'no-webgl' && <p class="over hint">This browser has no WebGL, so the motion is not drawn.</p>}
      </div>
    </div>
  );
}
