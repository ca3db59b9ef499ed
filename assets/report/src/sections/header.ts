// The head of the page: the question, where the numbers come from, and what to beware of.

import type { Report } from "../data";
import { h } from "../dom";
import { counted, date, significant } from "../format";

export function header(report: Report): HTMLElement {
  const { data } = report;
  const facts: [string, string][] = [
    ["Program", data.program],
    ["Runs", data.runs.length.toLocaleString("en-US")],
    ["Written", date(data.written)],
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
