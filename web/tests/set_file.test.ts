import { describe, expect, it } from "vitest";
import type { FaultSet } from "../src/contract/types";
import { readSet, setFile } from "../src/lab/set_file";

const set: FaultSet = {
  id: 3,
  name: "Lab 2",
  bench: "paper",
  course: 7,
  visible: false,
  version: 2,
  used: true,
  replaces: null,
  faults: [{ component: "R1", value: 56, at_s: 8 }],
  created_at: "2026-01-01T00:00:00Z",
};
const pool = { items: [{ component: "R1", values: [56], onset_from_s: 8 }], healthy_share: 0.2 };

describe("a fault set as a file", () => {
  it("has what another laboratory needs, and not whose it was", () => {
    const { name, bench, visible, faults } = set;
    expect(readSet(JSON.stringify(setFile(set)))).toEqual({ name, bench, visible, faults });
    const drawn = setFile({ ...set, pool });
    expect(readSet(JSON.stringify(drawn))).toEqual({ name, bench, pool });
  });
  it("is known from other files", () => {
    for (const text of [
      "",
      "[]",
      "null",
      "7",
      '{"name":"x"}',
      '{"name":1,"bench":"paper","faults":[]}',
    ]) {
      expect(readSet(text)).toBeNull();
    }
  });
});
