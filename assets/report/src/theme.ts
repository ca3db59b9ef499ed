// Light or dark, and the color and dash of a solver.

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

/** Those of the figures (src/figure/style.rs), so that a solver has one color everywhere: Okabe and Ito, *Color
 * Universal Design*, 2008, with a darker yellow. */
const COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#000000", "#56b4e9", "#a89b00"];

/** Told apart without color: solid, dashed, dotted, and mixtures. */
const DASHES = ["", "8 3", "2 3", "9 3 2 3", "14 4", "5 2", "10 3 2 3 2 3", "1 4"];

/** What a figure drawn for paper has in the dark: its white, its inks, its grid. */
const IN_THE_DARK: Record<string, string> = {
  "#ffffff": SLATE.background,
  "#222222": SLATE.text,
  "#000000": SLATE.text,
  "#6e6e6e": SLATE.muted,
  "#e2e2e2": SLATE.grid,
};

/** A color of a figure as it is shown now. */
export function shownColor(color: string): string {
  return (preference.matches && IN_THE_DARK[color.toLowerCase()]) || color;
}

export function color(style: number, dark: boolean): string {
  const chosen = COLORS[style % COLORS.length] ?? "#777777";
  return dark && chosen === "#000000" ? "#e9e9e6" : chosen;
}

export function dash(style: number): string {
  // The second round of colors starts one dash later, so that no two of the first 56 styles are alike.
  return DASHES[(style + Math.floor(style / COLORS.length)) % DASHES.length] ?? "";
}
