// The text around a chart: axis labels, facts about an instance, notes on what is and is not drawn.

import type { Instance } from "../data";
import { counted, significant } from "../format";
import type { Curves } from "./curves";
import type { Axis, Quantity, View } from "./samples";

export const Y_LABELS: Record<Quantity, string> = {
  relative_gap: "certified relative gap",
  suboptimality: "suboptimality",
  energy: "energy",
  distance: "mean distance to the truth / diagonal",
  mislabeled: "share that is mislabeled",
  silhouette_iou: "agreement of silhouettes",
};
export const X_LABELS: Record<Axis, string> = { iteration: "iterations or steps", seconds: "seconds in the solver" };

export function factsOf(instance: Instance): string {
  return [
    instance.mesh,
    counted(instance.vertices, "vertex", "vertices"),
    counted(instance.faces, "face"),
    counted(instance.regions, "region"),
    instance.lambda === null ? null : `λ = ${significant(instance.lambda)}`,
    instance.mass === null ? null : `${instance.mass} mass`,
    instance.best_energy === null ? null : `best energy ${significant(instance.best_energy, 7)}`,
    instance.best_bound === null ? null : `best lower bound ${significant(instance.best_bound, 7)}`,
  ]
    .filter(Boolean)
    .join(" · ");
}

export function emptyText(view: View): string {
  const what = Y_LABELS[view.quantity];
  const why = view.logY || view.logX ? " that a logarithmic axis can show" : "";
  return `No run of this instance recorded any ${what}${why}.`;
}

export function notesOf(data: Curves, view: View, every: boolean): string {
  const notes: string[] = [];
  const repeated = data.curves.some((curve) => curve.strands.length > 1);
  if (repeated) {
    notes.push(
      every
        ? "One line per repetition."
        : "Lines are medians over the repetitions; bands span the quartiles.",
    );
  }
  if (data.nonPositive > 0) {
    notes.push(`${counted(data.nonPositive, "sample")} at or below zero ${data.nonPositive === 1 ? "is" : "are"} not shown on a logarithmic axis.`);
  }
  if (data.otherMachine > 0) {
    notes.push(`${counted(data.otherMachine, "run")} on another machine left out: times from different machines are not comparable.`);
  }
  const drawn = data.curves.flatMap((curve) => curve.strands.flatMap((strand) => strand[0]?.run ?? []));
  const loaded = drawn.filter((run) => run.loaded).length;
  if (view.axis === "seconds" && loaded > 0) notes.push(`The machine was loaded during ${loaded} of the ${counted(drawn.length, "run")} drawn here.`);
  return notes.join(" ");
}
