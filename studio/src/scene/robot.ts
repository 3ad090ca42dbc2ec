/** A robot in the drawing: its links, moved by the positions of its joints. */
import { Group, type Matrix4, Mesh, type Object3D, Quaternion as Rotation, Vector3 } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import type { Pose } from './documents';

/** The extras of a link that moves, in the file of a robot's model. */
interface Joint {
  kind: 'revolute' | 'prismatic';
  axis: [number, number, number];
  /** Index among the positions of the arm; or the position follows from the opening of the gripper. */
  arm_joint?: number;
  per_opening_m?: number;
  offset?: number;
}

export class Robot {
  readonly group = new Group();
  readonly #links: { link: Object3D; joint: Joint; position: Vector3; quaternion: Rotation }[] = [];

  private constructor(root: Object3D, worldFromBase: Pose) {
    this.group.add(root);
    this.group.position.set(...worldFromBase.translation_m);
    this.group.quaternion.set(...worldFromBase.rotation_xyzw);
    root.traverse((node) => {
      if (node instanceof Mesh) node.castShadow = node.receiveShadow = true;
      if ('axis' in node.userData) {
        const [position, quaternion] = [node.position.clone(), node.quaternion.clone()];
        this.#links.push({ link: node, joint: node.userData as Joint, position, quaternion });
      }
    });
  }

  /** The model in a file, whose world `upright` turns to that of the drawing. */
  static async load(url: string, worldFromBase: Pose, upright: Matrix4): Promise<Robot> {
    const { scene: root } = await new GLTFLoader().loadAsync(url);
    root.applyMatrix4(upright);
    return new Robot(root, worldFromBase);
  }

  /** Moves the links; positions of the arm are radians or meters. */
  move(positions: number[], opening_m: number): void {
    for (const { link, joint, position, quaternion } of this.#links) {
      const at = joint.arm_joint === undefined ? joint.per_opening_m! * opening_m + joint.offset! : (positions[joint.arm_joint] ?? 0);
      const axis = new Vector3(...joint.axis);
      link.position.copy(position);
      link.quaternion.copy(quaternion);
      if (joint.kind === 'revolute') link.quaternion.multiply(new Rotation().setFromAxisAngle(axis, at));
      else link.position.add(axis.multiplyScalar(at).applyQuaternion(quaternion));
    }
  }
}
