/** The physics of a scene, in a worker that is started when it is asked for. */
import workerUrl from './physics-worker.ts?worker&url';
import type { FromPhysics, ToPhysics } from './messages';

interface Policy {
  createScriptURL(url: string): string;
}
interface TrustedTypes {
  createPolicy(name: string, rules: Policy): Policy;
}

/** Only files of this server become workers. */
function trusted(url: string): string {
  const rules: Policy = {
    createScriptURL: (given) => {
      if (new URL(given, location.href).origin !== location.origin) throw new TypeError(`${given} is not a file of this server`);
      return given;
    },
  };
  const types = (globalThis as { trustedTypes?: TrustedTypes }).trustedTypes;
  policy ??= types ? types.createPolicy('studio', rules) : rules;
  return policy.createScriptURL(url);
}
let policy: Policy | undefined;

export class Physics {
  readonly #worker: Worker;

  constructor(url: string, receive: (message: FromPhysics) => void) {
    this.#worker = new Worker(trusted(workerUrl), { type: 'module' });
    this.#worker.onmessage = ({ data }: MessageEvent<FromPhysics>) => receive(data);
    this.#worker.onerror = () =>
      receive({ kind: 'failed', message: 'The physics did not start: the browser refused or could not load MuJoCo.' });
    this.send({ kind: 'load', url });
  }

  send(message: ToPhysics): void {
    this.#worker.postMessage(message);
  }

  end(): void {
    this.#worker.terminate();
  }
}
