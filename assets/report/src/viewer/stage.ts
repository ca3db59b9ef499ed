// The stage: one surface and a camera with a headlight, redrawn only after changes.

import {
  AmbientLight, BufferAttribute, BufferGeometry, DirectionalLight, DoubleSide, Mesh, MeshLambertMaterial,
  PerspectiveCamera, Quaternion, Scene, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { h } from "../dom";
import { cut, type Smooth } from "./cut";
import type { Surface } from "./surface";

/** The vertical field of view in degrees; small, so that shapes are hardly distorted. */
const FIELD_OF_VIEW = 30;
/** The camera distance at which the unit ball fills the view. */
const DISTANCE = 3.9;
const UP = new Vector3(0, 1, 0);
const TURN_ANGLE = Math.PI / 24;

/** From sRGB bytes to linear light, which the renderer uses. */
const LINEAR_FROM_SRGB = Float32Array.from({ length: 256 }, (_, byte) => {
  const value = byte / 255;
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
});

export interface Stage {
  element: HTMLCanvasElement;
  show(surface: Surface): void;
  /** Paints vertex colors, blended over faces or, if classes are given, cut between vertices of different classes. */
  paint(colors: Uint8Array, classes: Uint8Array | null): void;
  reset(): void;
  /** The current view as a PNG file. */
  picture(): Promise<Blob | null>;
}

/** A stage, or null if the browser has no WebGL; `lost` is called if the browser closes the context later. */
export function stage(lost: () => void): Stage | null {
  const canvas = h("canvas", {
    tabindex: "0",
    role: "img",
    "aria-label": "3-D view of the mesh: arrow keys rotate it, plus and minus zoom",
  });
  // Requested before three.js does, which would log an error.
  const context = canvas.getContext("webgl2", { antialias: true, alpha: true });
  if (!context) return null;
  const renderer = new WebGLRenderer({ canvas, context, antialias: true, alpha: true });
  canvas.addEventListener("webglcontextlost", lost);

  const geometry = new BufferGeometry();
  // Both sides, since the inside of a scanned surface can be visible through holes.
  const mesh = new Mesh(geometry, new MeshLambertMaterial({ vertexColors: true, side: DoubleSide }));
  mesh.visible = false;
  const camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 100);
  const headlight = new DirectionalLight(0xffffff, 2.5);
  headlight.position.set(-0.4, 0.6, 1);
  headlight.target.position.set(0, 0, -1);
  camera.add(headlight, headlight.target);
  const scene = new Scene();
  scene.add(mesh, camera, new AmbientLight(0xffffff, 0.95));

  let waiting = false;
  const render = () => {
    waiting = false;
    renderer.render(scene, camera);
  };
  const request = () => {
    if (!waiting) requestAnimationFrame(render);
    waiting = true;
  };

  camera.position.set(0, 0, DISTANCE);
  const controls = new OrbitControls(camera, canvas);
  controls.minDistance = 0.2;
  controls.maxDistance = 20;
  // The wheel scrolls the page until the view has the focus.
  controls.enableZoom = false;
  canvas.addEventListener("focus", () => { controls.enableZoom = true; });
  canvas.addEventListener("blur", () => { controls.enableZoom = false; });
  canvas.addEventListener("pointerdown", () => canvas.focus({ preventScroll: true }));
  controls.addEventListener("change", request);

  canvas.addEventListener("keydown", (event) => {
    const actions: Record<string, () => void> = {
      ArrowLeft: () => controls.rotateLeft(TURN_ANGLE),
      ArrowRight: () => controls.rotateLeft(-TURN_ANGLE),
      ArrowUp: () => controls.rotateUp(TURN_ANGLE),
      ArrowDown: () => controls.rotateUp(-TURN_ANGLE),
      "+": () => controls.dollyIn(0.85),
      "=": () => controls.dollyIn(0.85),
      "-": () => controls.dollyOut(0.85),
    };
    const action = actions[event.key];
    if (!action || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    action();
    request();
  });

  new ResizeObserver(() => {
    const { clientWidth: width, clientHeight: height } = canvas;
    if (width === 0 || height === 0) return;
    renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    render();
  }).observe(canvas);

  let smooth: Smooth;
  let placed = false;
  const put = (positions: Float32Array, normals: Float32Array, index: Uint32Array, colors: Uint8Array) => {
    // The renderer keeps the buffers of a geometry until it is disposed.
    geometry.dispose();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("normal", new BufferAttribute(normals, 3));
    geometry.setAttribute("color", new BufferAttribute(Float32Array.from(colors, (byte) => LINEAR_FROM_SRGB[byte] ?? 0), 3));
    geometry.setIndex(new BufferAttribute(index, 1));
    request();
  };

  return {
    element: canvas,
    show(surface) {
      const { positions, faces } = surface;
      geometry.setAttribute("position", new BufferAttribute(positions, 3));
      geometry.setIndex(new BufferAttribute(faces, 1));
      geometry.deleteAttribute("normal");
      geometry.computeVertexNormals();
      geometry.computeBoundingSphere();
      smooth = { positions, faces, normals: geometry.getAttribute("normal").array as Float32Array };
      // Every surface is scaled to the unit ball and upright, so that the camera can keep its position.
      const sphere = geometry.boundingSphere;
      const scale = sphere && sphere.radius > 0 ? 1 / sphere.radius : 1;
      const upright = new Quaternion().setFromUnitVectors(new Vector3(...surface.view.up).normalize(), UP);
      mesh.scale.setScalar(scale);
      mesh.quaternion.copy(upright);
      mesh.position.copy(sphere?.center ?? new Vector3()).applyQuaternion(upright).multiplyScalar(-scale);
      mesh.visible = true;
      if (placed) return;
      placed = true;
      camera.position.set(...surface.view.towards).applyQuaternion(upright).setLength(DISTANCE);
      controls.update();
      controls.saveState();
    },
    paint(colors, classes) {
      if (!classes) return put(smooth.positions, smooth.normals, smooth.faces, colors);
      const pieces = cut(smooth, colors, classes);
      put(pieces.positions, pieces.normals, pieces.index, pieces.colors);
    },
    reset() {
      controls.reset();
      request();
    },
    picture() {
      // Rendered now, since the browser discards a drawing after showing it.
      render();
      return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
    },
  };
}
