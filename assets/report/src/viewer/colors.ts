// A color for every vertex, for each mode of the viewer.

import type { Answer, Surface } from "./surface";

export type Rgb = [number, number, number];

/** From certain to undecided. */
const RAMP: Rgb[] = [
  [236, 236, 232],
  [246, 214, 140],
  [236, 155, 62],
  [197, 82, 34],
  [104, 24, 32],
];
const SAME_COLOR: Rgb = [222, 222, 218];
const DIFFERENT_COLOR: Rgb = [208, 30, 36];

export function css([r, g, b]: Rgb): string {
  return `rgb(${r} ${g} ${b})`;
}

export function regionColor(surface: Surface, region: number): Rgb {
  const color = surface.palette[region] ?? [0.5, 0.5, 0.5];
  return color.map((value) => Math.round(255 * value)) as Rgb;
}

/** Color of an uncertainty in [0, 1]. */
export function rampColor(t: number): Rgb {
  const position = Math.min(1, Math.max(0, t)) * (RAMP.length - 1);
  const before = Math.min(RAMP.length - 2, Math.floor(position));
  const [a, b] = [RAMP[before], RAMP[before + 1]] as [Rgb, Rgb];
  return a.map((value, i) => Math.round(value + (position - before) * ((b[i] ?? 0) - value))) as Rgb;
}

function fill(count: number, colorOf: (vertex: number) => Rgb): Uint8Array {
  const colors = new Uint8Array(3 * count);
  for (let v = 0; v < count; v++) colors.set(colorOf(v), 3 * v);
  return colors;
}

export function labelColors(surface: Surface, { labels }: Answer): Uint8Array {
  const regions = surface.palette.map((_, region) => regionColor(surface, region));
  return fill(surface.vertices, (v) => regions[labels[v] ?? 0] ?? SAME_COLOR);
}

/** The largest possible uncertainty, that of the uniform row. */
export function maxUncertainty(surface: Surface): number {
  return 1 - 1 / Math.max(2, surface.palette.length);
}

export function uncertaintyColors(surface: Surface, { certainty }: Answer): Uint8Array {
  const max = maxUncertainty(surface);
  const ramp = Array.from({ length: 256 }, (_, value) => rampColor((1 - value / 255) / max));
  return fill(surface.vertices, (v) => ramp[certainty[v] ?? 255] ?? SAME_COLOR);
}

/** 1 where two answers differ, else 0. */
export function differences(a: Answer, b: Answer): Uint8Array {
  return a.labels.map((label, v) => (label === b.labels[v] ? 0 : 1));
}

export function differenceColors(surface: Surface, differs: Uint8Array): Uint8Array {
  return fill(surface.vertices, (v) => (differs[v] ? DIFFERENT_COLOR : SAME_COLOR));
}

export { DIFFERENT_COLOR, SAME_COLOR };
