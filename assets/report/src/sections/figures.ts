// Section: the figures drawn by the program.

import type { FigureData, Report } from "../data";
import { h } from "../dom";
import { save, svgBlob } from "../download";
import { onThemeChange, themedColor } from "../theme";

export function figures(report: Report): Node {
  return h("div", { class: "figures" }, ...report.data.figures.map(figure));
}

function figure({ title, caption, svg, stem, surfaces }: FigureData): HTMLElement {
  const paper = h("div", { class: "paper", role: "img", "aria-label": title });
  // In its own shadow tree, so that the ids and styles of one figure cannot affect another.
  const shadow = paper.attachShadow({ mode: "open" });
  const show = () => shadow.replaceChildren(picture(svg));
  show();
  onThemeChange(show);
  return h(
    "figure",
    {},
    paper,
    h(
      "figcaption",
      {},
      h("span", {}, title),
      surfaces ? h("a", { href: surfaces }, "Turn its surfaces") : null,
      h("button", { type: "button", class: "plain", onclick: () => save(`${stem}.svg`, svgBlob(svg)) }, "Download SVG"),
      caption ? h("p", {}, caption) : null,
    ),
  );
}

function picture(text: string): Node {
  const { documentElement: svg } = new DOMParser().parseFromString(text, "image/svg+xml");
  if (svg.localName !== "svg") return document.createTextNode("This figure is not a readable SVG file.");
  const [width, height] = [svg.getAttribute("width"), svg.getAttribute("height")].map((size) => parseFloat(size ?? ""));
  if (!svg.hasAttribute("viewBox") && width && height) svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  for (const element of [svg, ...svg.querySelectorAll("*")]) {
    for (const name of ["fill", "stroke"]) {
      const color = element.getAttribute(name);
      if (color) element.setAttribute(name, themedColor(color));
    }
  }
  // The view box scales the figure to the width of its container.
  svg.removeAttribute("width");
  svg.removeAttribute("height");
  svg.setAttribute("style", "display: block; width: 100%; height: auto");
  return document.importNode(svg, true);
}
