// Fails the build when the first load of a page exceeds its budget of 90 kB gzipped.
import { readFileSync, rmSync } from "node:fs";
import { join } from "node:path";
import { gzipSync } from "node:zlib";

const BUDGET = 90_000;
const dist = new URL("../dist", import.meta.url).pathname;
const manifest = JSON.parse(readFileSync(join(dist, ".vite/manifest.json"), "utf8"));
const gzipped = (file) => gzipSync(readFileSync(join(dist, file)), { level: 9 }).length;

/** Files that `key` needs before it can run. */
function filesOf(key, found = new Set()) {
  const chunk = manifest[key];
  if (!chunk || found.has(chunk.file)) return found;
  found.add(chunk.file);
  for (const css of chunk.css ?? []) found.add(css);
  for (const other of chunk.imports ?? []) filesOf(other, found);
  return found;
}

const entry = Object.keys(manifest).find((key) => manifest[key].isEntry);
const pages = Object.keys(manifest).filter((key) => key.startsWith("src/pages/"));
let failed = false;
for (const page of pages) {
  const files = [...filesOf(entry), ...filesOf(page)];
  const bytes = [...new Set(files)].reduce(
    (sum, file) => sum + gzipped(file),
    gzipped("index.html"),
  );
  if (bytes > BUDGET) failed = true;
  const name = page.replace(/^.*\/(.*)\.svelte$/, "$1").padEnd(14);
  console.log(`${name} ${(bytes / 1000).toFixed(1).padStart(6)} kB gzipped of ${BUDGET / 1000}`);
}
rmSync(join(dist, ".vite"), { recursive: true }); // not to be served
if (failed) {
  console.error("a page's first load is over its budget");
  process.exit(1);
}
