// What the ends of runs mean, where they are shown.

import type { Report } from "./data";

const MEANINGS: Record<string, string> = {
  converged: "its certified gap is within the tolerance.",
  "iteration-limit": "it made all iterations that it was allowed; what it reached is certified.",
  "time-limit": "its time was over; what it reached is certified.",
  stalled: "its labels hardly changed any more, which certifies nothing.",
  diverged: "it met a number that is none (NaN) or infinite, and was ended; what it reached before counts.",
  failed:
    "the command of a solver outside the program broke off, was not there, or left nothing that could be read. " +
    "It counts as never reaching any gap. The reason is its “exit”.",
  ended: "it ended by itself before any limit, without its certified gap being within the tolerance.",
};

/** A sentence for each way in which a run ended without converging. */
export function meanings(report: Report): string[] {
  const statuses = new Set(report.data.runs.map((run) => run.status));
  return Object.entries(MEANINGS)
    .filter(([status]) => status !== "converged" && statuses.has(status))
    .map(([status, meaning]) => `“${status}”: ${meaning}`);
}
