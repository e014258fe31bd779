import { expect, it } from "vitest";

/** A folder of src may import those before it. */
const FLOORS = [
  "contract",
  "loading",
  "i18n",
  "api",
  "stream",
  "plant",
  "charts",
  "theme",
  "figures",
  "shell",
  "lab",
  "live",
  "learn",
  "course",
  "pages",
];

const sources = import.meta.glob("../src/*/**/*.{ts,svelte}", {
  query: "?raw",
  import: "default",
  eager: true,
}) as Record<string, string>;
const folderOf = (path: string) => path.split("/")[2] ?? "";

/** "live imports pages: RunBar.svelte" */
function climbs(): string[] {
  const found: string[] = [];
  for (const [path, text] of Object.entries(sources)) {
    for (const [, spec] of text.matchAll(/(?:from|import)\s*\(?\s*"(\.[^"]+)"/g)) {
      const to = new URL(spec ?? "", `file://${path.slice(2)}`).pathname.slice(1);
      if (!to.startsWith("src/")) continue;
      const [from, into] = [folderOf(path), to.split("/")[1] ?? ""];
      if (FLOORS.indexOf(into) > FLOORS.indexOf(from))
        found.push(`${from} imports ${into}: ${path.split("/").pop()}`);
    }
  }
  return found;
}

it("no folder imports one above it, so that none is in a circle", () => {
  expect(Object.keys(sources).length).toBeGreaterThan(200);
  const folders = new Set(Object.keys(sources).map(folderOf));
  expect([...folders].sort()).toEqual([...FLOORS].sort());
  expect(climbs()).toEqual([]);
});
