import { i18n } from "./i18n.svelte";

/** As the reader's language writes it, with exactly so many decimals: "5.60", "5,60". */
export function fixed(value: number, decimals: number): string {
  return i18n.number(value, { minimumFractionDigits: decimals, maximumFractionDigits: decimals });
}

/** With at most so many significant digits: "5.6", "12,300"; "5,6", "12.300". */
export function significant(value: number, digits: number): string {
  return i18n.number(value, { maximumSignificantDigits: digits });
}

/**
 * The number that a person has typed, with a decimal point or comma, or NaN: "5.6", "5,6", "−1",
 * "1 000,5". Of two different separators the last one is the decimal one.
 */
export function typedNumber(text: string): number {
  let plain = text.replace(/[\s\u00a0\u202f]/g, "").replace("−", "-");
  const last = Math.max(plain.lastIndexOf(","), plain.lastIndexOf("."));
  if (last >= 0) {
    const whole = plain.slice(0, last);
    const other = plain[last] === "," ? "." : ",";
    plain = `${whole.replaceAll(other, "")}.${plain.slice(last + 1)}`;
  }
  return /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(plain) ? Number(plain) : Number.NaN;
}
