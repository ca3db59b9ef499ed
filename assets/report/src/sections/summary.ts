// Section: a summary of the runs, computed from their traces only.

import type { Cell, Instance, Report } from "../data";
import { h } from "../dom";
import { counted, gap, seconds, significant } from "../format";
import { median, ranking, tally, targets, tightest } from "../statistics";
import { statusMeanings } from "../statuses";
import { table } from "../widgets/table";

/** The result for one instance at one target. */
interface Verdict {
  instance: Instance;
  target: number | null;
  fastest: string | null;
  row: Cell[];
}

export function summary(report: Report): Node {
  const { instances } = report.data;
  const decades = targets(report);
  const container = h("div");
  const cards = h("div", { class: "cards" });

  const select = h(
    "select",
    { id: "target", onchange: () => show(select.value === "tightest" ? null : Number(select.value)) },
    h("option", { value: "tightest" }, "the tightest that two solvers reach"),
    ...decades.map((target) => h("option", { value: target }, target.toExponential())),
  );

  function show(target: number | null): void {
    const verdicts = instances.map((instance) => verdict(report, instance, target ?? tightest(report, instance, decades)));
    cards.replaceChildren(...cardsOf(report, verdicts, target));
    container.replaceChildren(
      table({
        label: "Fastest solver on each instance",
        columns: [
          { label: "instance", numeric: false },
          { label: "gap", numeric: true, format: (cell) => (typeof cell === "number" ? cell.toExponential() : "") },
          { label: "fastest", numeric: false },
          { label: "seconds", numeric: true, format: (cell) => significant(Number(cell), 3) },
          { label: "next", numeric: false },
          { label: "takes", numeric: true, format: (cell) => `${significant(Number(cell), 3)} ×` },
          { label: "fewest iterations", numeric: false },
          { label: "iterations", numeric: true },
        ],
        rows: verdicts.map(({ row }) => row),
      }),
    );
  }

  show(null);
  return h(
    "div",
    {},
    cards,
    ...statusMeanings(report).map((text) => h("p", { class: "hint" }, text)),
    // Surfaces that evolve have no gap at all.
    decades.length === 0
      ? report.data.runs.some((run) => run.relative_gap !== null)
        ? h("p", { class: "empty" }, "No run certified a relative gap of 1e-1 or less.")
        : null
      : h(
          "div",
          {},
          h("div", { class: "field" }, h("label", { class: "field-label", for: "target" }, "Time to a certified relative gap of"), select),
          container,
          h(
            "p",
            { class: "hint" },
            "Seconds and iterations at the first sample whose certified relative gap is at most the target: median over " +
              "the repetitions, of which at least half must reach it. “takes” is the time of the next solver relative to that of the fastest.",
          ),
        ),
  );
}

function verdict(report: Report, instance: Instance, target: number | null): Verdict {
  if (target === null) return { instance, target, fastest: null, row: [instance.label, ...Array<null>(7).fill(null)] };
  const [first, second] = ranking(report, instance, target, "seconds");
  const [fewest] = ranking(report, instance, target, "iteration");
  const label = (ranked: { solver: string } | undefined) => (ranked ? report.solverLabel(ranked.solver) : null);
  const factor = first && second && first.value > 0 ? second.value / first.value : null;
  return {
    instance,
    target,
    fastest: first?.solver ?? null,
    row: [
      instance.label, target, label(first), first?.value ?? null, label(second), factor, label(fewest), fewest?.value ?? null,
    ],
  };
}

function card(head: string, text: string): HTMLElement {
  return h("div", { class: "card" }, h("strong", {}, head), h("p", {}, text));
}

function cardsOf(report: Report, verdicts: Verdict[], target: number | null): HTMLElement[] {
  const { runs, instances, solvers } = report.data;
  const cards = [
    card(counted(runs.length, "run"), `${counted(instances.length, "instance")}, ${counted(solvers.length, "solver")}`),
  ];

  const statuses = tally(runs.map((run) => run.status));
  const converged = statuses.find(([status]) => status === "converged")?.[1] ?? 0;
  const others = statuses.filter(([status]) => status !== "converged").map(([status, count]) => `${count} ${status}`);
  const surfaces = runs.every((run) => run.relative_gap === null && run.dual_bound === null);
  if (surfaces) cards.push(card("surfaces without a bound", statuses.map(([status, count]) => `${count} ${status}`).join(", ")));
  else cards.push(card(`${converged} of ${runs.length} converged`, others.length > 0 ? `the others: ${others.join(", ")}` : "every run reached its tolerance"));

  const compared = verdicts.filter(({ row }) => row[4] !== null);
  const winners = tally(compared.flatMap(({ fastest }) => fastest ?? []));
  const [winner] = winners;
  if (winner) {
    const goal = target === null ? "the tightest gap that two solvers reach" : `a certified gap of ${target.toExponential()}`;
    const rest = winners.slice(1).map(([id, count]) => `${report.solverLabel(id)} on ${count}`);
    cards.push(
      card(
        `${report.solverLabel(winner[0])} fastest on ${winner[1]} of ${compared.length}`,
        `instances, to ${goal}${rest.length > 0 ? `; ${rest.join(", ")}` : ""}`,
      ),
    );
  }

  const certified = runs.filter((run) => run.relative_gap !== null);
  const best = certified.reduce<(typeof runs)[number] | null>(
    (smallest, run) => (smallest === null || Number(run.relative_gap) < Number(smallest.relative_gap) ? run : smallest),
    null,
  );
  if (best) {
    const middle = median(certified.map((run) => run.relative_gap));
    cards.push(
      card(
        `tightest gap ${gap(best.relative_gap)}`,
        `certified by ${report.solverLabel(best.solver)} after ${counted(best.iterations ?? 0, "iteration")} in ${seconds(best.seconds)}; ` +
          `median of all runs ${gap(middle)}`,
      ),
    );
  }
  return cards;
}
