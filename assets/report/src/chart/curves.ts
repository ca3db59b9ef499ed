// From the traces of an instance to curves: one strand a run, and a median with quartiles a solver.

import type { Instance, Report, Run, Solver } from "../data";
import { middleOf, type Middle } from "./middle";
import type { Sample, View } from "./samples";

export interface Curve {
  solver: Solver;
  /** Samples of each repetition, in the order of the iterations. */
  strands: Sample[][];
  middle: Middle;
}

export interface Curves {
  curves: Curve[];
  /** Solvers that ran on the instance but have nothing on these axes. */
  absent: Solver[];
  /** Samples at or below zero, which a logarithmic axis has no place for. */
  lost: number;
  /** Runs left out because their seconds are of another machine. */
  elsewhere: number;
}

export function curvesOf(report: Report, instance: Instance, view: View): Curves {
  const result: Curves = { curves: [], absent: [], lost: 0, elsewhere: 0 };
  for (const solver of report.data.solvers) {
    const all = report.runsOf(instance.id, solver.id);
    if (all.length === 0) continue;
    const runs = view.axis === "seconds" ? all.filter((run) => report.timed(run)) : all;
    result.elsewhere += all.length - runs.length;
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
  const ys = run.trace[view.quantity];
  const samples: Sample[] = [];
  for (let index = 0; index < xs.length; index++) {
    const x = xs[index];
    const y = ys[index];
    if (typeof x !== "number" || typeof y !== "number") continue;
    if (view.logY && y <= 0) result.lost++;
    else if (!view.logX || x > 0) samples.push({ run, index, x, y });
  }
  return samples;
}
