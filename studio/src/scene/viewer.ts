/**
 * A scene in three dimensions. The world frame is that of `scene.json`: meters, z up, origin at the center of the table
 * top. Images are drawn only when something has changed.
 */
import {
  NeutralToneMapping,
  ArrowHelper,
  BoxGeometry,
  BufferGeometry,
  Color,
  DirectionalLight,
  EdgesGeometry,
  Float32BufferAttribute,
  Group,
  HemisphereLight,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  Object3D,
  PCFShadowMap,
  PerspectiveCamera,
  PMREMGenerator,
  Quaternion as Rotation,
  Raycaster,
  Scene as World,
  SphereGeometry,
  Vector2,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { RoomEnvironment } from 'three/addons/environments/RoomEnvironment.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { getJson } from '../api/fetch';
import { fixed } from '../format';
import type { Pose, SceneDocument } from './documents';
import { Robot } from './robot';

Object3D.DEFAULT_UP.set(0, 0, 1);

/** OpenCV cameras are directed along +z with y down, those of three along -z with y up. */
const FLIP = new Rotation(1, 0, 0, 0);
/** Files of meshes have y up. */
const Z_UP = new Matrix4().makeRotationX(Math.PI / 2);

export interface Label {
  text: string;
  /** Position on the canvas in pixels; undefined where it is behind the camera. */
  at: [number, number] | undefined;
  kind: 'ruler' | 'measure' | 'object';
}

interface Colors {
  accent: Color;
  bad: Color;
  hull: Color;
}

/** A convex hull in the frame of its body, meters. */
interface Hull {
  points: [number, number, number][];
  triangles: [number, number, number][];
}

/** A part of the drawing that clicks pass through. */
function notPicked<T extends Object3D>(part: T): T {
  part.raycast = () => {};
  return part;
}

function drawnHull(hull: Hull, index: number): Group {
  const geometry = new BufferGeometry().setAttribute('position', new Float32BufferAttribute(hull.points.flat(), 3));
  geometry.setIndex(hull.triangles.flat());
  // Neighbors get colors far from each other.
  const color = new Color().setHSL((index * 0.381) % 1, 0.75, 0.55);
  const edges = notPicked(new LineSegments(new EdgesGeometry(geometry, 12), new LineBasicMaterial({ color, depthTest: false, transparent: true })));
  edges.renderOrder = 4;
  const fill = notPicked(new Mesh(geometry, new MeshBasicMaterial({ color, transparent: true, opacity: 0.16, depthWrite: false })));
  fill.userData.isHull = true;
  geometry.computeBoundingBox();
  const group = new Group().add(edges, fill);
  group.userData.center = geometry.boundingBox!.getCenter(new Vector3());
  return group;
}

export class Viewer {
  readonly #renderer: WebGLRenderer;
  readonly #world = new World();
  readonly #camera = new PerspectiveCamera(45, 1, 0.01, 50);
  readonly #controls: OrbitControls;
  readonly #resize: ResizeObserver;
  readonly #host: HTMLElement;
  readonly #bodies = new Map<string, Object3D>();
  readonly #rest = new Map<string, { position: Vector3; quaternion: Rotation }>();
  readonly #hulls = new Map<string, Group>();
  readonly #mass = new Group();
  readonly #outlines: LineSegments[] = [];
  readonly #grid = new Group();
  readonly #ghosts = new Group();
  readonly #measure = new Group();
  readonly #colors: Colors;
  #scene: SceneDocument | undefined;
  #robot: Robot | undefined;
  #dirty = true;
  #frame = 0;
  #selected: string | undefined;
  #accused = new Set<string>();
  #measuring = false;
  #points: Vector3[] = [];
  #explosion = 0;
  #locked = false;

  onPick: (name: string | undefined) => void = () => {};
  onLabels: (labels: Label[]) => void = () => {};

  /** Throws where the browser has no WebGL. */
  constructor(host: HTMLElement, plainLight: boolean) {
    this.#host = host;
    this.#renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.#renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.#renderer.toneMapping = NeutralToneMapping;
    host.append(this.#renderer.domElement);
    const style = getComputedStyle(host);
    const color = (name: string) => new Color(style.getPropertyValue(name).trim() || '#888');
    this.#colors = { accent: color('--accent'), bad: color('--bad'), hull: color('--warn') };
    this.#light(plainLight);
    this.#world.add(this.#mass, this.#grid, this.#ghosts, this.#measure);
    this.#controls = new OrbitControls(this.#camera, this.#renderer.domElement);
    this.#controls.maxPolarAngle = Math.PI * 0.95;
    this.#controls.addEventListener('change', () => this.invalidate());
    this.#resize = new ResizeObserver(() => this.#fit());
    this.#resize.observe(host);
    this.#listen();
    this.#loop();
  }

  #light(plain: boolean): void {
    const sun = new DirectionalLight(0xffffff, plain ? 2 : 1.8);
    // As in the reference images, from the right and behind.
    sun.position.set(0.7, 0.5, 2);
    if (plain) {
      this.#world.add(new HemisphereLight(0xffffff, 0x998877, 1.4));
    } else {
      const generator = new PMREMGenerator(this.#renderer);
      this.#world.environment = generator.fromScene(new RoomEnvironment(), 0.03).texture;
      this.#world.environmentIntensity = 0.45;
      // The room is built with y up.
      this.#world.environmentRotation.x = Math.PI / 2;
      generator.dispose();
      this.#renderer.shadowMap.enabled = true;
      this.#renderer.shadowMap.type = PCFShadowMap;
      sun.castShadow = true;
      sun.shadow.mapSize.set(1024, 1024);
      Object.assign(sun.shadow.camera, { left: -1.2, right: 1.2, top: 1.2, bottom: -1.2, near: 0.2, far: 6 });
      sun.shadow.bias = -0.0004;
    }
    this.#world.add(sun);
  }

  /** Shows a scene from the camera of its reference image. */
  async load(scene: SceneDocument, url: string): Promise<void> {
    const { scene: root } = await new GLTFLoader().loadAsync(url);
    this.#scene = scene;
    // The file turns the world to y up; this turns it back.
    root.applyMatrix4(Z_UP);
    root.updateMatrixWorld(true);
    const known = new Set([scene.table.name, ...scene.instances.map((instance) => instance.name)]);
    root.traverse((node) => {
      if (node instanceof Mesh) {
        node.castShadow = true;
        node.receiveShadow = true;
      }
      if (known.has(node.name) && !this.#bodies.has(node.name)) this.#bodies.set(node.name, node);
    });
    // Bodies hang directly in the world, so that their poses are those of `scene.json`.
    for (const [name, body] of this.#bodies) {
      this.#world.attach(body);
      this.#rest.set(name, { position: body.position.clone(), quaternion: body.quaternion.clone() });
    }
    this.#drawGrid(scene);
    this.referenceView();
    this.invalidate();
  }

  /** The camera of the reference image. */
  referenceView(): void {
    const camera = this.#scene?.camera;
    if (!camera) return;
    const { translation_m, rotation_xyzw } = camera.world_from_camera;
    this.#camera.position.set(...translation_m);
    this.#camera.quaternion.set(...rotation_xyzw).multiply(FLIP);
    const ahead = new Vector3(0, 0, -1).applyQuaternion(this.#camera.quaternion);
    // Turning goes about the point of the table in the center of the image.
    const distance = ahead.z < -0.05 ? -this.#camera.position.z / ahead.z : 1;
    this.#controls.target.copy(this.#camera.position).addScaledVector(ahead, distance);
    this.#fit();
  }

  /** From above, with the front edge below. */
  topView(): void {
    const size = this.#scene?.table.size_m ?? [1, 1, 1];
    const height = Math.max(size[0], size[1]) * 1.35;
    this.#camera.position.set(0, -0.001, height);
    this.#controls.target.set(0, 0, 0);
    this.#controls.update();
    this.invalidate();
  }

  /** Draws a robot, and looks at it from the other side of the table, a little from its left. */
  async addRobot(url: string, worldFromBase: Pose): Promise<void> {
    this.#robot = await Robot.load(url, worldFromBase, Z_UP);
    this.#world.add(this.#robot.group);
    const base = new Vector3(...worldFromBase.translation_m);
    this.#drawStand(base);
    const [width, depth] = this.#scene?.table.size_m ?? [1, 1];
    const away = new Vector3(-base.x, -base.y, 0).normalize().applyAxisAngle(Object3D.DEFAULT_UP, 0.5);
    this.#controls.target.copy(base).multiplyScalar(0.45).setZ(0.2);
    this.#camera.position.copy(this.#controls.target).addScaledVector(away, 1.7 * Math.max(width, depth, 1.2));
    this.#camera.position.z += 0.9;
    this.#controls.update();
    this.invalidate();
  }

  /** A column below the base, from the table or from the floor. */
  #drawStand(base: Vector3): void {
    const table = this.#scene?.table;
    const [width, depth] = table?.size_m ?? [0, 0];
    const isOnTable = Math.abs(base.x) <= width / 2 && Math.abs(base.y) <= depth / 2;
    const below = isOnTable ? 0 : -(table?.height_m ?? 0);
    if (base.z - below < 0.001) return;
    const stand = new Mesh(new BoxGeometry(0.16, 0.16, base.z - below), new MeshStandardMaterial({ color: 0x8a8f96, roughness: 0.6 }));
    stand.position.set(base.x, base.y, (base.z + below) / 2);
    this.#world.add(notPicked(stand));
  }

  /** Moves the joints of the robot, and the pads of its gripper `opening_m` apart. */
  moveRobot(positions: number[], opening_m: number): void {
    this.#robot?.move(positions, opening_m);
    this.invalidate();
  }

  /** Keeps the reference camera, for the comparison with the image. */
  lock(locked: boolean): void {
    this.#locked = locked;
    this.#controls.enabled = !locked;
    if (locked) this.referenceView();
    for (const mark of [this.#mass, ...this.#outlines]) mark.visible = !locked;
    this.#grid.visible = this.#grid.visible && !locked;
    this.invalidate();
  }

  /** Sets the projection so that the whole width of the reference image is seen at any shape of the canvas. */
  #fit(): void {
    const { clientWidth: width, clientHeight: height } = this.#host;
    if (!width || !height) return;
    this.#renderer.setSize(width, height);
    const camera = this.#scene?.camera;
    this.#camera.aspect = width / height;
    if (camera) {
      const seen = Math.max(camera.height_px, camera.width_px / this.#camera.aspect);
      this.#camera.fov = (2 * Math.atan(seen / 2 / camera.fy) * 180) / Math.PI;
      const scale = height / seen;
      const [x, y] = [(camera.width_px / 2 - camera.cx) * scale, (camera.height_px / 2 - camera.cy) * scale];
      if (Math.hypot(x, y) > 0.5) this.#camera.setViewOffset(width, height, x, y, width, height);
      else this.#camera.clearViewOffset();
    }
    this.#camera.updateProjectionMatrix();
    if (!this.#locked) this.#controls.update();
    this.invalidate();
  }

  invalidate(): void {
    this.#dirty = true;
  }

  #loop = (): void => {
    this.#frame = requestAnimationFrame(this.#loop);
    if (!this.#dirty) return;
    this.#dirty = false;
    this.#renderer.render(this.#world, this.#camera);
    this.onLabels(this.#labels());
  };

  #listen(): void {
    const canvas = this.#renderer.domElement;
    let down: [number, number] = [0, 0];
    canvas.addEventListener('pointerdown', (event) => (down = [event.clientX, event.clientY]));
    canvas.addEventListener('pointerup', (event) => {
      // A drag turns the camera and picks nothing.
      if (Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 5 || this.#locked) return;
      const box = canvas.getBoundingClientRect();
      const at = new Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
      const caster = new Raycaster();
      caster.setFromCamera(at, this.#camera);
      const hit = caster.intersectObjects([...this.#bodies.values()], true)[0];
      if (this.#measuring) {
        if (hit) this.#addPoint(hit.point);
        return;
      }
      let node: Object3D | null = hit?.object ?? null;
      while (node && !this.#bodies.has(node.name)) node = node.parent;
      this.onPick(node?.name);
    });
  }

  select(name: string | undefined): void {
    this.#selected = name;
    this.#redrawMarks();
  }

  /** Bodies that the certificate complains of; they are outlined in red. */
  accuse(names: Set<string>): void {
    this.#accused = names;
    this.#redrawMarks();
  }

  #outline(name: string, color: Color): void {
    const meshes: Mesh[] = [];
    this.#bodies.get(name)?.traverse((node) => node instanceof Mesh && !node.userData.isHull && meshes.push(node));
    for (const mesh of meshes) {
      const material = new LineBasicMaterial({ color, depthTest: false, transparent: true, opacity: 0.9 });
      const edges = notPicked(new LineSegments(new EdgesGeometry(mesh.geometry, 30), material));
      edges.renderOrder = 5;
      edges.visible = !this.#locked;
      // Below its mesh it moves along with the body.
      mesh.add(edges);
      this.#outlines.push(edges);
    }
  }

  #redrawMarks(): void {
    for (const edges of this.#outlines.splice(0)) {
      edges.removeFromParent();
      edges.geometry.dispose();
    }
    for (const name of this.#accused) if (name !== this.#selected) this.#outline(name, this.#colors.bad);
    if (this.#selected) this.#outline(this.#selected, this.#accused.has(this.#selected) ? this.#colors.bad : this.#colors.accent);
    this.#redrawMass();
  }

  #redrawMass(): void {
    this.#mass.traverse((node) => node instanceof Mesh && node.geometry.dispose());
    this.#mass.clear();
    if (this.#selected) this.#drawMass(this.#selected);
    this.invalidate();
  }

  /** The center of mass, and the weight from there. */
  #drawMass(name: string): void {
    const body = this.#bodies.get(name);
    const instance = this.#scene?.instances.find((one) => one.name === name);
    if (!body || !instance) return;
    const at = body.localToWorld(new Vector3(...instance.center_of_mass_m));
    const radius = Math.max(...instance.size_m) * 0.03;
    const point = new Mesh(
      new SphereGeometry(radius, 16, 12),
      new MeshBasicMaterial({ color: this.#colors.accent, depthTest: false, transparent: true }),
    );
    point.position.copy(at);
    point.renderOrder = 6;
    const arrow = new ArrowHelper(
      new Vector3(0, 0, -1),
      at,
      Math.max(...instance.size_m) * 0.6,
      this.#colors.accent,
      radius * 3,
      radius * 2,
    );
    for (const part of [arrow.line, arrow.cone]) {
      Object.assign(part.material, { depthTest: false, transparent: true });
      part.renderOrder = 6;
    }
    this.#mass.add(point, arrow);
  }

  /** Lines every 10 cm on the table top, and a ruler in centimeters along its front and left edge. */
  #drawGrid(scene: SceneDocument): void {
    const xs = scene.table.outline_m.map(([x]) => x);
    const ys = scene.table.outline_m.map(([, y]) => y);
    const [left, right, front, back] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    const fine: number[] = [];
    const coarse: number[] = [];
    const z = 0.001;
    for (let x = Math.ceil(left * 10); x <= right * 10; x++) coarse.push(x / 10, front, z, x / 10, back, z);
    for (let y = Math.ceil(front * 10); y <= back * 10; y++) coarse.push(left, y / 10, z, right, y / 10, z);
    for (let x = Math.ceil(left * 100); x <= right * 100; x++) fine.push(x / 100, front, z, x / 100, front - (x % 5 ? 0.008 : 0.015), z);
    for (let y = Math.ceil(front * 100); y <= back * 100; y++) fine.push(left, y / 100, z, left - (y % 5 ? 0.008 : 0.015), y / 100, z);
    const lines = (points: number[], opacity: number) => {
      const geometry = new BufferGeometry().setAttribute('position', new Float32BufferAttribute(points, 3));
      return new LineSegments(geometry, new LineBasicMaterial({ color: 0x777777, transparent: true, opacity }));
    };
    this.#grid.add(lines(coarse, 0.35), lines(fine, 0.8));
    this.#grid.visible = false;
  }

  showGrid(visible: boolean): void {
    this.#grid.visible = visible;
    this.invalidate();
  }

  /** Draws the collision hulls of bodies; the files have their corners in the frame of each body. */
  async showHulls(urls: Map<string, string>): Promise<void> {
    // Those of the table would cover everything.
    const wanted = [...urls].filter(([name]) => this.#bodies.has(name) && !this.#hulls.has(name) && name !== this.#scene?.table.name);
    const files = await Promise.all(wanted.map(([, url]) => getJson<Hull[]>(url)));
    wanted.forEach(([name], body) => {
      const group = new Group();
      files[body]!.forEach((hull, index) => group.add(drawnHull(hull, index)));
      this.#bodies.get(name)!.add(group);
      this.#hulls.set(name, group);
    });
    this.#explode();
  }

  hideHulls(): void {
    for (const group of this.#hulls.values()) group.removeFromParent();
    this.#hulls.clear();
    this.invalidate();
  }

  /** Moves the hulls of each body apart, 0 to 1. */
  explode(share: number): void {
    this.#explosion = share;
    this.#explode();
  }

  #explode(): void {
    for (const group of this.#hulls.values()) {
      for (const hull of group.children) hull.position.copy(hull.userData.center).multiplyScalar(this.#explosion * 0.8);
    }
    this.invalidate();
  }

  /** Draws bodies of another scene where they stand there, as glass. */
  async showGhosts(url: string, names: Set<string>): Promise<void> {
    const { scene: root } = await new GLTFLoader().loadAsync(url);
    root.applyMatrix4(Z_UP);
    root.updateMatrixWorld(true);
    const glass = new MeshStandardMaterial({ color: this.#colors.hull, transparent: true, opacity: 0.35, depthWrite: false });
    const shown: Object3D[] = [];
    root.traverse((node) => names.has(node.name) && shown.push(node));
    this.hideGhosts();
    for (const node of shown) {
      node.traverse((part) => part instanceof Mesh && (part.material = glass));
      this.#ghosts.attach(node);
    }
    this.invalidate();
  }

  hideGhosts(): void {
    this.#ghosts.clear();
    this.invalidate();
  }

  /** Moves bodies to poses of the world, seven numbers each: position, then w, x, y, z. */
  setPoses(names: string[], poses: Float32Array): void {
    names.forEach((name, index) => {
      const body = this.#bodies.get(name);
      if (!body) return;
      const at = index * 7;
      body.position.set(poses[at]!, poses[at + 1]!, poses[at + 2]!);
      body.quaternion.set(poses[at + 4]!, poses[at + 5]!, poses[at + 6]!, poses[at + 3]!);
    });
    this.#redrawMass();
  }

  /** Moves all bodies back to the poses of the file. */
  resetPoses(): void {
    for (const [name, pose] of this.#rest) {
      const body = this.#bodies.get(name)!;
      body.position.copy(pose.position);
      body.quaternion.copy(pose.quaternion);
    }
    this.#redrawMass();
  }

  /** While it is on, two clicks measure a distance. */
  measure(on: boolean): void {
    this.#measuring = on;
    this.#points = [];
    this.#measure.clear();
    this.invalidate();
  }

  #addPoint(point: Vector3): void {
    if (this.#points.length === 2) {
      this.#points = [];
      this.#measure.clear();
    }
    this.#points.push(point.clone());
    const geometry = new SphereGeometry(0.004, 12, 8);
    const dot = new Mesh(geometry, new MeshBasicMaterial({ color: this.#colors.accent, depthTest: false, transparent: true }));
    dot.position.copy(point);
    dot.renderOrder = 7;
    this.#measure.add(dot);
    if (this.#points.length === 2) {
      const line = new LineSegments(
        new BufferGeometry().setFromPoints(this.#points),
        new LineBasicMaterial({ color: this.#colors.accent, depthTest: false, transparent: true }),
      );
      line.renderOrder = 7;
      this.#measure.add(line);
    }
    this.invalidate();
  }

  #labels(): Label[] {
    const labels: Label[] = [];
    const add = (point: Vector3, text: string, kind: Label['kind']) => labels.push({ text, kind, at: this.project(point) });
    if (this.#grid.visible && this.#scene) {
      const { outline_m } = this.#scene.table;
      const left = Math.min(...outline_m.map(([x]) => x));
      const front = Math.min(...outline_m.map(([, y]) => y));
      const right = Math.max(...outline_m.map(([x]) => x));
      const back = Math.max(...outline_m.map(([, y]) => y));
      for (let x = Math.ceil(left * 10); x <= right * 10; x += 2) add(new Vector3(x / 10, front - 0.035, 0), fixed(x * 10, 0), 'ruler');
      for (let y = Math.ceil(front * 10) + 1; y <= back * 10; y += 2) add(new Vector3(left - 0.035, y / 10, 0), fixed(y * 10, 0), 'ruler');
      add(new Vector3(right + 0.06, front - 0.035, 0), 'cm', 'ruler');
    }
    const [from, to] = this.#points;
    if (from && to) {
      const d = to.clone().sub(from);
      const cm = (value: number) => fixed(value * 100, 1);
      add(from.clone().add(to).multiplyScalar(0.5), `${cm(d.length())} cm  (x ${cm(d.x)}, y ${cm(d.y)}, z ${cm(d.z)})`, 'measure');
    }
    if (this.#selected) {
      const body = this.#bodies.get(this.#selected);
      const instance = this.#scene?.instances.find((one) => one.name === this.#selected);
      if (body && instance) add(body.localToWorld(new Vector3(0, 0, instance.size_m[2])), instance.label, 'object');
    }
    return labels;
  }

  /** A point of the world in pixels of the canvas. */
  project(point: Vector3): [number, number] | undefined {
    const seen = point.clone().project(this.#camera);
    if (seen.z > 1) return undefined;
    return [((seen.x + 1) / 2) * this.#host.clientWidth, ((1 - seen.y) / 2) * this.#host.clientHeight];
  }

  dispose(): void {
    cancelAnimationFrame(this.#frame);
    this.#resize.disconnect();
    this.#controls.dispose();
    this.#world.traverse((node) => {
      if (!(node instanceof Mesh)) return;
      node.geometry.dispose();
      for (const material of [node.material].flat()) {
        if ('map' in material) (material as MeshStandardMaterial).map?.dispose();
        material.dispose();
      }
    });
    this.#world.environment?.dispose();
    this.#renderer.dispose();
    this.#renderer.forceContextLoss();
    this.#renderer.domElement.remove();
  }
}
