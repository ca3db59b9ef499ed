// Section: all runs, each with its manifest.

import type { Cell, Report, Run } from "../data";
import { h } from "../dom";
import { gap, MISSING, significant } from "../format";
import { statusMeanings } from "../statuses";
import { table, type Column } from "../widgets/table";

export function runs(report: Report): Node {
  const { runs, machines } = report.data;
  const several = machines.length > 1;
  const loaded = runs.some((run) => run.loaded);
  const columns: Column[] = [
    { label: "run", numeric: false },
    { label: "instance", numeric: false },
    { label: "solver", numeric: false },
    { label: "rep.", numeric: true },
    { label: "status", numeric: false },
    { label: "iterations", numeric: true },
    { label: "seconds", numeric: true, format: (cell) => significant(Number(cell), 3) },
    { label: "relative gap", numeric: true, format: (cell) => gap(Number(cell)) },
    ...(several ? [{ label: "machine", numeric: false }] : []),
    ...(loaded ? [{ label: "load", numeric: false }] : []),
  ];
  const rows = runs.map((run): Cell[] => [
    run.id,
    report.instanceLabel(run.instance),
    report.solverLabel(run.solver),
    run.repetition + 1,
    run.status,
    run.iterations,
    run.seconds,
    run.relative_gap,
    ...(several ? [run.machine] : []),
    ...(loaded ? [run.loaded ? "loaded" : "quiet"] : []),
  ]);
  return h(
    "div",
    {},
    table({ label: "Runs", columns, rows, detail: (row) => manifest(runs[row] as Run) }),
    h("p", { class: "hint" }, "Click a row to open the manifest of its run, with the reason why it ended."),
    ...statusMeanings(report).map((text) => h("p", { class: "hint" }, text)),
  );
}

function manifest(run: Run): Node {
  const { energy, dual_bound } = run;
  // The manifest may contain these keys too.
  const entries = Object.entries({ energy, dual_bound, ...run.manifest, repetition: run.repetition + 1 });
  const text = (value: unknown) => {
    if (value === null || value === undefined) return MISSING;
    if (typeof value === "number" && value !== 0 && Math.abs(value) < 1e-3) return value.toExponential();
    return typeof value === "object" ? JSON.stringify(value) : String(value);
  };
  return h("dl", { class: "manifest" }, ...entries.map(([key, value]) => h("div", {}, h("dt", {}, key), h("dd", {}, text(value)))));
}
