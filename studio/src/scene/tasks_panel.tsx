/** Tasks that a robot could do in the scene: proposals, execution, and demonstrations. */
import { useState } from 'preact/hooks';
import { getJson, idempotencyKey, sendJson, withQuery } from '../api/fetch';
import type { Job, ProposedTask, Recording, RobotList, Scene, SceneTasks } from '../api/types';
import { count, length, words } from '../format';
import { useLoad } from '../load';
import { navigate } from '../router';
import { may } from '../session';
import { announce } from '../ui/announce';
import { Empty, Failed, Waiting } from '../ui/parts';

export function TasksPanel({ scene }: { scene: Scene }) {
  const [robot, setRobot] = useState('panda');
  const [rehearsed, setRehearsed] = useState(false);
  const [text, setText] = useState('');
  const [episodes, setEpisodes] = useState(5);
  const [busy, setBusy] = useState(false);
  const path = withQuery(`/scenes/${scene.id}/tasks`, { robot, rehearsed: String(rehearsed), count: 5 });
  const tasks = useLoad(path, (signal) => getJson<SceneTasks>(path, signal));
  const robots = useLoad('/robots', (signal) => getJson<RobotList>('/robots', signal));

  const begin = async (what: () => Promise<string>) => {
    setBusy(true);
    try {
      navigate(await what());
    } catch (refused) {
      announce((refused as Error).message, 'bad');
    }
    setBusy(false);
  };
  const execute = (task: Record<string, unknown>) =>
    begin(async () => {
      const job = await sendJson<Job>('POST', `/scenes/${scene.id}/executions`, { ...task, seed: 0 }, idempotencyKey());
      return `/executions/${job.id}`;
    });
  const record = (task: unknown) =>
    begin(async () => {
      const recording = await sendJson<Recording>('POST', `/scenes/${scene.id}/episodes`, { robot, task, count: episodes }, idempotencyKey());
      return `/recordings/${recording.id}`;
    });

  return (
    <div class="stack tasks">
      <div class="row">
        <label class="inline">
          Robot
          <select value={robot} onChange={(event) => setRobot(event.currentTarget.value)}>
            {(robots.value?.robots ?? [{ name: 'panda', title: 'panda' }]).map((one) => (
              <option key={one.name} value={one.name}>
                {one.title}
              </option>
            ))}
          </select>
        </label>
        <label class="check">
          <input type="checkbox" checked={rehearsed} onChange={(event) => setRehearsed(event.currentTarget.checked)} />
          Only tasks that it did in simulation (slower)
        </label>
        <span class="spring" />
        <label class="inline">
          Episodes
          <input
            type="number"
            class="small"
            min={1}
            max={100000}
            value={episodes}
            onInput={(event) => setEpisodes(event.currentTarget.valueAsNumber || 1)}
          />
        </label>
      </div>
      <form
        class="row"
        onSubmit={(event) => {
          event.preventDefault();
          void execute({ text, robot });
        }}
      >
        <label class="spring">
          <span class="unseen">Task in words</span>
          <input value={text} placeholder="put the mug to the left of the bowl" onInput={(event) => setText(event.currentTarget.value)} />
        </label>
        <button type="submit" disabled={!text.trim() || busy || !may('submit')}>
          Execute
        </button>
        <button type="button" disabled={!text.trim() || busy || !may('submit')} onClick={() => void record(text)}>
          Record
        </button>
      </form>
      {tasks.error && <Failed error={tasks.error} again={tasks.reload} />}
      {!tasks.value && tasks.loading && <Waiting what="proposals" />}
      {tasks.value && tasks.value.proposed.length === 0 && <Empty>The robot can pick up nothing here.</Empty>}
      <ul class="proposals">
        {tasks.value?.proposed.map((proposal) => (
          <Proposal key={proposal.wordings.default} proposal={proposal}>
            <button type="button" disabled={busy || !may('submit')} onClick={() => void execute({ task: proposal.task })}>
              Execute
            </button>
            <button type="button" disabled={busy || !may('submit')} onClick={() => void record(proposal.task)}>
              Record
            </button>
          </Proposal>
        ))}
      </ul>
    </div>
  );
}

function Proposal({ proposal, children }: { proposal: ProposedTask; children: preact.ComponentChildren }) {
  const { difficulty } = proposal;
  return (
    <li>
      <p class="title">{proposal.wordings.default}</p>
      <p class="hint">
        {words(proposal.kind)}; difficulty {Math.round(difficulty.overall * 100)} %, placed to within {length(difficulty.precision_m)}
        {difficulty.clutter > 0 && `, ${count(difficulty.clutter, 'other object')} close by`}
      </p>
      <div class="row">{children}</div>
    </li>
  );
}
