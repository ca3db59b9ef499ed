// The median and the quartiles of the repetitions of one solver.

import { bisector, quantileSorted } from "d3-array";
import type { Sample, View } from "./samples";

export interface Point {
  x: number;
  y: number;
}

export interface Middle {
  median: Point[];
  /** First and third quartile: the edges of the band. */
  low: Point[];
  high: Point[];
}

/** The maximum number of points of a median at common positions; more would not be visible. */
const MAX_POINTS = 600;

export function middleOf(strands: Sample[][], view: View): Middle {
  return haveEqualIterations(strands) ? middleBySample(strands) : middleByPosition(strands, view);
}

const byNumber = (a: number, b: number) => a - b;
const iterationOf = ({ run, index }: Sample) => run.trace.iteration[index];

/** Whether all repetitions were sampled at the same iterations, up to the end of each. */
function haveEqualIterations(strands: Sample[][]): boolean {
  const [first = [], ...others] = [...strands].sort((a, b) => b.length - a.length);
  return others.every((strand) => strand.every((sample, i) => iterationOf(sample) === iterationOf(first[i] as Sample)));
}

/** Sample by sample, since repetitions of a deterministic method differ only in their times. A repetition that has
    ended keeps its last value and counts as the latest. */
function middleBySample(strands: Sample[][]): Middle {
  const middle: Middle = { median: [], low: [], high: [] };
  const longest = Math.max(...strands.map((strand) => strand.length));
  for (let i = 0; i < longest; i++) {
    const present = strands.flatMap((strand) => strand[i] ?? []);
    if (present.length * 2 < strands.length) break;
    const xs = present.map((sample) => sample.x).sort(byNumber);
    const ys = strands.flatMap((strand) => (strand[i] ?? strand[strand.length - 1])?.y ?? []).sort(byNumber);
    const latest = xs[xs.length - 1] ?? 0;
    while (xs.length < strands.length) xs.push(latest);
    const at = (share: number): Point => ({ x: quantileSorted(xs, share) ?? 0, y: quantileSorted(ys, share) ?? 0 });
    middle.median.push(at(0.5));
    middle.low.push(at(0.25));
    middle.high.push(at(0.75));
  }
  return middle;
}

/** At common positions, with strands interpolated linearly on these axes, as they are drawn. A strand that has ended
    keeps its last value; the median ends where half of the strands have ended. */
function middleByPosition(strands: Sample[][], view: View): Middle {
  const middle: Middle = { median: [], low: [], high: [] };
  const ends = strands.map((strand) => strand[strand.length - 1]?.x ?? 0).sort(byNumber);
  const end = ends[ends.length >> 1] ?? 0;
  const positions = [...new Set(strands.flatMap((strand) => strand.map((sample) => sample.x)))]
    .filter((x) => x <= end)
    .sort(byNumber);
  for (const x of thinned(positions, view.logX)) {
    const values = strands.flatMap((strand) => valueAt(strand, x, view) ?? []).sort(byNumber);
    if (values.length * 2 < strands.length) continue;
    const at = (share: number): Point => ({ x, y: fromAxis(quantileSorted(values, share) ?? NaN, view.logY) });
    middle.median.push(at(0.5));
    middle.low.push(at(0.25));
    middle.high.push(at(0.75));
  }
  return middle;
}

const toAxis = (value: number, log: boolean) => (log ? Math.log(value) : value);
const fromAxis = (value: number, log: boolean) => (log ? Math.exp(value) : value);
const byX = bisector((sample: Sample) => sample.x);

/** The value of a strand at x, on the scale of the axis. */
function valueAt(strand: Sample[], x: number, { logX, logY }: View): number | null {
  const next = byX.left(strand, x);
  const after = strand[next];
  const before = strand[next - 1];
  if (after?.x === x) return toAxis(after.y, logY);
  if (!before) return null;
  if (!after) return toAxis(before.y, logY);
  const [a, b, at] = [before.x, after.x, x].map((value) => toAxis(value, logX)) as [number, number, number];
  const share = (at - a) / (b - a);
  return toAxis(before.y, logY) * (1 - share) + toAxis(after.y, logY) * share;
}

/** At most MAX_POINTS of the sorted positions, evenly spread on the axis, including the ends. */
function thinned(positions: number[], log: boolean): number[] {
  if (positions.length <= MAX_POINTS) return positions;
  const first = toAxis(positions[0] ?? 0, log);
  const last = toAxis(positions[positions.length - 1] ?? 0, log);
  let slot = -1;
  return positions.filter((position, index) => {
    const now = Math.floor(((toAxis(position, log) - first) / (last - first)) * MAX_POINTS);
    const keep = now !== slot || index === positions.length - 1;
    slot = now;
    return keep;
  });
}
