// Explanations of the statuses of runs.

import type { Report } from "./data";

const STATUS_MEANINGS: Record<string, string> = {
  converged: "its certified gap is within the tolerance.",
  "iteration-limit": "it reached the iteration limit; the gap that it reached is certified.",
  "time-limit": "it reached the time limit; the gap that it reached is certified.",
  stalled: "its labels hardly changed anymore, which certifies nothing.",
  settled: "no further step changes its labels, whose gap is certified, or lowers the energy of its surface.",
  "step-limit": "its surface still moved when it reached its number of steps.",
  diverged: "it produced NaN or infinity and was stopped; its earlier samples count.",
  failed:
    "the command of an external solver failed, was not found, or wrote no readable output. " +
    "It counts as never reaching any gap. “exit” in its manifest gives the reason.",
  ended: "it stopped by itself before any limit, without a certified gap within the tolerance.",
};

/** A sentence for each status of a run that did not converge. */
export function statusMeanings(report: Report): string[] {
  const statuses = new Set(report.data.runs.map((run) => run.status));
  return Object.entries(STATUS_MEANINGS)
    .filter(([status]) => status !== "converged" && statuses.has(status))
    .map(([status, meaning]) => `“${status}”: ${meaning}`);
}
