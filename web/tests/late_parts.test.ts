import { expect, it } from "vitest";

it("a part that is loaded late is asked for again when the link was cut", () => {
  const files = import.meta.glob("../src/**/*.{svelte,ts}", {
    query: "?raw",
    import: "default",
    eager: true,
  }) as Record<string, string>;
  const tables = /(App\.svelte|i18n\.svelte\.ts|\.d\.ts)$/; // what they list, they load by build.part
  const lost = Object.entries(files)
    .filter(([path]) => !tables.test(path))
    .flatMap(([path, source]) =>
      [...source.matchAll(/(late|part)?(\(\(\) =>)?\s*(typeof )?\bimport\([^)]*\)/g)]
        .filter(([, by, , type]) => !by && !type)
        .map(([found]) => `${path}: ${found} is for build.part`),
    );
  expect(Object.keys(files).length).toBeGreaterThan(100);
  expect(lost).toEqual([]);
});
