// Section: the tables computed by the program.

import type { Report } from "../data";
import { h } from "../dom";
import { table } from "../widgets/table";

export function tables(report: Report): Node {
  return h(
    "div",
    {},
    ...report.data.tables.map(({ title, columns, rows }) =>
      h("section", { class: "sub" }, h("h3", {}, title), table({ label: title, columns, rows })),
    ),
  );
}
