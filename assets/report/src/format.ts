// Numbers, dates and counts as text.

import type { Maybe } from "./data";

export const MISSING = "–";

function known(value: Maybe | undefined): value is number {
  return typeof value === "number" && Number.isFinite(value);
}

/** Plain digits if they are readable, else an exponent in the format of the command line. */
export function significant(value: Maybe | undefined, digits = 4): string {
  if (!known(value)) return MISSING;
  if (Number.isInteger(value) && Math.abs(value) < 1e15) return value.toLocaleString("en-US");
  const size = Math.abs(value);
  if (size < 1e-3 || size >= 1e6) return value.toExponential(digits - 1).replace(/\.?0+e/, "e");
  return value.toLocaleString("en-US", { maximumSignificantDigits: digits });
}

export function gap(value: Maybe | undefined): string {
  return known(value) ? value.toExponential(2) : MISSING;
}

export function seconds(value: Maybe | undefined): string {
  return known(value) ? `${significant(value, 3)} s` : MISSING;
}

export function percent(part: number, whole: number): string {
  return whole === 0 ? MISSING : `${((100 * part) / whole).toFixed(2)} %`;
}

export function counted(count: number, one: string, many = `${one}s`): string {
  return `${count.toLocaleString("en-US")} ${count === 1 ? one : many}`;
}

export function date(text: string): string {
  const time = new Date(text);
  if (Number.isNaN(time.getTime())) return text;
  const words = time.toLocaleString("en-US", { dateStyle: "long", timeStyle: "short", hourCycle: "h23", timeZone: "UTC" });
  return `${words} UTC`;
}

export function day(text: string): string {
  const time = new Date(text);
  return Number.isNaN(time.getTime()) ? text : time.toLocaleDateString("en-US", { dateStyle: "long", timeZone: "UTC" });
}

const SUPERSCRIPTS: Record<string, string> = {
  "-": "⁻", "0": "⁰", "1": "¹", "2": "²", "3": "³", "4": "⁴", "5": "⁵", "6": "⁶", "7": "⁷", "8": "⁸", "9": "⁹",
};

/** 2e-3 as 2·10⁻³, and powers of ten without a mantissa. */
export function power(value: number): string {
  const [mantissa = "", exponent = "0"] = value.toExponential(2).split("e");
  const e = Number(exponent);
  const m = Number(mantissa);
  const raised = [...String(e)].map((digit) => SUPERSCRIPTS[digit] ?? digit).join("");
  return m === 1 ? `10${raised}` : `${m}·10${raised}`;
}
