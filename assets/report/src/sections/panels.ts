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

/** Surfaces of a film side by side. */
const MOST_ACROSS = 4;

/** Milliseconds for each frame of a film. */
const FRAME_TIME = 500;

function shapeOf({ positions, faces, view }: FigureSurface): Shape {
  const numbers = (text: string) => new Uint16Array(bytes(text).buffer);
  return { positions: Float32Array.from(numbers(positions), (x) => (2 * x) / STEPS - 1), faces: Uint32Array.from(numbers(faces)), view };
}

export function panels(figure: SurfaceFigure): Node[] {
  const { title, program, columns, column_headings, row_headings, surfaces } = figure;
  const film = figure.film ?? false;
  const message = h("p", { class: "empty", hidden: true });
  const fail = (text: string) => {
    message.textContent = text;
    message.hidden = false;
  };
  const target = document.createElement("canvas");
  const renderer = rendererInto(target, () => fail("The browser closed the 3-D view (its graphics context was lost). Reload the page to restore it."));
  if (!renderer) fail("This browser has no WebGL, so the surfaces cannot be shown in 3-D. The figure is also a PNG file.");

  const rows = !film && row_headings.length > 0;
  const across = film ? Math.min(MOST_ACROSS, figure.panels.length / columns) : columns;
  const grid = h("div", {
    class: "panels",
    tabindex: "0",
    role: "group",
    "aria-label": "3-D views: arrow keys rotate them, plus and minus zoom",
    style: `grid-template-columns: ${rows ? "auto " : ""}repeat(${across}, minmax(0, 1fr))`,
  });
  const request = onceInFrame(() => draw());
  const view = eye(grid, request);

  const shapes = surfaces.map((surface) => surface && { ...shapeOf(surface), placed: film });
  const bodies = figure.panels.map<Solid | null>(() => null);
  let towards: Vector3 | null = null;
  /** The surface of a panel, which is made when it is first needed. */
  const bodyOf = (i: number): Solid | null => {
    const panel = figure.panels[i];
    const shape = panel && panel.surface !== null ? shapes[panel.surface] : null;
    if (!panel || !shape) return null;
    const known = bodies[i];
    if (known) return known;
    const body = solid();
    const direction = body.show(shape);
    towards ??= direction;
    paint(body, panel);
    body.object.visible = false;
    view.scene.add(body.object);
    bodies[i] = body;
    return body;
  };
  /** The canvases, each with the panels that it shows: in a film those of a row, one at a time. */
  const shown: { canvas: HTMLCanvasElement; panels: number[] }[] = [];
  const cell = (panel: PanelData, indices: number[], name: (string | undefined)[], caption: string): HTMLElement => {
    const canvas = h("canvas", { role: "img", "aria-label": name.filter(Boolean).join(", ") || `panel ${shown.length + 1}` });
    if (bodyOf(indices[0] ?? -1)) shown.push({ canvas, panels: indices });
    return h("figure", {}, canvas, panel.bar && bar(panel.bar), caption ? h("figcaption", {}, caption) : null);
  };

  const index = (row: number) => Array.from({ length: columns }, (_, column) => row * columns + column);
  if (film) {
    for (let row = 0; row * columns < figure.panels.length; row++) {
      const first = figure.panels[row * columns];
      const heading = row_headings[row] ?? "";
      if (first) grid.append(cell(first, index(row), [heading], heading));
    }
  } else {
    if (column_headings.length > 0) {
      if (rows) grid.append(h("span"));
      grid.append(...column_headings.map((text) => h("span", { class: "heading" }, text)));
    }
    figure.panels.forEach((panel, i) => {
      if (rows && i % columns === 0) grid.append(h("span", { class: "heading row" }, row_headings[i / columns] ?? ""));
      const name = [row_headings[Math.floor(i / columns)], column_headings[i % columns], panel.caption];
      grid.append(cell(panel, [i], name, panel.caption));
    });
  }
  if (towards) view.place(towards);

  let frame = 0;
  const time = film ? slider(column_headings, (to) => {
    frame = to;
    request();
  }) : null;

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
    for (const { canvas, panels } of shown) {
      const body = bodyOf(panels[Math.min(frame, panels.length - 1)] ?? -1);
      if (!body) continue;
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
      time,
      grid,
      h("div", { class: "actions" }, h("button", { type: "button", onclick: () => view.reset() }, "Reset view")),
      h("p", { class: "hint" }, "Drag to rotate all surfaces, right-drag to pan; click one, then scroll to zoom, or use the arrow keys, plus and minus."),
      coarse.length > 0 ? h("p", { class: "hint" }, `Coarsened for this page: ${coarse.join("; ")} are shown.`) : null,
    ),
  ];
}

/** A slider over the frames of a film, which can also be played. */
function slider(names: string[], show: (frame: number) => void): HTMLElement {
  const name = h("output", {}, names[0] ?? "");
  const range = h("input", { type: "range", min: 0, max: names.length - 1, step: 1, value: 0, "aria-label": "frame", oninput: () => to(Number(range.value)) });
  let timer = 0;
  const play = h("button", { type: "button", onclick: () => (timer === 0 ? start() : stop()) }, "Play");
  function to(frame: number): void {
    range.value = String(frame);
    range.setAttribute("aria-valuetext", names[frame] ?? "");
    name.textContent = names[frame] ?? "";
    show(frame);
  }
  function stop(): void {
    window.clearInterval(timer);
    timer = 0;
    play.textContent = "Play";
  }
  function start(): void {
    play.textContent = "Stop";
    if (Number(range.value) === names.length - 1) to(0);
    timer = window.setInterval(() => {
      const next = Number(range.value) + 1;
      if (next >= names.length) return stop();
      to(next);
    }, FRAME_TIME);
  }
  return h("div", { class: "film" }, play, range, name);
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
