import { fixed, significant } from "./numbers";

const PREFIXES: [number, string][] = [
  [1e6, "M"],
  [1e3, "k"],
  [1, ""],
  [1e-3, "m"],
  [1e-6, "µ"],
  [1e-9, "n"],
  [1e-12, "p"],
];
const SUPERSCRIPT = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/** Units of descriptions, which are words of ASCII, that people write otherwise. */
const TEXTS: Record<string, string> = {
  ohm: "Ω",
  farad: "F",
  henry: "H",
  "V/(rad/s)": "V·s/rad",
  "Nm/(rad/s)": "Nm·s/rad",
};
/** Written with an SI prefix: "5.6 kΩ", not "5600 Ω". */
const PREFIXED = new Set(["Ω", "F", "H", "V", "A", "s", "V·s/rad", "V·s", "Nm/A"]);

/** A unit that is not in the list is shown as it is, with its powers raised. */
function shownUnit(unit: string): { text: string; prefixed: boolean } {
  const power = /\^?(-?\d+)/g;
  const plain = unit.replace(power, (_, digits: string) => raised(Number(digits))).trim();
  const text = TEXTS[unit] ?? plain.replace(/\s+/g, "·");
  return { text, prefixed: PREFIXED.has(text) };
}

export function formatUnit(unit: string): string {
  return shownUnit(unit).text;
}

/** "5.6 kΩ", "47 pF", "1.43·10⁻⁶ kg·m²". @param unit SI, as a bench's description names it */
export function formatQuantity(unit: string, value: number | null | undefined, digits = 3): string {
  return `${formatShort(unit, value, digits)}${tail(unit, value)}`;
}

const TICK_UNIT_MAX = 2;

/**
 * For ticks of a scale around `nominal`. A long unit is left out: the numbers are then in the unit
 * that the nominal value is written in.
 */
export function formatTick(unit: string, value: number, nominal: number): string {
  const { text, prefixed } = shownUnit(unit);
  if (!prefixed) return formatShort(unit, value, 3);
  if (text.length <= TICK_UNIT_MAX) return formatQuantity(unit, value);
  return significant(value / prefixOf(nominal)[0], 3);
}

function formatShort(unit: string, value: number | null | undefined, digits: number): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (!shownUnit(unit).prefixed) return bare(value, digits);
  const [scale] = prefixOf(value);
  return significant(value / scale, digits);
}

function tail(unit: string, value: number | null | undefined): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return "";
  const { text, prefixed } = shownUnit(unit);
  const whole = `${prefixed ? prefixOf(value)[1] : ""}${text}`;
  return whole && ` ${whole}`;
}

/** "99.6 ± 0.4 Ω": the value with as many digits as its standard error justifies. */
export function formatWithSigma(
  unit: string,
  value: number | null,
  sigma: number | null | undefined,
): string {
  if (value === null || !sigma || sigma < 0 || !Number.isFinite(sigma))
    return formatQuantity(unit, value);
  const powered = !shownUnit(unit).prefixed && isPowered(value);
  const exponent = powered ? Math.floor(Math.log10(Math.abs(value))) : 0;
  const scale = shownUnit(unit).prefixed ? prefixOf(value)[0] : 10 ** exponent;
  const decimals = decimalsFor(sigma / scale);
  const both = `${fixed(value / scale, decimals)} ± ${fixed(sigma / scale, decimals)}`;
  return `${powered ? `(${both})·10${raised(exponent)}` : both}${tail(unit, value)}`;
}

/** Too small or too large to be read without a power of ten. */
function isPowered(value: number): boolean {
  const size = Math.abs(value);
  return size !== 0 && (size < 0.01 || size >= 1e5);
}

function bare(value: number, digits: number): string {
  return isPowered(value) ? scientific(value, digits) : significant(value, digits);
}

function prefixOf(value: number): [number, string] {
  if (value === 0) return [1, ""];
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

function scientific(value: number, digits: number): string {
  if (value === 0) return "0";
  const exponent = Math.floor(Math.log10(Math.abs(value)));
  return `${significant(value / 10 ** exponent, digits)}·10${raised(exponent)}`;
}

function raised(exponent: number): string {
  return [...String(exponent)].map((c) => SUPERSCRIPT[Number(c)] ?? "⁻").join("");
}

/** A number for a table: four significant digits, a true minus sign. */
export function formatNumber(value: number | null | undefined, digits = 4): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  if (Math.abs(value) < 1e-4) return scientific(value, digits);
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(Math.abs(value))));
  return fixed(value, Math.min(6, decimals));
}

/** "00:31.9" */
export function formatClock(seconds: number): string {
  const tenths = Math.max(0, Math.floor(seconds * 10 + 1e-6));
  const minutes = Math.floor(tenths / 600);
  const rest = fixed((tenths % 600) / 10, 1);
  return `${String(minutes).padStart(2, "0")}:${rest.padStart(4, "0")}`;
}

/** Run time with the decimals that samples `periodS` apart need: "10.00", "10.002". */
export function formatSeconds(seconds: number, periodS: number): string {
  return fixed(seconds, Math.min(6, Math.max(2, Math.ceil(-Math.log10(periodS) - 1e-9))));
}

/** A length of time to three digits, and in the unit that suits it: "50 ms", "1.2 s". */
export function formatSpan(seconds: number): string {
  return formatQuantity("s", seconds);
}
