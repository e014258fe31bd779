import { describe, expect, it } from "vitest";
import limits from "../../hardware/rig_limits.cc?raw";
import type { RunEvent } from "../src/contract/types";
import { i18n } from "../src/i18n/i18n.svelte";
import { detectorWords, eventWords, rigWords } from "../src/i18n/rig_words";
import source from "../src/i18n/rig_words.ts?raw";

await i18n.loadAll();
const sources = Object.values(
  import.meta.glob(
    ["../../{core,hardware,server}/**/*.cc", "../../{core,hardware,server}/**/*.h"],
    {
      query: "?raw",
      import: "default",
      eager: true,
    },
  ) as Record<string, string>,
)
  .join("\n")
  .replace(/"\s*\n\s*"/g, "");

describe("what rigs and the lab write", () => {
  it("is known by forms that the C++ sources still write", () => {
    const forms = [...source.matchAll(/^ {2}(?:\[| {2})\/\^(.+?)\/s?,/gm)].map(
      ([, form]) => form as string,
    );
    expect(forms.length).toBeGreaterThan(25);
    // the longest stretch of plain words of each form
    const plain = forms.map((form) =>
      form
        .split(/\(\?:[^)]*\)|\(\?<\w+>[^)]*\)|\$|\\\./)
        .reduce((longest, part) => (part.length > longest.length ? part : longest), "")
        .replace(/\\([/?+])/g, "$1")
        .trim(),
    );
    expect(plain.filter((words) => !sources.includes(words))).toEqual([]);
  });
  it("is said in the page's words", () => {
    expect(rigWords("the check between users failed: b0d is 0.512345 of its norm")).toBe(
      "The check between users failed: the gain is 0.512345 of its normal value",
    );
    expect(rigWords("no single component explains the record: beside R1 also Ra")).toContain(
      "R1 and also Ra",
    );
    expect(rigWords("ia reads 0.03 A too much: its sensor, no component")).toBe(
      "ia reads 0.03 A too much. No component explains this: look at its sensor.",
    );
    expect(
      rigWords("dry friction takes 0.99 mNm, 0.33 before: bearings or brushes, no component"),
    ).toContain("0.99 mNm, 0.33 before.");
    expect(
      rigWords("the winding has moved by +1.7 %, as that of a rig that warms up or runs in does"),
    ).toBe(
      "The resistance of the winding has moved by 1.7 %, as that of a rig that warms up or runs in does.",
    );
    expect(rigWords("n reads 1.05 times what it should: its sensor, no component")).toContain(
      "1.05 times",
    );
    expect(rigWords("not calibrated, check 'noise' failed: 1 V; look")).toContain("first seconds");
    expect(
      rigWords(
        "not calibrated, check 'noise' failed: 1 V; look; it fits when n is multiplied by 9.549: is its unit rad/s?",
      ),
    ).toMatch(/unit\. It fits when n is multiplied by 9\.549: is its unit rad\/s\?$/);
    expect(
      rigWords(
        "not calibrated, check 'tolerance' failed: 1; correct it; it fits with the other sign of ia",
      ),
    ).toMatch(/It fits with the other sign of ia\.$/);
    expect(detectorWords("glr_25")).toBe("the GLR test over 25 samples");
    expect(detectorWords("other")).toBe("other");
  });
  it("names every interlock with what was read", () => {
    const names = [...limits.matchAll(/MakeTrip\(\s*"(\w+)"/g)].map(([, name]) => name as string);
    expect(names.length).toBeGreaterThan(3);
    for (const name of names) {
      const said = rigWords(`${name}: motor current 5.25 A, allowed 4 A`);
      expect(said, name).toMatch(/: 5\.25 A, allowed 4 A$/);
      expect(said, name).not.toContain("_");
    }
  });
  it("is shown as it is when the page does not know it, as the words of people are", () => {
    expect(rigWords("belt is worn: see the note")).toBe("belt is worn: see the note");
  });
  it("of an event comes from its reason, in old recordings from its text", () => {
    const event = { kind: "refused", index: 1, t_s: 0.1, component: "R1", value: 3 } as RunEvent;
    expect(eventWords({ ...event, text: "a newer command came before this one could act" })).toBe(
      "a newer command replaced it",
    );
    const text = "R1 would switch twice";
    expect(eventWords({ ...event, text })).toBe(text);
    const parameters = { component: "R1", apart_s: "0.1", rest_s: "0.5" };
    expect(eventWords({ ...event, text, reason: "relays_rest", parameters })).toContain(
      "must rest 0.5 s",
    );
  });
});
