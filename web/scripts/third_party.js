// Every npm package whose code is in the page has a row in deploy/THIRD_PARTY.md, with the licence that its package.json
// names; the build fails otherwise, also for a row of a package that is not in the page.
import { readFileSync } from "node:fs";

const PAGE = new URL("../../deploy/THIRD_PARTY.md", import.meta.url);

/** @returns {Map<string, string>} licence of each package in the table of the page */
export function listedPackages(text) {
  const section = text.split("\n## ").find((part) => part.startsWith("The page")) ?? "";
  return new Map(
    [...section.matchAll(/^\| `([^`]+)` \| ([^|]+) \|/gm)].map((row) => [row[1], row[2].trim()]),
  );
}

/** @returns {string[]} what is wrong; licences by package, of the page and of the list */
export function licenceFaults(bundled, listed) {
  return [
    ...[...bundled]
      .filter(([name, licence]) => listed.get(name) !== licence)
      .map(([name, licence]) => `${name} (${licence})`),
    ...[...listed.keys()]
      .filter((name) => !bundled.has(name))
      .map((name) => `${name}: not in the page`),
  ];
}

export function thirdParty() {
  return {
    name: "third-party",
    generateBundle(_options, bundle) {
      const bundled = new Map();
      for (const chunk of Object.values(bundle)) {
        for (const [id, { renderedLength }] of Object.entries(chunk.modules ?? {})) {
          const found = /^(.*\/node_modules\/((?:@[^/]+\/)?[^/]+))\//.exec(id);
          if (!found || renderedLength === 0) continue;
          bundled.set(
            found[2],
            JSON.parse(readFileSync(`${found[1]}/package.json`, "utf8")).license,
          );
        }
      }
      const faults = licenceFaults(bundled, listedPackages(readFileSync(PAGE, "utf8")));
      if (bundled.size === 0 || faults.length > 0)
        this.error(`deploy/THIRD_PARTY.md, "The page": ${faults.join(", ")}`);
    },
  };
}
