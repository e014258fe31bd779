// "refusals:en", "refusals:sr": the sentences of core/types/refusals.json in one language, as texts
// of the page: `refused_no_rig`, ..
import { readFileSync } from "node:fs";

export const file = new URL("../../core/types/refusals.json", import.meta.url).pathname;

export function refusals() {
  return {
    name: "refusals",
    resolveId: (id) => (/^refusals:\w+$/.test(id) ? `\0${id}` : null),
    load(id) {
      const language = /^\0refusals:(\w+)$/.exec(id)?.[1];
      if (!language) return null;
      this.addWatchFile(file);
      const texts = Object.entries(JSON.parse(readFileSync(file, "utf8"))).map(
        ([reason, refusal]) => [`refused_${reason}`, refusal[language]],
      );
      return `export const texts = ${JSON.stringify(Object.fromEntries(texts))};`;
    },
  };
}
