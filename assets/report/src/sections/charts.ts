// Section: the curves of one instance, on selectable axes.

import { curvesOf, type Curve, type Curves } from "../chart/curves";
import { draw, type Drawing, type Frame } from "../chart/draw";
import { legend } from "../chart/legend";
import { trackPointer } from "../chart/pointer";
import type { Axis, Quantity, View } from "../chart/samples";
import { domainOf, type Domain } from "../chart/scale";
import { emptyText, factsOf, notesOf, X_LABELS, Y_LABELS } from "../chart/words";
import type { Instance, Report, Run } from "../data";
import { h } from "../dom";
import { fileStem, save, svgBlob } from "../download";
import { ink, onThemeChange, PAPER } from "../theme";
import { choice } from "../widgets/choice";
import { combobox } from "../widgets/combobox";

/** The size of a saved chart, about half a slide. */
const SAVED = { width: 900, height: 540 };

/** The quantities that some run has. */
function recorded(runs: Run[]): { value: Quantity; label: string; hint?: string }[] {
  const all: { value: Quantity; label: string; hint?: string }[] = [
    { value: "relative_gap", label: "gap", hint: Y_LABELS.relative_gap },
    { value: "suboptimality", label: "suboptimality" },
    { value: "energy", label: "energy" },
    { value: "distance", label: "distance", hint: Y_LABELS.distance },
    { value: "mislabeled", label: "mislabeled", hint: Y_LABELS.mislabeled },
    { value: "silhouette_iou", label: "silhouettes", hint: Y_LABELS.silhouette_iou },
  ];
  const has = (quantity: Quantity) => runs.some((run) => run.trace[quantity]?.some((value) => value !== null));
  return all.filter(({ value }) => has(value));
}

export function charts(report: Report): Node {
  const { instances, runs } = report.data;
  let instance = instances.find((one) => runs.some((run) => run.instance === one.id)) as Instance;
  const quantities = recorded(runs);
  // Surfaces are also measured before the first step, which a logarithmic axis cannot show.
  const certified = quantities.some(({ value }) => value === "relative_gap");
  const logOf: Record<Quantity, boolean> = {
    relative_gap: true, suboptimality: true, energy: false, distance: true, mislabeled: true, silhouette_iou: false,
  };
  const first = quantities[0]?.value ?? "energy";
  const view: View = { quantity: first, axis: "iteration", logX: certified, logY: logOf[first] };
  let every = false;
  let zoom: { x: Domain; y: Domain } | null = null;
  let data: Curves;
  let frame: Frame;
  const hidden = new Set<string>();

  const picture = h("div", { class: "picture" });
  const plot = h("div", { class: "plot", tabindex: "0", role: "application", "aria-roledescription": "chart" }, picture);
  const empty = h("p", { class: "empty", hidden: true });
  const notes = h("p", { class: "hint" });
  const facts = h("p", { class: "facts" });
  const unzoom = h("button", { type: "button", hidden: true, onclick: () => zoomTo(null) }, "Reset zoom");
  const key = legend(hidden, () => redraw());

  const visible = (): Curve[] => data.curves.filter((curve) => !hidden.has(curve.solver.id));

  function zoomTo(to: typeof zoom): void {
    zoom = to;
    redraw();
  }

  /** Domains of all curves, including hidden ones, so that hiding one does not move the others. */
  function domains(): { x: Domain; y: Domain } {
    const samples = data.curves.flatMap((curve) => curve.strands.flat());
    const ys = samples.map((sample) => sample.y);
    const known = bound();
    if (known && samples.length > 0) ys.push(known.value);
    return { x: domainOf(samples.map((sample) => sample.x), view.logX), y: domainOf(ys, view.logY) };
  }

  function bound(): Drawing["level"] {
    const value = instance.best_bound;
    if (view.quantity !== "energy" || value === null || (view.logY && value <= 0)) return null;
    return { value, label: "best lower bound" };
  }

  function drawing(): Drawing {
    return {
      curves: visible(),
      view,
      every,
      ...(zoom ?? domains()),
      width: Math.max(320, plot.clientWidth),
      height: Math.min(560, Math.max(340, plot.clientWidth * 0.56)),
      xLabel: X_LABELS[view.axis],
      yLabel: Y_LABELS[view.quantity],
      ink: ink(),
      level: bound(),
      title: null,
      legend: false,
    };
  }

  /** Updates the data after a change of the axes or the instance. */
  function recompute(): void {
    zoom = null;
    data = curvesOf(report, instance, view);
    key.offer(data.curves.map((curve) => curve.solver), data.absent);
    facts.textContent = factsOf(instance);
    redraw();
  }

  function redraw(): void {
    pointer.clear();
    frame = draw(drawing());
    picture.replaceChildren(frame.svg);
    unzoom.hidden = zoom === null;
    plot.setAttribute(
      "aria-label",
      `${Y_LABELS[view.quantity]} over ${X_LABELS[view.axis]}, ${instance.label}. ` +
        "Arrow keys read samples, Escape resets the zoom.",
    );
    empty.hidden = data.curves.length > 0;
    empty.textContent = emptyText(view);
    notes.textContent = notesOf(data, view, every);
  }

  function saveSvg(): void {
    const { svg } = draw({ ...drawing(), ...SAVED, ink: PAPER, title: instance.label, legend: true });
    const stem = fileStem([report.data.name, instance.label, view.quantity, view.axis].join(" "));
    save(`${stem}.svg`, svgBlob(new XMLSerializer().serializeToString(svg)));
  }

  const pointer = trackPointer(
    plot,
    {
      current: () => ({ frame, curves: visible() }),
      zoom: (x, y) => zoomTo({ x, y }),
      reset: () => zoomTo(null),
    },
    () => view.quantity,
  );

  const scale = (label: string, isLog: () => boolean, set: (log: boolean) => void) =>
    choice(
      label,
      [{ value: "log", label: "log" }, { value: "linear", label: "linear" }],
      isLog() ? "log" : "linear",
      (value) => {
        set(value === "log");
        recompute();
      },
    );
  const scaleX = scale("x scale", () => view.logX, (log) => { view.logX = log; });
  const scaleY = scale("y scale", () => view.logY, (log) => { view.logY = logOf[view.quantity] = log; });
  const repeated = runs.some((run) => run.repetition > 0);

  const controls = h(
    "div",
    { class: "controls" },
    choice<Quantity>(
      "y",
      quantities,
      view.quantity,
      (quantity) => {
        view.quantity = quantity;
        view.logY = logOf[quantity];
        scaleY.set(view.logY ? "log" : "linear");
        recompute();
      },
    ).element,
    scaleY.element,
    choice<Axis>(
      "x",
      [{ value: "iteration", label: "iterations" }, { value: "seconds", label: "seconds" }],
      view.axis,
      (axis) => {
        view.axis = axis;
        recompute();
      },
    ).element,
    scaleX.element,
    repeated
      ? choice(
          "repetitions",
          [{ value: "median", label: "median" }, { value: "every", label: "each" }],
          "median",
          (value) => {
            every = value === "every";
            redraw();
          },
        ).element
      : null,
  );
  const side = h(
    "div",
    { class: "side" },
    key.element,
    h(
      "div",
      { class: "actions" },
      unzoom,
      h("button", { type: "button", "data-action": "save-chart", onclick: saveSvg }, "Download SVG"),
    ),
    h("p", { class: "hint" }, "Drag in the chart to zoom; double-click it to reset the zoom."),
  );

  // The first reported size triggers the first drawing.
  let width = 0;
  new ResizeObserver(() => {
    if (plot.clientWidth === width) return;
    width = plot.clientWidth;
    redraw();
  }).observe(plot);
  onThemeChange(() => redraw());
  recompute();

  return h(
    "div",
    {},
    combobox(
      "Instance",
      instances.map((one) => ({ value: one.id, label: one.label })),
      instance.id,
      (id) => {
        instance = instances.find((one) => one.id === id) ?? instance;
        recompute();
      },
    ),
    facts,
    controls,
    h("div", { class: "chart" }, h("div", { class: "chart-main" }, plot, empty, notes), side),
  );
}
