// The samples of traces on the axes of a view.

import type { Run } from "../data";

export type Quantity = "relative_gap" | "suboptimality" | "energy" | "distance" | "mislabeled" | "silhouette_iou";
export type Axis = "iteration" | "seconds";

export interface View {
  quantity: Quantity;
  axis: Axis;
  logX: boolean;
  logY: boolean;
}

export interface Sample {
  run: Run;
  index: number;
  x: number;
  y: number;
}
