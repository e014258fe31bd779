import { expect, test } from "vitest";
import { licenceFaults, listedPackages } from "../scripts/third_party.js";

const LIST =
  "\n## The programs\n| `boost` | BSL |\n## The page\n| package |\n|---|\n| `svelte` | MIT | by X |\n";

test("a package of the page without its row, or with another licence, is a fault", () => {
  const listed = listedPackages(LIST);
  expect([...listed]).toEqual([["svelte", "MIT"]]);
  expect(licenceFaults(new Map([["svelte", "MIT"]]), listed)).toEqual([]);
  expect(licenceFaults(new Map([["svelte", "GPL-3.0"]]), listed)).toEqual(["svelte (GPL-3.0)"]);
  expect(
    licenceFaults(
      new Map([
        ["svelte", "MIT"],
        ["left-pad", "WTFPL"],
      ]),
      listed,
    ),
  ).toEqual(["left-pad (WTFPL)"]);
});

test("a row of a package that is not in the page is a fault", () => {
  expect(licenceFaults(new Map(), listedPackages(LIST))).toEqual(["svelte: not in the page"]);
});
