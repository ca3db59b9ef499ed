// A figure of surfaces: a grid of panels whose surfaces are turned together.

import { Vector3 } from "three";
import type { BarData, FigureSurface, PanelData, SurfaceFigure } from "../data";
import { h } from "../dom";
import { counted, significant } from "../format";
import { css } from "../viewer/colors";
import { eye } from "../viewer/eye";
import { solid, type Shape, type Solid } from "../viewer/solid";
import { onceInFrame, rendererInto } from "../viewer/stage";
import { bytes } from "../viewer/surface";

const STEPS = 65535;

function shapeOf({ positions, faces, view }: FigureSurface): Shape {
  const numbers = (text: string) => new Uint16Array(bytes(text).buffer);
  return { positions: Float32Array.from(numbers(positions), (x) => (2 * x) / STEPS - 1), faces: Uint32Array.from(numbers(faces)), view };
}

export function panels(figure: SurfaceFigure): Node[] {
  const { title, program, columns, column_headings, row_headings, surfaces } = figure;
  const message = h("p", { class: "empty", hidden: true });
  const fail = (text: string) => {
    message.textContent = text;
    message.hidden = false;
  };
  const target = document.createElement("canvas");
  const renderer = rendererInto(target, () => fail("The browser closed the 3-D view (its graphics context was lost). Reload the page to restore it."));
  if (!renderer) fail("This browser has no WebGL, so the surfaces cannot be shown in 3-D. The figure is also a PNG file.");

  const rows = row_headings.length > 0;
  const grid = h("div", {
    class: "panels",
    tabindex: "0",
    role: "group",
    "aria-label": "3-D views: arrow keys rotate them, plus and minus zoom",
    style: `grid-template-columns: ${rows ? "auto " : ""}repeat(${columns}, minmax(0, 1fr))`,
  });
  const request = onceInFrame(() => draw());
  const view = eye(grid, request);

  const shapes = surfaces.map((surface) => surface && shapeOf(surface));
  const shown: { canvas: HTMLCanvasElement; body: Solid }[] = [];
  let towards: Vector3 | null = null;
  const cell = (panel: PanelData, i: number): HTMLElement => {
    const heading = [row_headings[Math.floor(i / columns)], column_headings[i % columns], panel.caption];
    const canvas = h("canvas", { role: "img", "aria-label": heading.filter(Boolean).join(", ") || `panel ${i + 1}` });
    const shape = panel.surface === null ? null : shapes[panel.surface];
    if (shape) {
      const body = solid();
      const direction = body.show(shape);
      towards ??= direction;
      paint(body, panel);
      view.scene.add(body.object);
      shown.push({ canvas, body });
    }
    return h("figure", {}, canvas, panel.bar && bar(panel.bar), panel.caption ? h("figcaption", {}, panel.caption) : null);
  };

  if (column_headings.length > 0) {
    if (rows) grid.append(h("span"));
    grid.append(...column_headings.map((text) => h("span", { class: "heading" }, text)));
  }
  figure.panels.forEach((panel, i) => {
    if (rows && i % columns === 0) grid.append(h("span", { class: "heading row" }, row_headings[i / columns] ?? ""));
    grid.append(cell(panel, i));
  });
  if (towards) view.place(towards);

  /** Draws all panels, which have the same size, one after the other. */
  function draw(): void {
    const first = shown[0]?.canvas;
    if (!renderer || !first) return;
    const ratio = Math.min(2, window.devicePixelRatio);
    const [width, height] = [first.clientWidth, first.clientHeight];
    if (width === 0 || height === 0) return;
    renderer.setPixelRatio(ratio);
    renderer.setSize(width, height, false);
    view.resize(width, height, grid.clientHeight);
    for (const { body } of shown) body.object.visible = false;
    for (const { canvas, body } of shown) {
      body.object.visible = true;
      renderer.render(view.scene, view.camera);
      body.object.visible = false;
      [canvas.width, canvas.height] = [target.width, target.height];
      canvas.getContext("2d")?.drawImage(target, 0, 0);
    }
  }
  new ResizeObserver(request).observe(grid);

  const coarse = surfaces.flatMap((surface, i) => {
    const left = (shapes[i]?.positions.length ?? 0) / 3;
    return surface && left < surface.vertices ? [`${left.toLocaleString("en-US")} of ${counted(surface.vertices, "vertex", "vertices")}`] : [];
  });
  return [
    h("header", {}, h("p", { class: "name" }, program), h("h1", {}, title)),
    h(
      "section",
      { "aria-label": "Surfaces" },
      message,
      grid,
      h("div", { class: "actions" }, h("button", { type: "button", onclick: () => view.reset() }, "Reset view")),
      h("p", { class: "hint" }, "Drag to rotate all surfaces, right-drag to pan; click one, then scroll to zoom, or use the arrow keys, plus and minus."),
      coarse.length > 0 ? h("p", { class: "hint" }, `Coarsened for this page: ${coarse.join("; ")} are shown.`) : null,
    ),
  ];
}

function paint(body: Solid, { colors, labels, sharp, cut }: PanelData): void {
  const classes = labels === null ? null : bytes(labels);
  body.paint(bytes(colors), sharp ? classes : null);
  if (classes && cut) body.outline(classes, cut);
}

function bar({ colors, range, label }: BarData): Node {
  if (!range) {
    return h("ul", { class: "key regions" }, ...colors.map((color, p) => h("li", {}, h("i", { style: `background: ${css(color)}` }), String(p))));
  }
  return h(
    "div",
    { class: "bar" },
    h("div", { class: "ramp", style: `background: linear-gradient(to right, ${colors.map(css).join(", ")})` }),
    h("div", { class: "ramp-ends" }, h("span", {}, significant(range[0], 3)), h("span", {}, label ?? ""), h("span", {}, significant(range[1], 3))),
  );
}
