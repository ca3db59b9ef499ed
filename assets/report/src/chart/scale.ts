// Axes: domain, scale, ticks.

import { scaleLinear, scaleLog, type ScaleContinuousNumeric } from "d3-scale";
import { power } from "../format";

export type Scale = ScaleContinuousNumeric<number, number>;
export type Domain = [number, number];

export interface Tick {
  value: number;
  label: string;
}

/** The domain of the values, with some padding. */
export function domainOf(values: Iterable<number>, log: boolean): Domain {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (low > high) return log ? [0.1, 1] : [0, 1];
  if (log) {
    const padding = low === high ? 2 : (high / low) ** 0.03;
    return [low / padding, high * padding];
  }
  const padding = low === high ? Math.abs(low) * 0.1 || 1 : (high - low) * 0.03;
  // Counts and times start at zero, so there is no padding below it.
  return [low >= 0 && low - padding < 0 ? 0 : low - padding, high + padding];
}

export function scaleOf(domain: Domain, log: boolean, range: [number, number]): Scale {
  return (log ? scaleLog() : scaleLinear()).domain(domain).range(range);
}

/** Ticks about `spacing` pixels apart or more. */
export function ticksOf(scale: Scale, log: boolean, spacing: number): Tick[] {
  const [a = 0, b = 0] = scale.range();
  const room = Math.max(2, Math.floor(Math.abs(b - a) / spacing));
  if (!log) {
    const format = scale.tickFormat(room);
    return scale.ticks(room).map((value) => ({ value, label: format(value) }));
  }
  const [low = 1, high = 1] = scale.domain();
  const from = Math.ceil(Math.log10(low) - 1e-9);
  const to = Math.floor(Math.log10(high) + 1e-9);
  // One notation per axis: plain digits if all labels are short.
  const label = (value: number) => (from >= -2 && to <= 4 ? value.toLocaleString("en-US") : power(value));
  if (to - from >= 2) {
    const step = Math.ceil((to - from + 1) / room);
    const ticks: Tick[] = [];
    for (let e = from; e <= to; e += step) ticks.push({ value: Number(`1e${e}`), label: label(Number(`1e${e}`)) });
    return ticks;
  }
  // The domain is so small that a logarithmic axis is nearly linear.
  if (high / low < 5) return scaleLinear().domain([low, high]).ticks(room).map((value) => ({ value, label: labelWithin(value, high - low) }));
  // Less than two decades: all digits if there is room, else 1, 2, 5 or fewer.
  for (const digits of [[1, 2, 3, 4, 5, 6, 7, 8, 9], [1, 2, 5], [1, 3], [1]]) {
    const ticks: Tick[] = [];
    for (let e = from - 1; e <= to + 1; e++) {
      for (const digit of digits) {
        const value = Number(`${digit}e${e}`);
        if (value >= low && value <= high) ticks.push({ value, label: label(value) });
      }
    }
    if (ticks.length >= 2 && ticks.length <= room) return ticks;
  }
  return [];
}

/** A label with enough digits to distinguish neighboring ticks. */
function labelWithin(value: number, span: number): string {
  const digits = Math.min(12, Math.max(2, Math.ceil(Math.log10(Math.abs(value) / span)) + 2));
  const plain = Math.abs(value) >= 1e-3 && Math.abs(value) < 1e5;
  return plain ? String(Number(value.toPrecision(digits))) : value.toExponential(digits - 1);
}
