import type { Text } from "./catalogue";

/**
 * Converts the Latin Serbian catalogue to Cyrillic. The two scripts correspond letter by letter.
 * Text that is not a Serbian word stays Latin: {values}, `code`, signal and parameter names,
 * formats, units.
 */
const DIGRAPHS = "DŽЏ DžЏ džџ LJЉ LjЉ ljљ NJЊ NjЊ njњ".split(" ");
const LATIN = "ABVGDĐEŽZIJKLMNOPRSTĆUFHCČŠabvgdđežzijklmnoprstćufhcčš";
const CYRILLIC = "АБВГДЂЕЖЗИЈКЛМНОПРСТЋУФХЦЧШабвгдђежзијклмнопрстћуфхцчш";

/** A unit after a number, a {place} or a label's comma. "s" alone may also be a word ("s tim danom"). */
const UNIT = "ms|s|V|A|Hz|kHz|mV|px|x|mm|min|kB|MB|GB|rpm";
const NAMES =
  "faultlab|K|B|L|M|T|F|A|m|V|SI|ID|LTI|ILIAS|Moodle|Canvas|Esc|Um|Uc|Ua|Ia|SWA|SIA|BIC|PRBS|CSV|MAT|PNG|PDF|JSON|MATLAB|API|REST|POST|NTP|UTF-8|ASCII|WebSocket|OpenAPI|Python|Prometheus|GitHub|REVIEW|RTT|SIM|[ab][01]d?|[xXqQwWyY]\\w*|ms|Hz|kHz|rpm|mm";
const KEEP = new RegExp(
  `\\{\\w+\\}(?: (?:${UNIT})(?![\\p{L}\\d]))?|, (?:${UNIT})$|\`[^\`]*\`` +
    `|\\d\\s?(?:${UNIT})(?![\\p{L}\\d])|(?<![\\p{L}\\d])(?:${NAMES})(?![\\p{L}\\d])`,
  "gu",
);

function letters(text: string): string {
  let out = text;
  for (const [a, b, cyrillic = ""] of DIGRAPHS) out = out.replaceAll(`${a}${b}`, cyrillic);
  return [...out].map((c) => CYRILLIC[LATIN.indexOf(c)] ?? c).join("");
}

export function toCyrillic(text: string): string {
  let out = "";
  let at = 0;
  for (const match of text.matchAll(KEEP)) {
    out += letters(text.slice(at, match.index)) + match[0];
    at = match.index + match[0].length;
  }
  return out + letters(text.slice(at));
}

/** Changes every form of every text. */
function each<K extends string>(
  texts: Record<K, Text>,
  change: (text: string) => string,
): Record<K, Text> {
  const changed = (text: Text): Text =>
    typeof text === "string"
      ? change(text)
      : Object.fromEntries(Object.entries(text).map(([form, said]) => [form, change(said)]));
  return Object.fromEntries(
    Object.entries<Text>(texts).map(([key, text]) => [key, changed(text)]),
  ) as Record<K, Text>;
}

const unmarked = (text: string) => text.replaceAll("`", "");

export const inLatin = <K extends string>(marked: Record<K, Text>) => each(marked, unmarked);
export const inCyrillic = <K extends string>(marked: Record<K, Text>) =>
  each(marked, (text) => unmarked(toCyrillic(text)));
