/**
 * Converts the Latin Serbian catalogue to Cyrillic. The two scripts correspond letter by letter.
 * Text that is not a Serbian word stays Latin: {values}, `code`, signal and parameter names,
 * formats, units.
 */
const DIGRAPHS: [string, string][] = [
  ["DŽ", "Џ"],
  ["Dž", "Џ"],
  ["dž", "џ"],
  ["LJ", "Љ"],
  ["Lj", "Љ"],
  ["lj", "љ"],
  ["NJ", "Њ"],
  ["Nj", "Њ"],
  ["nj", "њ"],
];
const LATIN = "ABVGDĐEŽZIJKLMNOPRSTĆUFHCČŠabvgdđežzijklmnoprstćufhcčš";
const CYRILLIC = "АБВГДЂЕЖЗИЈКЛМНОПРСТЋУФХЦЧШабвгдђежзијклмнопрстћуфхцчш";

const KEEP =
  /\{\w+\}|`[^`]*`|\b(?:faultlab|K|B|L|M|T|F|A|Esc|Um|Uc|Ua|Ia|SWA|SIA|PRBS|CSV|MAT|PNG|PDF|JSON|MATLAB|API|REST|WebSocket|OpenAPI|Python|GitHub|REVIEW|RTT|SIM|[ab][01]d?|[xXqQwWyY]\w*|\d+\s?(?:ms|s|V|Hz|px|x|kHz|mV|min|MB)|(?:ms|Hz|rpm|mm))\b/g;

function letters(text: string): string {
  let out = text;
  for (const [latin, cyrillic] of DIGRAPHS) out = out.replaceAll(latin, cyrillic);
  return [...out]
    .map((c) => {
      const at = LATIN.indexOf(c);
      return at < 0 ? c : (CYRILLIC[at] as string);
    })
    .join("");
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
