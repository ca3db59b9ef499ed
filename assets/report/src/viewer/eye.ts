// The eye: a scene with a camera and a headlight, turned by dragging and by keys.

import { AmbientLight, DirectionalLight, PerspectiveCamera, Scene, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

/** The vertical field of view in degrees; small, so that shapes are hardly distorted. */
const FIELD_OF_VIEW = 30;
/** The camera distance at which the unit ball fills the view. */
const DISTANCE = 3.9;
const TURN_ANGLE = Math.PI / 24;

export interface Eye {
  scene: Scene;
  camera: PerspectiveCamera;
  /** Puts the camera in a direction from the center, where `reset` returns to. */
  place(towards: Vector3): void;
  /** Sets the size of a view, and of the element in which dragging turns it. */
  resize(width: number, height: number, whole?: number): void;
  reset(): void;
}

/** An eye that is controlled in an element; `changed` is called after its camera moved. */
export function eye(element: HTMLElement, changed: () => void): Eye {
  const camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 100);
  const headlight = new DirectionalLight(0xffffff, 2.5);
  headlight.position.set(-0.4, 0.6, 1);
  headlight.target.position.set(0, 0, -1);
  camera.add(headlight, headlight.target);
  const scene = new Scene();
  scene.add(camera, new AmbientLight(0xffffff, 0.95));

  camera.position.set(0, 0, DISTANCE);
  const controls = new OrbitControls(camera, element);
  controls.minDistance = 0.2;
  controls.maxDistance = 20;
  // The wheel scrolls the page until the view has the focus.
  controls.enableZoom = false;
  element.addEventListener("focus", () => { controls.enableZoom = true; });
  element.addEventListener("blur", () => { controls.enableZoom = false; });
  element.addEventListener("pointerdown", () => element.focus({ preventScroll: true }));
  controls.addEventListener("change", changed);

  element.addEventListener("keydown", (event) => {
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
    changed();
  });

  return {
    scene,
    camera,
    place(towards) {
      camera.position.copy(towards).setLength(DISTANCE);
      controls.update();
      controls.saveState();
    },
    resize(width, height, whole = height) {
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      // Dragging by the height of a view is half a turn, however high the element is.
      controls.rotateSpeed = whole / height;
      controls.panSpeed = whole / height;
    },
    reset() {
      controls.reset();
      changed();
    },
  };
}
