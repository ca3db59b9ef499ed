// The light and dark themes, and the color and dash pattern of each solver.

const preference = window.matchMedia("(prefers-color-scheme: dark)");

export interface Ink {
  text: string;
  muted: string;
  grid: string;
  background: string;
  dark: boolean;
}

export const PAPER: Ink = { text: "#1d1f22", muted: "#5f646b", grid: "#e6e6e2", background: "#ffffff", dark: false };
const SLATE: Ink = { text: "#e9e9e6", muted: "#a3a8af", grid: "#2e3136", background: "#1a1c1f", dark: true };

export function ink(): Ink {
  return preference.matches ? SLATE : PAPER;
}

export function onThemeChange(listener: () => void): void {
  preference.addEventListener("change", listener);
}

/** The colors of the figures (src/figure/style.rs), so that a solver has the same color everywhere: Okabe and Ito,
 * *Color Universal Design*, 2008, with a darker yellow. */
const COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#000000", "#56b4e9", "#a89b00"];

/** Distinguishable without color: solid, dashed, dotted, and mixtures. */
const DASHES = ["", "8 3", "2 3", "9 3 2 3", "14 4", "5 2", "10 3 2 3 2 3", "1 4"];

/** Replacements in the dark theme for the background, text and grid colors of a figure. */
const DARK_COLORS: Record<string, string> = {
  "#ffffff": SLATE.background,
  "#222222": SLATE.text,
  "#000000": SLATE.text,
  "#6e6e6e": SLATE.muted,
  "#e2e2e2": SLATE.grid,
};

/** A color of a figure in the current theme. */
export function themedColor(color: string): string {
  return (preference.matches && DARK_COLORS[color.toLowerCase()]) || color;
}

export function color(style: number, dark: boolean): string {
  const chosen = COLORS[style % COLORS.length] ?? "#777777";
  return dark && chosen === "#000000" ? "#e9e9e6" : chosen;
}

export function dash(style: number): string {
  // Each round of colors starts one dash later, so that the first 56 styles are distinct.
  return DASHES[(style + Math.floor(style / COLORS.length)) % DASHES.length] ?? "";
}
