// The color keys of the viewer, with the corresponding numbers.

import { h } from "../dom";
import { counted, percent } from "../format";
import { css, DIFFERENT_COLOR, rampColor, regionColor, SAME_COLOR, maxUncertainty, type Rgb } from "./colors";
import type { Answer, Surface } from "./surface";

function line(color: Rgb, text: string, value: string): HTMLElement {
  return h("li", {}, h("i", { style: `background: ${css(color)}` }), h("span", {}, text), h("span", { class: "number" }, value));
}

export function dataKey(surface: Surface): Node {
  return h("p", {}, `The data at ${counted(surface.vertices, "vertex", "vertices")}, as colors.`);
}

export function labelKey(surface: Surface, { labels }: Answer): Node {
  const counts = new Array<number>(surface.palette.length).fill(0);
  for (const label of labels) counts[label] = (counts[label] ?? 0) + 1;
  return h(
    "div",
    {},
    h("p", {}, "The label of a vertex is the largest entry of its row. Percentages are shares of the vertices."),
    h("ul", { class: "key" }, ...counts.map((count, p) => line(regionColor(surface, p), `region ${p}`, percent(count, labels.length)))),
  );
}

export function uncertaintyKey(surface: Surface, { certainty }: Answer): Node {
  const stops = [0, 0.25, 0.5, 0.75, 1].map((t) => css(rampColor(t))).join(", ");
  let undecided = 0;
  for (const value of certainty) if (value < 250) undecided++;
  return h(
    "div",
    {},
    h("p", {}, "One minus the largest entry of each row: zero where the relaxed solution is a label."),
    h("div", { class: "ramp", style: `background: linear-gradient(to right, ${stops})` }),
    h("div", { class: "ramp-ends" }, h("span", {}, "0"), h("span", {}, maxUncertainty(surface).toFixed(2))),
    h("p", {}, `${percent(undecided, certainty.length)} of the vertices are above 0.02.`),
  );
}

export function differenceKey(surface: Surface, differs: Uint8Array): Node {
  const count = differs.reduce((sum, differ) => sum + differ, 0);
  return h(
    "div",
    {},
    h("p", { class: "difference" }, `${counted(count, "vertex", "vertices")} (${percent(count, surface.vertices)}) with different labels.`),
    h("ul", { class: "key" }, line(DIFFERENT_COLOR, "different", ""), line(SAME_COLOR, "same", "")),
  );
}
