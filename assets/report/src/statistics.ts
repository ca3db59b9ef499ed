// The statistics of the summary: when a certified gap was reached, and which solver reached it first.

import type { Instance, Maybe, Report, Run } from "./data";

/** Median of the values; a missing value counts as infinity. */
export function median(values: Maybe[]): Maybe {
  if (values.length === 0) return null;
  const sorted = values.map((value) => value ?? Infinity).sort((a, b) => a - b);
  const low = sorted[(sorted.length - 1) >> 1] ?? Infinity;
  const high = sorted[sorted.length >> 1] ?? Infinity;
  const middle = (low + high) / 2;
  return Number.isFinite(middle) ? middle : null;
}

/** Seconds or iterations at the first sample whose certified relative gap is at most the target. */
export function reached(run: Run, target: number, axis: "seconds" | "iteration"): Maybe {
  const gaps = run.trace.relative_gap;
  for (let i = 0; i < gaps.length; i++) {
    const gap = gaps[i];
    if (typeof gap === "number" && gap <= target) return run.trace[axis][i] ?? null;
  }
  // A trace may omit the end of its run, which is known from the run itself.
  if (run.relative_gap === null || run.relative_gap > target) return null;
  return axis === "seconds" ? run.seconds : run.iterations;
}

export interface Ranked {
  solver: string;
  value: number;
}

/** The solvers that reach the target in the median of their repetitions, fastest first. */
export function ranking(report: Report, instance: Instance, target: number, axis: "seconds" | "iteration"): Ranked[] {
  const ranked: Ranked[] = [];
  for (const { id } of report.data.solvers) {
    const runs = report.runsOf(instance.id, id).filter((run) => axis === "iteration" || report.hasComparableTime(run));
    const value = median(runs.map((run) => reached(run, target, axis)));
    if (value !== null) ranked.push({ solver: id, value });
  }
  return ranked.sort((a, b) => a.value - b.value);
}

/** 1e-1, 1e-2, ... down to the smallest gap that any run certified. */
export function targets(report: Report): number[] {
  const best = Math.min(...report.data.runs.map((run) => run.relative_gap ?? Infinity));
  const decades: number[] = [];
  for (let e = 1; e <= 12 && 10 ** -e >= best; e++) decades.push(Number(`1e-${e}`));
  return decades;
}

/** The tightest target that two solvers reach on an instance or, failing that, the tightest that one reaches. */
export function tightest(report: Report, instance: Instance, decades: number[]): number | null {
  const tightestFirst = [...decades].reverse();
  for (const solvers of [2, 1]) {
    const found = tightestFirst.find((target) => ranking(report, instance, target, "seconds").length >= solvers);
    if (found !== undefined) return found;
  }
  return null;
}

/** The values with their counts, most frequent first. */
export function tally(values: string[]): [string, number][] {
  const counts = new Map<string, number>();
  for (const value of values) counts.set(value, (counts.get(value) ?? 0) + 1);
  return [...counts].sort((a, b) => b[1] - a[1]);
}
