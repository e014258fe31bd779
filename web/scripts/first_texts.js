// Splits src/i18n/languages/en.ts for loading: `en.ts?first` has the texts that the first pages
// can show before they load any further part, `en.ts?lessons` those of Learn, `en.ts?rest` the
// others. The split follows from the sources: a text is of the first part when a file that these
// pages import names its key.
import { existsSync, readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { runnerImport } from "vite";
import { refusals, file as refusalsFile } from "./refusals.js";

const src = new URL("../src", import.meta.url).pathname;
const english = join(src, "i18n/languages/en.ts");
const FIRST = ["main.ts", "pages/RunPage.svelte"];

/** Files of src that `file` needs at once: its static imports and theirs. */
export function closure(file, found = new Map()) {
  if (found.has(file)) return found;
  const source = readFileSync(file, "utf8");
  found.set(file, source);
  for (const [, path] of source.matchAll(/^\s*(?:import|export)\s(?!type\b)[^;"]*"(\.[^"?]+)"/gm)) {
    const base = join(dirname(file), path);
    const needed = [base, `${base}.ts`].find(
      (name) => /\.(ts|svelte)$/.test(name) && existsSync(name),
    );
    if (needed && !needed.startsWith(dirname(english))) closure(needed, found);
  }
  return found;
}

/** Keys of `texts` that the first pages name, one by one or by the group of a word. */
function firstKeys(texts) {
  const files = new Map();
  for (const page of FIRST) closure(join(src, page), files);
  const source = [...files.values()].join("\n");
  const named = new Set([...source.matchAll(/"(\w+)"/g)].map(([, name]) => name));
  const groups = [...source.matchAll(/\b(?:word\("(\w+)"|t\(`(\w+_)\$)/g)].map(
    ([, group, prefix]) => prefix ?? `${group}_`,
  );
  return Object.keys(texts).filter(
    (key) => named.has(key) || groups.some((group) => key.startsWith(group)),
  );
}

export function firstTexts() {
  return {
    name: "first-texts",
    async load(id) {
      const part = /languages\/en\.ts\?(first|lessons|rest)$/.exec(id)?.[1];
      if (!part) return null;
      this.addWatchFile(english);
      this.addWatchFile(refusalsFile);
      const { module } = await runnerImport(english, {
        configFile: false,
        logLevel: "error",
        plugins: [refusals()],
      });
      const first = new Set(firstKeys(module.texts));
      const partOf = (key) =>
        first.has(key) ? "first" : key.startsWith("lesson_") ? "lessons" : "rest";
      const kept = Object.entries(module.texts).filter(([key]) => partOf(key) === part);
      return `export const texts = ${JSON.stringify(Object.fromEntries(kept))};`;
    },
  };
}
