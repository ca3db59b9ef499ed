// The header of the page: the question, the origin of the numbers, and warnings.

import type { Report, Run } from "../data";
import { h } from "../dom";
import { counted, date, day, MISSING, significant } from "../format";

export function header(report: Report): HTMLElement {
  const { data } = report;
  const facts: [string, string][] = [
    ["Program", data.program],
    ["Runs", data.runs.length.toLocaleString("en-US")],
    ["Made", madeBetween(data.runs)],
    ["Page written", date(data.written)],
    ...data.machines.map((machine): [string, string] => [
      data.machines.length === 1 ? "Machine" : `Machine ${machine.id}`,
      `${machine.cpu}, ${counted(machine.cores, "core")}, ${significant(machine.memory_gib, 3)} GiB`,
    ]),
  ];
  return h(
    "header",
    {},
    h("p", { class: "name" }, data.name),
    h("h1", {}, data.question || data.name),
    h("dl", { class: "origin" }, ...facts.map(([term, text]) => h("div", {}, h("dt", {}, term), h("dd", {}, text)))),
    ...notices(report).map((text) => h("p", { class: "notice", role: "note" }, text)),
  );
}

/** The dates of the first and the last run. */
function madeBetween(runs: Run[]): string {
  const starts = runs.flatMap(({ manifest: { start } }) => (typeof start === "string" ? start : [])).sort();
  const [first, last] = [starts[0], starts[starts.length - 1]].map((start) => (start ? day(start) : null));
  if (!first || !last) return MISSING;
  return first === last ? first : `${first} to ${last}`;
}

function notices(report: Report): string[] {
  const { runs, machines } = report.data;
  const found: string[] = [];
  const loaded = runs.filter((run) => run.loaded).length;
  if (loaded > 0) {
    found.push(
      `Loaded machine: other work was running during ${loaded} of ${counted(runs.length, "run")}. The times of these runs may be too long.`,
    );
  }
  const elsewhere = runs.filter((run) => !report.hasComparableTime(run));
  if (elsewhere.length > 0) {
    const names = machines.filter((machine) => elsewhere.some((run) => run.machine === machine.id));
    const cpus = names.map((machine) => `${machine.id} (${machine.cpu})`).join(", ");
    found.push(
      `${counted(elsewhere.length, "run")} on another machine${cpus ? `, ${cpus},` : ""} ` +
        `${elsewhere.length === 1 ? "is" : "are"} left out of every time axis and of the times in the summary: ` +
        "times from different machines are not comparable.",
    );
  }
  return found;
}
