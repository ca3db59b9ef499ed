// The head of the page: the question, where the numbers come from, and what to beware of.

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

/** The days from the first run to the last. */
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
      `Loaded machine: other work was running during ${loaded} of ${counted(runs.length, "run")}. Their seconds may be too long.`,
    );
  }
  const elsewhere = runs.filter((run) => !report.timed(run));
  if (elsewhere.length > 0) {
    const names = machines.filter((machine) => elsewhere.some((run) => run.machine === machine.id));
    const cpus = names.map((machine) => `${machine.id} (${machine.cpu})`).join(", ");
    found.push(
      `${counted(elsewhere.length, "run")} of another machine${cpus ? `, ${cpus},` : ""} ` +
        `${elsewhere.length === 1 ? "is" : "are"} left out of every time axis and of every time in the summary: ` +
        "seconds of different machines do not compare.",
    );
  }
  return found;
}
