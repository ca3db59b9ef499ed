// Section: the meshes in 3-D, with the labels of each solver.

import type { Report } from "../data";
import { h } from "../dom";
import { fileStem, save } from "../download";
import { differenceColors, differences, labelColors, uncertaintyColors } from "../viewer/colors";
import { dataKey, differenceKey, labelKey, uncertaintyKey } from "../viewer/key";
import { stage } from "../viewer/stage";
import { surfaceOf, type Surface } from "../viewer/surface";
import { choice, type Choice } from "../widgets/choice";
import { combobox } from "../widgets/combobox";

type Mode = "data" | "labels" | "uncertainty" | "difference";

export function viewer(report: Report): Node {
  const { scenes, instances, solvers } = report.data;
  const shown = instances.filter((instance) => instance.scene !== null && scenes[instance.scene]);

  const message = h("p", { class: "empty", hidden: true });
  const fail = (text: string) => {
    message.textContent = text;
    message.hidden = false;
  };
  const view = stage(() => fail("The browser closed the 3-D view (its graphics context was lost). Reload the page to restore it."));
  if (!view) {
    fail("This browser has no WebGL, so the meshes cannot be shown in 3-D. The rest of this page works without it.");
    return message;
  }

  const surfaces = new Map<string, Surface>();
  let instance = shown[0];
  let surface: Surface;
  let mode: Mode = "labels";
  let solver = "";
  let other = "";

  const key = h("div", { class: "viewer-key", role: "status" });
  const solverSlot = h("div");
  const otherSlot = h("div");
  let solverChoice: Choice<string>;

  const modes = choice<Mode>(
    "Show",
    [
      { value: "data", label: "data" },
      { value: "labels", label: "labels" },
      { value: "uncertainty", label: "uncertainty" },
      { value: "difference", label: "difference" },
    ],
    mode,
    (chosen) => {
      mode = chosen;
      paint();
    },
  );

  /** Loads the surface of the current instance, and the solvers that have labels on it. */
  function load(): void {
    const id = instance?.scene ?? "";
    const scene = scenes[id];
    if (!scene) return;
    surface = surfaces.get(id) ?? surfaceOf(scene, scenes);
    surfaces.set(id, surface);
    view?.show(surface);

    const solved = solvers.filter((one) => scene.solutions[one.id]);
    const has = (one: string) => solved.some(({ id }) => id === one);
    if (!has(solver)) solver = solved[0]?.id ?? "";
    if (!has(other) || other === solver) other = solved.find(({ id }) => id !== solver)?.id ?? solver;
    if (solved.length === 0) mode = "data";
    const options = solved.map(({ id, label }) => ({ value: id, label }));
    solverChoice = choice("Solver", options, solver, (chosen) => {
      solver = chosen;
      // Choosing a solver leaves the data mode, which does not depend on one.
      if (mode === "data") mode = "labels";
      paint();
    }, "stacked");
    const otherChoice = choice("Compared with", options, other, (chosen) => {
      other = chosen;
      paint();
    }, "stacked");
    solverSlot.replaceChildren(solverChoice.element);
    otherSlot.replaceChildren(otherChoice.element);
    paint();
  }

  function paint(): void {
    modes.set(mode);
    solverChoice.set(mode === "data" ? null : solver);
    otherSlot.hidden = mode !== "difference";
    const a = surface.answer(solver);
    const b = surface.answer(other);
    if (mode === "labels" && a) {
      display(labelColors(surface, a), a.labels, labelKey(surface, a));
    } else if (mode === "uncertainty" && a) {
      display(uncertaintyColors(surface, a), null, uncertaintyKey(surface, a));
    } else if (mode === "difference" && a && b) {
      const differs = differences(a, b);
      display(differenceColors(surface, differs), differs, differenceKey(surface, differs));
    } else {
      display(surface.data, null, dataKey(surface));
    }
  }

  function display(colors: Uint8Array, classes: Uint8Array | null, meaning: Node): void {
    view?.paint(colors, classes);
    key.replaceChildren(meaning);
  }

  async function savePicture(): Promise<void> {
    const blob = await view?.picture();
    if (!blob) return;
    const solved = mode === "data" ? "" : solver;
    save(`${fileStem([report.data.name, instance?.label, mode, solved].join(" "))}.png`, blob);
  }

  const box = h("div", { class: "stage" }, view.element, message);
  load();
  return h(
    "div",
    {},
    h("div", { class: "controls" }, combobox(
      "Instance",
      shown.map(({ id, label }) => ({ value: id, label })),
      instance?.id ?? "",
      (id) => {
        instance = shown.find((one) => one.id === id);
        load();
      },
    ), modes.element),
    h(
      "div",
      { class: "viewer" },
      box,
      h(
        "div",
        { class: "side" },
        solverSlot,
        otherSlot,
        key,
        h(
          "div",
          { class: "actions" },
          h("button", { type: "button", onclick: () => view.reset() }, "Reset view"),
          h("button", { type: "button", onclick: () => void box.requestFullscreen() }, "Full screen"),
          h("button", { type: "button", onclick: () => void savePicture() }, "Save PNG"),
        ),
        h("p", { class: "hint" }, "Drag to rotate, right-drag to pan; click the mesh, then scroll to zoom. Switching keeps the camera."),
      ),
    ),
  );
}
