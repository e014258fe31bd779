import { describe, expect, it } from "vitest";
import type { Trial } from "../src/contract/types";
import { resultRows } from "../src/course/results";

const trial = (id: number, members: number[], points: number | null, state = "answered") =>
  ({ id, account: members[0], members, points, state }) as Trial;

describe("the results of a class", () => {
  const trials = [
    trial(1, [7], 40),
    trial(2, [8, 9], null, "open"),
    trial(3, [7], 90),
    trial(4, [7], 70),
    trial(5, [8, 9], 0),
    trial(6, [7], null, "open"),
    trial(7, [8, 9], null, "void"),
  ];
  const counting = (which: "best" | "last") =>
    resultRows(trials, [7, 8, 9, 10], which).map((each) => [each.members, each.counts?.id]);

  it("have a row for each student or group, with the answer that counts", () => {
    expect(counting("best")).toEqual([
      [[7], 3],
      [[8, 9], 5],
      [[10], undefined],
    ]);
    expect(counting("last")).toEqual([
      [[7], 4],
      [[8, 9], 5],
      [[10], undefined],
    ]);
    expect(resultRows([trial(6, [7], null)])[0]?.counts?.id).toBe(6);
  });
});
