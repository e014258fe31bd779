import { describe, expect, it } from "vitest";
import type { Trial } from "../src/contract/types";
import { resultRows } from "../src/course/results";

const trial = (id: number, members: number[], points: number | null) =>
  ({ id, account: members[0], members, points }) as Trial;

describe("the results of a class", () => {
  it("have a row for each student or group, with the best of their points", () => {
    const rows = resultRows([
      trial(1, [7], 40),
      trial(2, [8, 9], null),
      trial(3, [7], 90),
      trial(4, [7], null),
      trial(5, [8, 9], 0),
    ]);
    expect(rows.map((each) => [each.members, each.trials.map(({ id }) => id), each.best])).toEqual([
      [[7], [1, 3, 4], 90],
      [[8, 9], [2, 5], 0],
    ]);
    expect(resultRows([trial(6, [7], null)])[0]?.best).toBeNull();
  });
});
