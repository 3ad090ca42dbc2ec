/** Messages between the page and the worker of the physics. */

export type ToPhysics =
  | { kind: 'load'; url: string }
  | { kind: 'run'; on: boolean }
  /** A force in the world frame, newtons, on the center of mass for some seconds. */
  | { kind: 'push'; body: string; force: [number, number, number]; seconds: number }
  | { kind: 'shake' }
  | { kind: 'reset' };

export type FromPhysics =
  | { kind: 'progress'; text: string }
  | { kind: 'ready'; bodies: string[] }
  /** Seven numbers for each body: position, then w, x, y, z. */
  | { kind: 'poses'; time_s: number; poses: Float32Array }
  | { kind: 'failed'; message: string };
