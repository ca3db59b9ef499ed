// From the traces of an instance to curves: one strand per run, and a median with quartiles per solver.

import type { Instance, Report, Run, Solver } from "../data";
import { middleOf, type Middle } from "./middle";
import type { Sample, View } from "./samples";

export interface Curve {
  solver: Solver;
  /** The samples of each repetition, by iteration. */
  strands: Sample[][];
  middle: Middle;
}

export interface Curves {
  curves: Curve[];
  /** Solvers that ran on the instance but have no values on these axes. */
  absent: Solver[];
  /** The number of samples at or below zero, which a logarithmic axis cannot show. */
  nonPositive: number;
  /** The number of runs left out because their times are from another machine. */
  otherMachine: number;
}

export function curvesOf(report: Report, instance: Instance, view: View): Curves {
  const result: Curves = { curves: [], absent: [], nonPositive: 0, otherMachine: 0 };
  for (const solver of report.data.solvers) {
    const all = report.runsOf(instance.id, solver.id);
    if (all.length === 0) continue;
    const runs = view.axis === "seconds" ? all.filter((run) => report.hasComparableTime(run)) : all;
    result.otherMachine += all.length - runs.length;
    const strands: Sample[][] = [];
    for (const run of runs) {
      const samples = strandOf(run, view, result);
      if (samples.length > 0) strands.push(samples);
    }
    if (strands.length === 0) result.absent.push(solver);
    else result.curves.push({ solver, strands, middle: middleOf(strands, view) });
  }
  return result;
}

function strandOf(run: Run, view: View, result: Curves): Sample[] {
  const xs = run.trace[view.axis];
  const ys = run.trace[view.quantity] ?? [];
  const samples: Sample[] = [];
  for (let index = 0; index < xs.length; index++) {
    const x = xs[index];
    const y = ys[index];
    if (typeof x !== "number" || typeof y !== "number") continue;
    if (view.logY && y <= 0) result.nonPositive++;
    else if (!view.logX || x > 0) samples.push({ run, index, x, y });
  }
  return samples;
}
