// What the page of a run needs at once and no other page does becomes one chunk, also where a later
// part, the exercise of Learn, uses some of it: in pieces it would take 2 kB more.
import { readdirSync } from "node:fs";
import { join } from "node:path";
import { closure } from "./first_texts.js";

const src = new URL("../src", import.meta.url).pathname;
const RUN = "RunPage.svelte";

export function runChunk() {
  const pages = readdirSync(join(src, "pages")).filter((name) => name.endsWith(".svelte"));
  const others = new Map();
  closure(join(src, "main.ts"), others);
  for (const page of pages) if (page !== RUN) closure(join(src, "pages", page), others);
  const own = new Set(closure(join(src, "pages", RUN)).keys());
  for (const file of others.keys()) own.delete(file);
  return { name: "run", test: (id) => own.has(id.replace(/\?.*$/, "")) };
}

/**
 * The modules that every page starts with, as one chunk: small chunks compress badly. The entry
 * stays a chunk of its own.
 */
export function baseChunk() {
  const roots = ["App.svelte", "plant/bench.ts", "shell/rigs.svelte.ts", "shell/benches.svelte.ts"];
  const modules = new Set(roots.flatMap((file) => [...closure(join(src, file)).keys()]));
  modules.delete(join(src, "App.svelte"));
  return {
    name: "base",
    priority: 2,
    test: (id) => id.includes("/node_modules/svelte/") || modules.has(id.replace(/\?.*$/, "")),
  };
}
