// Interaction with a chart: the sample nearest to the pointer, samples by arrow keys, zoom by drag.

import { h, s } from "../dom";
import { gap, seconds, significant } from "../format";
import { color, dash, ink } from "../theme";
import type { Curve } from "./curves";
import type { Frame } from "./draw";
import type { Quantity, Sample } from "./samples";
import type { Domain } from "./scale";

export interface Drawn {
  frame: Frame;
  curves: Curve[];
}

export interface Listener {
  /** The current drawing. */
  current(): Drawn;
  zoom(x: Domain, y: Domain): void;
  reset(): void;
}

/** The maximum distance between the pointer and the sample that it reads. */
const REACH_PIXELS = 60;
/** A shorter drag is a click; a drag that is narrower than this along one axis zooms the other axis only. */
const MIN_DRAG_PIXELS = 8;

const VALUE_NAMES: Record<Quantity, string> = {
  relative_gap: "relative gap",
  suboptimality: "suboptimality",
  energy: "energy",
  distance: "distance",
  mislabeled: "mislabeled",
  silhouette_iou: "silhouettes",
};

export function trackPointer(host: HTMLElement, listener: Listener, quantity: () => Quantity): { clear(): void } {
  const tip = h("div", { class: "tip", role: "status", hidden: true });
  host.append(tip);
  let mark: SVGElement | null = null;
  let at: { curve: number; strand: number; sample: number } | null = null;
  let from: { x: number; y: number } | null = null;

  function clear(): void {
    mark?.remove();
    mark = null;
    tip.hidden = true;
  }

  function read(curve: Curve, sample: Sample): void {
    clear();
    const { frame } = listener.current();
    const { run, index } = sample;
    const x = frame.x(sample.x);
    const y = frame.y(sample.y);
    mark = s("circle", {
      class: "mark",
      cx: x,
      cy: y,
      r: 5.5,
      fill: color(curve.solver.style, ink().dark),
      stroke: ink().background,
      "stroke-width": 2,
    });
    frame.svg.append(mark);
    const line = s("svg", { width: 26, height: 10, "aria-hidden": "true" });
    line.append(
      s("line", {
        x1: 0, x2: 26, y1: 5, y2: 5, stroke: color(curve.solver.style, ink().dark), "stroke-width": 2.4,
        "stroke-dasharray": dash(curve.solver.style) || null,
      }),
    );
    const name = quantity();
    const value = run.trace[name]?.[index];
    const rows: [string, string][] = [
      [VALUE_NAMES[name], name === "energy" ? significant(value, 7) : name === "silhouette_iou" ? significant(value, 4) : gap(value)],
      [run.dual_bound === null ? "step" : "iteration", significant(run.trace.iteration[index])],
      ["seconds", seconds(run.trace.seconds[index])],
      ["run", curve.strands.length > 1 ? `${run.id}, repetition ${run.repetition + 1}` : run.id],
    ];
    tip.replaceChildren(
      h("strong", {}, line, curve.solver.label),
      h("dl", {}, ...rows.flatMap(([term, text]) => [h("dt", {}, term), h("dd", {}, text)])),
    );
    tip.hidden = false;
    // Next to the sample, on the side with more room.
    const next = x > (frame.left + frame.right) / 2 ? x - tip.offsetWidth - 14 : x + 14;
    tip.style.left = `${Math.max(0, next)}px`;
    tip.style.top = `${Math.max(frame.top, Math.min(frame.bottom - tip.offsetHeight, y - tip.offsetHeight / 2))}px`;
  }

  function inside(frame: Frame, sample: Sample): { x: number; y: number } | null {
    const x = frame.x(sample.x);
    const y = frame.y(sample.y);
    const visible = x >= frame.left - 1 && x <= frame.right + 1 && y >= frame.top - 1 && y <= frame.bottom + 1;
    return visible ? { x, y } : null;
  }

  function nearest(px: number, py: number): void {
    const { frame, curves } = listener.current();
    let best = REACH_PIXELS ** 2;
    at = null;
    curves.forEach((curve, c) =>
      curve.strands.forEach((strand, t) =>
        strand.forEach((sample, i) => {
          const point = inside(frame, sample);
          if (!point) return;
          const distance = (point.x - px) ** 2 + (point.y - py) ** 2;
          if (distance < best) {
            best = distance;
            at = { curve: c, strand: t, sample: i };
          }
        }),
      ),
    );
    show();
  }

  function show(): void {
    const curve = at && listener.current().curves[at.curve];
    const sample = at && curve?.strands[at.strand]?.[at.sample];
    if (curve && sample) read(curve, sample);
    else clear();
  }

  function position(event: PointerEvent): { x: number; y: number } {
    const box = host.getBoundingClientRect();
    const { left, right, top, bottom } = listener.current().frame;
    return {
      x: Math.min(right, Math.max(left, event.clientX - box.left)),
      y: Math.min(bottom, Math.max(top, event.clientY - box.top)),
    };
  }

  /** The dragged rectangle, which spans the whole of an axis along which the drag hardly moved. */
  function rectangle(to: { x: number; y: number }) {
    if (!from) return null;
    const { left, right, top, bottom } = listener.current().frame;
    const wide = Math.abs(to.x - from.x) >= MIN_DRAG_PIXELS;
    const high = Math.abs(to.y - from.y) >= MIN_DRAG_PIXELS;
    if (!wide && !high) return null;
    const [x1, x2] = wide ? [Math.min(from.x, to.x), Math.max(from.x, to.x)] : [left, right];
    const [y1, y2] = high ? [Math.min(from.y, to.y), Math.max(from.y, to.y)] : [top, bottom];
    return { x1, x2, y1, y2 };
  }

  host.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || event.pointerType === "touch") return;
    from = position(event);
    host.setPointerCapture(event.pointerId);
  });
  host.addEventListener("pointermove", (event) => {
    const to = position(event);
    if (!from) return nearest(to.x, to.y);
    clear();
    const box = rectangle(to);
    if (!box) return;
    mark = s("rect", {
      class: "zoom", x: box.x1, y: box.y1, width: box.x2 - box.x1, height: box.y2 - box.y1,
      fill: ink().text, "fill-opacity": 0.07, stroke: ink().muted, "stroke-dasharray": "3 3",
    });
    listener.current().frame.svg.append(mark);
  });
  host.addEventListener("pointerup", (event) => {
    const box = from && rectangle(position(event));
    from = null;
    clear();
    if (!box) return;
    const { x, y } = listener.current().frame;
    listener.zoom([x.invert(box.x1), x.invert(box.x2)], [y.invert(box.y2), y.invert(box.y1)]);
  });
  host.addEventListener("pointercancel", () => {
    from = null;
    clear();
  });
  host.addEventListener("pointerleave", () => {
    if (!from) clear();
  });
  host.addEventListener("dblclick", () => listener.reset());
  host.addEventListener("blur", clear);
  host.addEventListener("keydown", (event) => {
    if (event.key === "Escape") {
      from = null;
      clear();
      return listener.reset();
    }
    const along = { ArrowLeft: -1, ArrowRight: 1 }[event.key] ?? 0;
    const across = { ArrowUp: -1, ArrowDown: 1 }[event.key] ?? 0;
    const { curves } = listener.current();
    if ((along === 0 && across === 0) || curves.length === 0) return;
    event.preventDefault();
    if (!at) at = { curve: 0, strand: 0, sample: 0 };
    else if (across !== 0) at = { curve: (at.curve + across + curves.length) % curves.length, strand: 0, sample: at.sample };
    else at.sample += along;
    const last = (curves[at.curve]?.strands[at.strand]?.length ?? 1) - 1;
    at.sample = Math.min(last, Math.max(0, at.sample));
    show();
  });

  return { clear };
}
