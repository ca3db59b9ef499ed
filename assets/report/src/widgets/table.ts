// A table with sorting, filtering, copying as CSV and rows that open.

import type { Cell } from "../data";
import { h } from "../dom";
import { copy, csv } from "../download";
import { MISSING, significant } from "../format";

export interface Column {
  label: string;
  numeric: boolean;
  format?: (cell: Cell) => string;
}

export interface TableOptions {
  label: string;
  columns: Column[];
  rows: Cell[][];
  /** The content that a row opens, by its index in `rows`. */
  detail?: (row: number) => Node;
}

/** The number of rows shown initially; the others are shown on request. */
const PAGE_ROWS = 100;

/** Longer texts may wrap if there is no room for them. */
const LONG_TEXT_LENGTH = 26;

/** Tables with at most this many rows have no filter. */
const UNFILTERED_ROWS = 12;

function rank(cell: Cell): number {
  if (cell === null || (typeof cell === "number" && Number.isNaN(cell))) return 2;
  return typeof cell === "number" ? 0 : 1;
}

/** Numbers first, then texts, then missing cells; the direction applies only within each kind. */
export function compare(a: Cell, b: Cell, direction: 1 | -1): number {
  const kinds = rank(a) - rank(b);
  if (kinds !== 0) return kinds;
  if (typeof a === "number" && typeof b === "number") return direction * (a - b);
  return direction * String(a ?? "").localeCompare(String(b ?? ""), "en", { numeric: true });
}

function text(cell: Cell, column: Column): string {
  if (cell === null) return MISSING;
  if (column.format) return column.format(cell);
  return typeof cell === "number" ? significant(cell) : cell;
}

export function table(options: TableOptions): HTMLElement {
  const { columns, rows, detail } = options;
  let sorted: { column: number; direction: 1 | -1 } | null = null;
  let search = "";
  let limit = PAGE_ROWS;
  let order: number[] = [];
  const opened = new Set<number>();

  const body = h("tbody");
  const heads = columns.map((column, index) =>
    h(
      "th",
      { scope: "col", class: column.numeric ? "number" : null },
      h("button", { type: "button", onclick: () => sortBy(index) }, h("span", {}, column.label)),
    ),
  );
  const more = h("button", { type: "button", class: "plain", onclick: () => { limit = Infinity; draw(); } });
  const copier = h("button", { type: "button", class: "plain", onclick: () => void copyRows() }, "Copy as CSV");
  const filter = h("input", {
    type: "search",
    placeholder: "Filter rows",
    "aria-label": `Filter rows of ${options.label}`,
    oninput: () => { search = filter.value.toLowerCase(); draw(); },
  });

  function sortBy(column: number): void {
    if (sorted?.column !== column) sorted = { column, direction: 1 };
    else sorted = sorted.direction === 1 ? { column, direction: -1 } : null;
    heads.forEach((head, index) => {
      if (sorted?.column !== index) head.removeAttribute("aria-sort");
      else head.setAttribute("aria-sort", sorted.direction === 1 ? "ascending" : "descending");
    });
    draw();
  }

  async function copyRows(): Promise<void> {
    const done = await copy(csv([columns.map((column) => column.label), ...order.map((row) => rows[row] ?? [])]));
    copier.textContent = done ? "Copied" : "Copying failed";
    setTimeout(() => { copier.textContent = "Copy as CSV"; }, 1600);
  }

  function line(row: number): HTMLElement[] {
    const cells = columns.map((column, index) => {
      const cell = rows[row]?.[index] ?? null;
      const shown = text(cell, column);
      const first = index === 0 && detail;
      const content = first
        ? h("button", { type: "button", class: "opener", "aria-expanded": String(opened.has(row)) }, shown)
        : shown;
      const kind = column.numeric ? "number" : shown.length > LONG_TEXT_LENGTH ? "long" : null;
      return h("td", { class: kind, title: cell === null ? "no value" : null }, content);
    });
    if (!detail) return [h("tr", {}, ...cells)];
    const toggle = () => {
      if (!opened.delete(row)) opened.add(row);
      const next = line(row);
      const focus = main.contains(document.activeElement);
      if (!opened.has(row)) main.nextElementSibling?.remove();
      main.replaceWith(...next);
      if (focus) next[0]?.querySelector("button")?.focus();
    };
    const main = h("tr", { class: "opens", onclick: toggle }, ...cells);
    if (!opened.has(row)) return [main];
    return [main, h("tr", { class: "detail" }, h("td", { colspan: columns.length }, detail(row)))];
  }

  function draw(): void {
    order = rows.map((_, index) => index);
    if (search) {
      order = order.filter((row) =>
        columns.some((column, index) => text(rows[row]?.[index] ?? null, column).toLowerCase().includes(search)),
      );
    }
    if (sorted) {
      const { column, direction } = sorted;
      order.sort((a, b) => compare(rows[a]?.[column] ?? null, rows[b]?.[column] ?? null, direction));
    }
    body.replaceChildren(...order.slice(0, limit).flatMap(line));
    if (order.length === 0) body.append(h("tr", {}, h("td", { class: "nothing", colspan: columns.length }, "no rows")));
    more.hidden = order.length <= limit;
    more.textContent = `Show all ${order.length} rows`;
  }

  draw();
  return h(
    "div",
    { class: "table" },
    h("div", { class: "table-tools" }, rows.length > UNFILTERED_ROWS ? filter : null, copier),
    h(
      "div",
      { class: "table-scroll", tabindex: "0", role: "region", "aria-label": options.label },
      h("table", {}, h("thead", {}, h("tr", {}, ...heads)), body),
    ),
    more,
  );
}
