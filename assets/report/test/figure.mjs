// A figure of surfaces with artificial data: two instances with data, regions and a column of U, and an empty panel.

import { fixture } from "./fixture.mjs";

export function figure() {
  const { g0: scene } = fixture().scenes;
  const bytes = (text) => new Uint8Array(Buffer.from(text, "base64"));
  const base64 = (array) => Buffer.from(array.buffer).toString("base64");
  const positions = new Float32Array(bytes(scene.positions).buffer);
  const reach = Math.hypot(1.4, 0.4);
  const surface = (scale, towards) => ({
    positions: base64(Uint16Array.from(positions, (x, i) => Math.round(32767.5 * ((x * scale[i % 3]) / reach + 1)))),
    faces: base64(Uint16Array.from(new Uint32Array(bytes(scene.faces).buffer))),
    vertices: positions.length / 3,
    view: { towards, up: [0, 0, 1] },
  });
  const { labels } = scene.solutions.s0;
  const certainty = bytes(scene.solutions.s0.certainty);
  const palette = scene.palette.map((color) => color.map((c) => Math.round(255 * c)));
  const colors = (of) => base64(Uint8Array.from([...bytes(labels)].flatMap((label, v) => of(label, v))));
  const row = (surface) => [
    { surface, colors: scene.data, labels: null, sharp: false, cut: null, caption: "", bar: null },
    { surface, colors: scene.data, labels, sharp: false, cut: [230, 0, 0], caption: "", bar: null },
    { surface, colors: colors((label) => palette[label]), labels, sharp: true, cut: [23, 23, 28], caption: "", bar: { colors: palette } },
    {
      surface,
      colors: colors((_, v) => [certainty[v], 255 - certainty[v], 120]),
      labels: null, sharp: false, cut: null, caption: "",
      bar: { colors: [[0, 255, 120], [255, 0, 120]], range: [0, 0.75], label: "1 − max u" },
    },
  ];
  const panels = [...row(0), ...row(1)];
  panels[7] = { surface: null, caption: "", bar: null };
  return {
    title: "Where are the regions of a torus?",
    program: "meshseg 0.1.0",
    columns: 4,
    column_headings: ["data", "data and cut", "regions", "uncertainty"],
    row_headings: ["a torus", "a flat torus"],
    surfaces: [surface([1, 1, 1], [0.4, -1, 0.9]), surface([1, 0.6, 0.5], [1, 0.4, 0.7])],
    panels: panels.map((panel, i) => ({ ...panel, caption: `(${"abcdefgh"[i]}) panel` })),
  };
}
