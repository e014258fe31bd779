import type { Component } from "../api/types";

const PREFIXES: [number, string][] = [
  [1e6, "M"],
  [1e3, "k"],
  [1, ""],
  [1e-3, "m"],
  [1e-6, "µ"],
  [1e-9, "n"],
  [1e-12, "p"],
];
const SUPERSCRIPT: Record<string, string> = {
  "-": "⁻",
  "0": "⁰",
  "1": "¹",
  "2": "²",
  "3": "³",
  "4": "⁴",
  "5": "⁵",
  "6": "⁶",
  "7": "⁷",
  "8": "⁸",
  "9": "⁹",
};

export function unitOf(component: Component): string {
  if (component === "C8") return "F";
  if (component === "J") return "kg·m²";
  if (component === "B") return "Nm·s/rad";
  return "Ω";
}

const usesPrefix = (component: Component) => component !== "J" && component !== "B";

/** "5.6 kΩ", "47 pF", "1.43·10⁻⁶ kg·m²". */
export function formatQuantity(
  component: Component,
  value: number | null | undefined,
  digits = 3,
): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (!usesPrefix(component)) return `${scientific(value, digits)} ${unitOf(component)}`;
  const [scale, prefix] = prefixOf(value);
  return `${plain(value / scale, digits)} ${prefix}${unitOf(component)}`;
}

/** "99.6 ± 0.4 Ω": the value to the digits that its standard error leaves. */
export function formatWithSigma(
  component: Component,
  value: number | null,
  sigma: number | null | undefined,
): string {
  if (
    value === null ||
    sigma === null ||
    sigma === undefined ||
    !Number.isFinite(sigma) ||
    sigma <= 0
  ) {
    return formatQuantity(component, value);
  }
  const unit = unitOf(component);
  if (usesPrefix(component)) {
    const [scale, prefix] = prefixOf(value);
    const decimals = decimalsFor(sigma / scale);
    return `${(value / scale).toFixed(decimals)} ± ${(sigma / scale).toFixed(decimals)} ${prefix}${unit}`;
  }
  const exponent = Math.floor(Math.log10(Math.abs(value)));
  const scale = 10 ** exponent;
  const decimals = decimalsFor(sigma / scale);
  return `(${(value / scale).toFixed(decimals)} ± ${(sigma / scale).toFixed(decimals)})·10${raised(exponent)} ${unit}`;
}

function prefixOf(value: number): [number, string] {
  const size = Math.abs(value);
  for (const [scale, prefix] of PREFIXES) if (size >= scale * 0.9995) return [scale, prefix];
  return PREFIXES[PREFIXES.length - 1] as [number, string];
}

/** One significant digit of the error, two when it begins with 1. */
function decimalsFor(sigma: number): number {
  const power = Math.floor(Math.log10(sigma));
  const digit = sigma / 10 ** power;
  return Math.min(8, Math.max(0, -power + (digit < 1.95 ? 1 : 0)));
}

function plain(value: number, digits: number): string {
  return minus(Number(value.toPrecision(digits)).toString());
}

function scientific(value: number, digits: number): string {
  if (value === 0) return "0";
  const exponent = Math.floor(Math.log10(Math.abs(value)));
  return `${plain(value / 10 ** exponent, digits)}·10${raised(exponent)}`;
}

function raised(exponent: number): string {
  return [...String(exponent)].map((c) => SUPERSCRIPT[c] ?? c).join("");
}

/** A number for a table: four significant digits, a real minus sign. */
export function formatNumber(value: number | null | undefined, digits = 4): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value !== 0 && Math.abs(value) < 1e-4) return scientific(value, digits);
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(Math.abs(value) || 1)));
  return minus(value.toFixed(Math.min(6, decimals)));
}

export function minus(text: string): string {
  return text.replace("-", "−");
}

/** "00:31.9" */
export function formatClock(seconds: number): string {
  const tenths = Math.max(0, Math.floor(seconds * 10 + 1e-6));
  const minutes = Math.floor(tenths / 600);
  const rest = tenths % 600;
  return `${String(minutes).padStart(2, "0")}:${String(Math.floor(rest / 10)).padStart(2, "0")}.${rest % 10}`;
}
