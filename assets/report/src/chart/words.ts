// What stands around a chart: names of axes, facts of an instance, notes on what is and is not drawn.

import type { Instance } from "../data";
import { counted, significant } from "../format";
import type { Curves } from "./curves";
import type { Axis, Quantity, View } from "./samples";

export const Y_LABELS: Record<Quantity, string> = {
  relative_gap: "certified relative gap",
  suboptimality: "suboptimality",
  energy: "energy",
};
export const X_LABELS: Record<Axis, string> = { iteration: "iterations", seconds: "seconds in the solver" };

export function factsOf(instance: Instance): string {
  return [
    instance.mesh,
    counted(instance.vertices, "vertex", "vertices"),
    counted(instance.faces, "face"),
    counted(instance.regions, "region"),
    instance.lambda === null ? null : `λ = ${significant(instance.lambda)}`,
    `${instance.mass} mass`,
    instance.best_energy === null ? null : `best energy ${significant(instance.best_energy, 7)}`,
    instance.best_bound === null ? null : `best lower bound ${significant(instance.best_bound, 7)}`,
  ]
    .filter(Boolean)
    .join(" · ");
}

export function emptyText(view: View): string {
  const what = Y_LABELS[view.quantity];
  const why = view.logY || view.logX ? " that a logarithmic axis has a place for" : "";
  return `No run of this instance recorded a ${what}${why}.`;
}

export function notesOf(data: Curves, view: View, every: boolean): string {
  const notes: string[] = [];
  const repeated = data.curves.some((curve) => curve.strands.length > 1);
  if (repeated) {
    notes.push(
      every
        ? "One line a repetition."
        : "Lines are medians over the repetitions, bands span the quartiles.",
    );
  }
  if (data.lost > 0) {
    notes.push(`${counted(data.lost, "sample")} at or below zero ${data.lost === 1 ? "has" : "have"} no place on a logarithmic axis.`);
  }
  if (data.elsewhere > 0) {
    notes.push(`${counted(data.elsewhere, "run")} of another machine left out: seconds of different machines do not compare.`);
  }
  const drawn = data.curves.flatMap((curve) => curve.strands.flatMap((strand) => strand[0]?.run ?? []));
  const loaded = drawn.filter((run) => run.loaded).length;
  if (view.axis === "seconds" && loaded > 0) notes.push(`The machine was loaded during ${loaded} of the ${counted(drawn.length, "run")} drawn here.`);
  return notes.join(" ");
}
