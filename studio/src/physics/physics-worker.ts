/**
 * MuJoCo on the scene's own MJCF, in real time. It runs in a worker, whose response allows what MuJoCo's bindings need
 * and the page does not allow: making functions from text.
 */
import loadMujoco, { type MainModule, type MjData, type MjModel } from '@mujoco/mujoco';
import wasmUrl from '@mujoco/mujoco/mujoco.wasm?url';
import { unzipSync } from 'fflate';
import type { FromPhysics, ToPhysics } from './messages';

/** Duration of a shake, and the sideways acceleration and frequency of the table in it. */
const SHAKE_S = 1;
const SHAKE_M_S2 = 2.5;
const SHAKE_HZ = 4;

const FREE_JOINT_BODY = 1;

const send = (message: FromPhysics) => (self as unknown as { postMessage(message: FromPhysics): void }).postMessage(message);

let mujoco: MainModule;
let model: MjModel;
let data: MjData;
let bodies: string[] = [];
let running = false;
let pushes: { id: number; force: [number, number, number]; until: number }[] = [];
let shakenUntil = 0;
let last = 0;
const GRAVITY = 9.81;

async function load(url: string): Promise<void> {
  send({ kind: 'progress', text: 'Loading MuJoCo' });
  const [module, response] = await Promise.all([loadMujoco({ locateFile: () => wasmUrl }), fetch(url)]);
  if (!response.ok) throw new Error(`The MJCF of the scene was not sent (${response.status}).`);
  mujoco = module;
  send({ kind: 'progress', text: 'Compiling the scene' });
  const files = unzipSync(new Uint8Array(await response.arrayBuffer()), { filter: (file) => /(^|\/)mjcf\//.test(file.name) });
  const entry = Object.keys(files).find((name) => name.endsWith('mjcf/scene.xml'));
  if (!entry) throw new Error('The bundle has no mjcf/scene.xml.');
  for (const [name, bytes] of Object.entries(files)) {
    if (name.endsWith('/')) continue;
    const folders = name.split('/').slice(0, -1);
    for (let depth = 1; depth <= folders.length; depth++) {
      const folder = `/${folders.slice(0, depth).join('/')}`;
      if (!mujoco.FS.analyzePath(folder, false).exists) mujoco.FS.mkdir(folder);
    }
    mujoco.FS.writeFile(`/${name}`, bytes);
  }
  model = mujoco.MjModel.from_xml_path(`/${entry}`)!;
  data = new mujoco.MjData(model)!;
  mujoco.mj_forward(model, data);
  bodies = Array.from({ length: model.nbody - 1 }, (_, index) => mujoco.mj_id2name(model, FREE_JOINT_BODY, index + 1) ?? '');
  send({ kind: 'ready', bodies });
  sendPoses();
  last = performance.now();
  setTimeout(turn, 0);
}

function sendPoses(): void {
  const poses = new Float32Array(bodies.length * 7);
  const { xpos, xquat } = data;
  bodies.forEach((_, index) => {
    poses.set(xpos.subarray(3 * (index + 1), 3 * (index + 2)), 7 * index);
    poses.set(xquat.subarray(4 * (index + 1), 4 * (index + 2)), 7 * index + 3);
  });
  send({ kind: 'poses', time_s: data.time, poses });
}

function step(): void {
  // In the frame of a shaken table, gravity swings.
  const shaken = data.time < shakenUntil;
  const phase = 2 * Math.PI * SHAKE_HZ * (shakenUntil - data.time);
  model.opt.gravity[0] = shaken ? SHAKE_M_S2 * Math.sin(phase) : 0;
  model.opt.gravity[1] = shaken ? 0.6 * SHAKE_M_S2 * Math.cos(phase) : 0;
  model.opt.gravity[2] = -GRAVITY;
  data.xfrc_applied.fill(0);
  pushes = pushes.filter((push) => push.until > data.time);
  for (const push of pushes) data.xfrc_applied.set(push.force, 6 * push.id);
  mujoco.mj_step(model, data);
}

/** Steps as far as time has passed, but at most as far as 14 ms of computing reach: a slow device shows slow motion. */
function turn(): void {
  const now = performance.now();
  const wanted = Math.min(now - last, 40) / 1000;
  last = now;
  if (running) {
    const until = data.time + wanted;
    while (data.time < until && performance.now() - now < 14) step();
    sendPoses();
  }
  setTimeout(turn, 16);
}

onmessage = ({ data: message }: MessageEvent<ToPhysics>) => {
  switch (message.kind) {
    case 'load':
      load(message.url).catch((error: Error) => send({ kind: 'failed', message: error.message }));
      break;
    case 'run':
      running = message.on;
      break;
    case 'push':
      pushes.push({ id: bodies.indexOf(message.body) + 1, force: message.force, until: data.time + message.seconds });
      break;
    case 'shake':
      shakenUntil = data.time + SHAKE_S;
      break;
    case 'reset':
      mujoco.mj_resetData(model, data);
      mujoco.mj_forward(model, data);
      pushes = [];
      shakenUntil = 0;
      sendPoses();
  }
};
