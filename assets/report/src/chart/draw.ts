// A chart as one SVG element without a style sheet: the same drawing is shown and saved.

import { line } from "d3-shape";
import { s } from "../dom";
import { color, dash, type Ink } from "../theme";
import type { Curve } from "./curves";
import type { Point } from "./middle";
import type { View } from "./samples";
import { scaleOf, ticksOf, type Domain, type Scale } from "./scale";

export interface Drawing {
  curves: Curve[];
  view: View;
  /** Whether to draw each repetition as a thin line instead of the median. */
  every: boolean;
  x: Domain;
  y: Domain;
  width: number;
  height: number;
  xLabel: string;
  yLabel: string;
  ink: Ink;
  /** A horizontal reference line, with its label. */
  level: { value: number; label: string } | null;
  /** In a saved chart only: on the page, title and legend are next to the chart. */
  title: string | null;
  legend: boolean;
}

export interface Frame {
  svg: SVGSVGElement;
  x: Scale;
  y: Scale;
  left: number;
  right: number;
  top: number;
  bottom: number;
}

const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', sans-serif";
/** Mean width of a letter at 13 pixels, accurate enough for the layout of a legend. */
const LETTER_WIDTH = 6.9;

export function draw(drawing: Drawing): Frame {
  const { curves, view, width, height, ink } = drawing;
  const left = 68;
  const right = width - 18;
  const top = drawing.title ? 62 : 30;
  const legend = drawing.legend ? legendOf(drawing, left, right, height + 6) : null;
  const total = height + (legend ? legend.height + 10 : 0);
  const bottom = height - 44;
  const x = scaleOf(drawing.x, view.logX, [left, right]);
  const y = scaleOf(drawing.y, view.logY, [bottom, top]);

  const svg = s("svg", {
    xmlns: "http://www.w3.org/2000/svg",
    viewBox: `0 0 ${width} ${total}`,
    width,
    height: total,
    "font-family": FONT,
    "font-size": 13,
    fill: ink.text,
  });
  if (drawing.title) {
    svg.append(
      s("rect", { width, height: total, fill: ink.background }),
      s("text", { x: 20, y: 26, "font-size": 15, "font-weight": 600 }, drawing.title),
    );
  }
  svg.append(
    s("clipPath", { id: "plot" }, s("rect", { x: left, y: top - 4, width: right - left + 4, height: bottom - top + 8 })),
    axes(drawing, x, y, { left, right, top, bottom }),
  );
  if (drawing.level) svg.append(level(drawing.level, y, left, right, ink));
  const plot = s("g", { "clip-path": "url(#plot)", class: "curves" });
  for (const curve of curves) plot.append(drawing.every ? strands(curve, x, y, ink) : median(curve, x, y, ink));
  svg.append(plot);
  if (legend) svg.append(legend.group);
  return { svg, x, y, left, right, top, bottom };
}

function axes(drawing: Drawing, x: Scale, y: Scale, box: Omit<Frame, "svg" | "x" | "y">): SVGGElement {
  const { ink, view } = drawing;
  const { left, right, top, bottom } = box;
  const grid = s("g", { stroke: ink.grid, "stroke-width": 1 });
  const labels = s("g", { fill: ink.muted, "font-size": 12 });
  for (const { value, label } of ticksOf(y, view.logY, 42)) {
    const at = y(value);
    grid.append(s("line", { x1: left, x2: right, y1: at, y2: at }));
    labels.append(s("text", { x: left - 8, y: at + 4, "text-anchor": "end" }, label));
  }
  for (const { value, label } of ticksOf(x, view.logX, 72)) {
    const at = x(value);
    grid.append(s("line", { x1: at, x2: at, y1: top, y2: bottom }));
    labels.append(s("text", { x: at, y: bottom + 19, "text-anchor": "middle" }, label));
  }
  return s(
    "g",
    {},
    grid,
    s("line", { x1: left, x2: right, y1: bottom, y2: bottom, stroke: ink.muted }),
    labels,
    s("text", { x: left, y: top - 14, "text-anchor": "start" }, drawing.yLabel),
    s("text", { x: right, y: bottom + 38, "text-anchor": "end" }, drawing.xLabel),
  );
}

function level({ value, label }: { value: number; label: string }, y: Scale, left: number, right: number, ink: Ink) {
  const at = y(value);
  const [bottom = 0, top = 0] = y.range();
  if (!(at <= bottom && at >= top)) return s("g");
  return s(
    "g",
    { class: "level" },
    s("line", { x1: left, x2: right, y1: at, y2: at, stroke: ink.muted, "stroke-dasharray": "1 3" }),
    s(
      "text",
      { x: right, y: at - 6, "text-anchor": "end", "font-size": 12, fill: ink.muted, stroke: ink.background, "stroke-width": 4, "paint-order": "stroke" },
      label,
    ),
  );
}

type Position = [number, number];

/** Drops points that moved by less than a pixel, so that long traces stay small. */
function thinned(points: Position[]): Position[] {
  const kept: Position[] = [];
  points.forEach((point, index) => {
    const last = kept[kept.length - 1];
    const moved = !last || Math.abs(point[0] - last[0]) + Math.abs(point[1] - last[1]) >= 0.8;
    if (moved || index === points.length - 1) kept.push(point);
  });
  return kept;
}

const path = (points: Point[], x: Scale, y: Scale) => line()(thinned(points.map((point) => [x(point.x), y(point.y)]))) ?? "";

function median({ solver, middle }: Curve, x: Scale, y: Scale, ink: Ink): SVGGElement {
  const stroke = color(solver.style, ink.dark);
  const group = s("g", { "data-solver": solver.id });
  const { low, high } = middle;
  if (low.some((point, i) => point.x !== high[i]?.x || point.y !== high[i]?.y)) {
    const outline = `${path([...low, ...high.toReversed()], x, y)}Z`;
    group.append(s("path", { class: "band", d: outline, fill: stroke, "fill-opacity": ink.dark ? 0.25 : 0.16 }));
  }
  group.append(
    s("path", {
      class: "line",
      d: path(middle.median, x, y),
      fill: "none",
      stroke,
      "stroke-width": 2.2,
      "stroke-linejoin": "round",
      "stroke-dasharray": dash(solver.style) || null,
    }),
  );
  const end = middle.median[middle.median.length - 1];
  if (end) group.append(s("circle", { cx: x(end.x), cy: y(end.y), r: 3.2, fill: stroke }));
  return group;
}

function strands({ solver, strands }: Curve, x: Scale, y: Scale, ink: Ink): SVGGElement {
  const stroke = color(solver.style, ink.dark);
  return s(
    "g",
    { "data-solver": solver.id, fill: "none", stroke, "stroke-width": 1.2, "stroke-opacity": 0.85 },
    ...strands.map((strand) =>
      s("path", {
        class: "line",
        d: path(strand, x, y),
        "stroke-dasharray": dash(solver.style) || null,
      }),
    ),
  );
}

/** A sample of a solver's line. */
export function swatch(style: number, ink: Ink, x = 0, y = 6): SVGLineElement {
  return s("line", {
    x1: x,
    x2: x + 30,
    y1: y,
    y2: y,
    stroke: color(style, ink.dark),
    "stroke-width": 2.4,
    "stroke-dasharray": dash(style) || null,
  });
}

function legendOf(drawing: Drawing, left: number, right: number, top: number) {
  const group = s("g");
  let x = left;
  let row = 0;
  for (const { solver } of drawing.curves) {
    const needed = 38 + solver.label.length * LETTER_WIDTH + 22;
    if (x + needed > right && x > left) {
      x = left;
      row++;
    }
    const y = top + 14 + row * 22;
    group.append(swatch(solver.style, drawing.ink, x, y - 4), s("text", { x: x + 38, y }, solver.label));
    x += needed;
  }
  return { group, height: (row + 1) * 22 };
}
