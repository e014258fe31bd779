import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";

/**
 * What a laboratory says of its bench is in benches/*.toml and comes from the server: no file of the
 * page knows a name or a number of it. The drawings in live/circuits are the exception for names:
 * each draws one compiled structure of the server and looks its parameters up by their own symbols.
 */
const sources = import.meta.glob("../src/**/*.{ts,svelte}", {
  query: "?raw",
  import: "default",
  eager: true,
}) as Record<string, string>;
const shipped = ["paper", "servo-motor", "gear-motor", "speed-motor", "paper-current"].map((name) =>
  readFileSync(new URL(`../../benches/${name}.toml`, import.meta.url), "utf8"),
);
const drawings = /\/live\/circuits\//;

/** `Kt`, `R12`: parameters of the [plant] tables; one letter alone is a word of many things. */
const symbols = new Set(
  shipped.flatMap((text) => {
    const plant = /\[plant\][^\n]*\n([\s\S]*?)\n\[/.exec(text)?.[1] ?? "";
    return [...plant.matchAll(/^([A-Z]\w+)\s*=/gm)].map((match) => match[1] as string);
  }),
);
/** Values of parameters and components in so many digits that nothing else has them by chance. */
const values = new Set(
  shipped.flatMap((text) => {
    const lines = text
      .slice(text.indexOf("[plant]"), text.indexOf("[channel."))
      .replace(/#.*/g, "");
    const numbers = [...lines.matchAll(/(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+)?/g)].map(([one]) => one);
    const digits = (number: string) => number.replace(/e.*/, "").replace(/^0\.0*|\.|0+$/g, "");
    return numbers.filter((number) => digits(number).length > (number.includes("e") ? 1 : 2));
  }),
);

/** Lines of the page that `pattern` finds, comments of code aside. */
function found(pattern: RegExp, except = /^$/): string[] {
  return Object.entries(sources)
    .filter(([path]) => !except.test(path))
    .flatMap(([path, text]) =>
      text
        .split("\n")
        .filter((line) => !/^\s*(\/\/|\/?\*|<!--)/.test(line) && pattern.test(line))
        .map((line) => `${path}: ${line.trim()}`),
    );
}

describe("the page", () => {
  it("is searched for what the benches of the repository have", () => {
    expect(Object.keys(sources).length).toBeGreaterThan(80);
    expect([...symbols]).toEqual(expect.arrayContaining(["R9", "R12", "C8", "Ra", "Ke", "Rs"]));
    expect([...values]).toEqual(expect.arrayContaining(["47e-12", "7.41", "33e3", "1.43e-6"]));
    expect(found(/parts\.of\("R12"\)/)).toHaveLength(1); // the search sees the drawings
  });
  it("names no component of any bench", () => {
    const names = new RegExp(`(?<![\\p{L}\\w.])(?:${[...symbols].join("|")})(?![\\p{L}\\w])`, "u");
    expect(found(names, drawings)).toEqual([]);
  });
  it("has no value of any bench", () => {
    const numbers = [...values].map((value) => value.replace(".", "\\."));
    expect(found(new RegExp(`(?<![\\w.])(?:${numbers.join("|")})(?![\\w.])`))).toEqual([]);
  });
  it("has no relay line", () => {
    expect(found(/\bDo\d/)).toEqual([]);
  });
  it("has no period, rate or table of one bench", () => {
    expect(found(/\b100 ?Hz|\btables? \d|\btabel\w* \d|\bEq\. ?\d/i)).toEqual([]);
    expect(found(/(?<![\d.])0\.01(?!\d|em)/, /i18n\/quantity\.ts|theme\/tokens\.ts/)).toEqual([]);
  });
});
