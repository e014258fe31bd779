import { expect, it } from "vitest";

it("a part that is loaded late is asked for again when the link was cut", () => {
  const files = import.meta.glob("../src/**/*.{svelte,ts}", {
    query: "?raw",
    import: "default",
    eager: true,
  }) as Record<string, string>;
  const lost = Object.entries(files).flatMap(([path, source]) =>
    [...source.matchAll(/(?:void|await|return|=|\{) ?import\([^)]*\)/g)].map(
      ([found]) => `${path}: ${found} is for build.part`,
    ),
  );
  expect(Object.keys(files).length).toBeGreaterThan(100);
  expect(lost).toEqual([]);
});
