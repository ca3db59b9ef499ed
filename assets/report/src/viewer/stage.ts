// The stage: one surface in a canvas, redrawn only after changes.

import { WebGLRenderer } from "three";
import { h } from "../dom";
import { eye } from "./eye";
import { solid } from "./solid";
import type { Surface } from "./surface";

export interface Stage {
  element: HTMLCanvasElement;
  show(surface: Surface): void;
  /** Paints vertex colors, blended over faces or, if classes are given, cut between vertices of different classes. */
  paint(colors: Uint8Array, classes: Uint8Array | null): void;
  reset(): void;
  /** The current view as a PNG file. */
  picture(): Promise<Blob | null>;
}

/** A renderer into a canvas, or null if the browser has no WebGL; `lost` is called if the browser closes it later. */
export function rendererInto(canvas: HTMLCanvasElement, lost: () => void): WebGLRenderer | null {
  // Requested before three.js does, which would log an error.
  const context = canvas.getContext("webgl2", { antialias: true, alpha: true });
  if (!context) return null;
  canvas.addEventListener("webglcontextlost", lost);
  return new WebGLRenderer({ canvas, context, antialias: true, alpha: true });
}

/** Calls back in the next frame, once for all requests until then. */
export function onceInFrame(draw: () => void): () => void {
  let waiting = false;
  return () => {
    if (!waiting) {
      requestAnimationFrame(() => {
        waiting = false;
        draw();
      });
    }
    waiting = true;
  };
}

/** A stage, or null if the browser has no WebGL; `lost` is called if the browser closes the context later. */
export function stage(lost: () => void): Stage | null {
  const canvas = h("canvas", {
    tabindex: "0",
    role: "img",
    "aria-label": "3-D view of the mesh: arrow keys rotate it, plus and minus zoom",
  });
  const renderer = rendererInto(canvas, lost);
  if (!renderer) return null;

  const render = () => renderer.render(view.scene, view.camera);
  const request = onceInFrame(render);
  const view = eye(canvas, request);
  const shown = solid();
  shown.object.visible = false;
  view.scene.add(shown.object);

  new ResizeObserver(() => {
    const { clientWidth: width, clientHeight: height } = canvas;
    if (width === 0 || height === 0) return;
    renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    renderer.setSize(width, height, false);
    view.resize(width, height);
    render();
  }).observe(canvas);

  let placed = false;
  return {
    element: canvas,
    show(surface) {
      const towards = shown.show(surface);
      shown.object.visible = true;
      if (placed) return;
      placed = true;
      view.place(towards);
    },
    paint(colors, classes) {
      shown.paint(colors, classes);
      request();
    },
    reset: () => view.reset(),
    picture() {
      // Rendered now, since the browser discards a drawing after showing it.
      render();
      return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
    },
  };
}
