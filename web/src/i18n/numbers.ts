import { i18n } from "./i18n.svelte";

/** As the reader's language writes it, with exactly so many decimals: "5.60", "5,60". */
export function fixed(value: number, decimals: number): string {
  return i18n.number(value, { minimumFractionDigits: decimals, maximumFractionDigits: decimals });
}

/** With at most so many significant digits: "5.6", "12,300"; "5,6", "12.300". */
export function significant(value: number, digits: number): string {
  return i18n.number(value, { maximumSignificantDigits: digits });
}

const PREFIXES: Record<string, number> = {
  p: 1e-12,
  n: 1e-9,
  u: 1e-6,
  µ: 1e-6,
  μ: 1e-6,
  m: 1e-3,
  R: 1,
  k: 1e3,
  K: 1e3,
  M: 1e6,
};

/** The value of a part as people write it, as `faultlab` reads it: "33k", "4k7", "47 pF", "4R7". */
function partValue(plain: string): number {
  const found = /^(\d+)([.,]\d+)?([pnuµμmRkKM])(\d*)(?:ohm|Ω|Ω|F|H)?$/.exec(plain);
  if (!found) return Number.NaN;
  const [, whole, decimals = "", prefix = "", more] = found;
  if (decimals && more) return Number.NaN;
  const digits = more ? `${whole}.${more}` : `${whole}${decimals.replace(",", ".")}`;
  return Number((Number(digits) * (PREFIXES[prefix] ?? Number.NaN)).toPrecision(15));
}

/**
 * The number that a person has typed, with a decimal point or comma, or NaN: "5.6", "5,6", "−1",
 * "1 000,5", and the value of a part, "4k7". Of two different separators the last one is the decimal
 * one.
 */
export function typedNumber(text: string): number {
  let plain = text.replace(/[\s\u00a0\u202f]/g, "").replace("−", "-");
  const part = partValue(plain);
  if (Number.isFinite(part)) return part;
  const last = Math.max(plain.lastIndexOf(","), plain.lastIndexOf("."));
  if (last >= 0) {
    const whole = plain.slice(0, last);
    const other = plain[last] === "," ? "." : ",";
    plain = `${whole.replaceAll(other, "")}.${plain.slice(last + 1)}`;
  }
  return /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(plain) ? Number(plain) : Number.NaN;
}
