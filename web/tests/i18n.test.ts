import { describe, expect, it } from "vitest";
import { toCyrillic } from "../src/i18n/cyrillic";
import { en } from "../src/i18n/en";
import { fill, loadCatalogue } from "../src/i18n/i18n.svelte";
import { srLatn } from "../src/i18n/sr_latn";

const places = (text: string) => [...text.matchAll(/\{(\w+)\}/g)].map((match) => match[1]).sort();
const keys = Object.keys(en) as (keyof typeof en)[];

describe("catalogues", () => {
  it("have the same keys", () => {
    expect(Object.keys(srLatn).sort()).toEqual([...keys].sort());
  });
  it.each(["sr-Latn", "sr-Cyrl"] as const)(
    "%s says everything, with the same places",
    async (locale) => {
      const catalogue = await loadCatalogue(locale);
      for (const key of keys) {
        expect(catalogue[key].trim(), key).not.toBe("");
        expect(places(catalogue[key]), key).toEqual(places(en[key]));
        expect(catalogue[key], key).not.toContain("`");
      }
    },
  );
  it("leave no Serbian word in Latin letters when Cyrillic is chosen", async () => {
    const catalogue = await loadCatalogue("sr-Cyrl");
    for (const key of keys) {
      if (key === "help_paper") continue; // a citation
      const kept = catalogue[key].replace(/\{\w+\}/g, "");
      expect(kept, key).not.toMatch(/[čćžšđČĆŽŠĐ]/);
      // a Latin letter beside a Cyrillic one would be a half-converted word
      expect(kept, key).not.toMatch(/[a-z][а-шђјљњћџ]|[а-шђјљњћџ][a-z]/i);
    }
  });
  it("keep names and formats in Latin", () => {
    expect(toCyrillic("Preuzmi CSV, SWA procene, R12 i b0d")).toBe(
      "Преузми CSV, SWA процене, R12 и b0d",
    );
    expect(toCyrillic("Ljubljana, džep, Njegoš {value}")).toBe("Љубљана, џеп, Његош {value}");
  });
  it("fill their places", () => {
    expect(fill("{a} of {b}", { a: 1 })).toBe("1 of {b}");
  });
});
