// A table that sorts, filters, copies itself as CSV and can open a row.

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
  /** What a row opens to; given its place in `rows`. */
  detail?: (row: number) => Node;
}

/** Rows drawn at once; the rest on request, since few ever look at them. */
const PAGE = 100;

/** Texts of more letters than this may wrap where there is no room for them. */
const LONG = 26;

/** More rows than this are worth a filter. */
const FEW = 12;

function rank(cell: Cell): number {
  if (cell === null || (typeof cell === "number" && Number.isNaN(cell))) return 2;
  return typeof cell === "number" ? 0 : 1;
}

/** Numbers, then texts, then nothing; only within a kind does the direction count. */
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
  let limit = PAGE;
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
    copier.textContent = done ? "Copied" : "This browser refused";
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
      const kind = column.numeric ? "number" : shown.length > LONG ? "long" : null;
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
    h("div", { class: "table-tools" }, rows.length > FEW ? filter : null, copier),
    h(
      "div",
      { class: "table-scroll", tabindex: "0", role: "region", "aria-label": options.label },
      h("table", {}, h("thead", {}, h("tr", {}, ...heads)), body),
    ),
    more,
  );
}
