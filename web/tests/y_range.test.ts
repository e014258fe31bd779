import { describe, expect, it } from "vitest";
import { grown, narrowed } from "../src/charts/y_range";

describe("the range of a chart", () => {
  it("is what the signal uses of it where that is little", () => {
    const [from, to] = narrowed([-1e6, 1e6], 0, 3000);
    expect(from).toBeLessThanOrEqual(0);
    expect(to).toBeGreaterThanOrEqual(3000);
    expect(to - from).toBeLessThan(6000);
  });
  it("stays what the description says where the signal fills it", () => {
    expect(narrowed([0, 8], 2, 7)).toEqual([0, 8]);
  });
  it("grows where the signal leaves it, on that side only", () => {
    const [from, to] = grown([0, 10], 3, 25);
    expect(from).toBe(0);
    expect(to).toBeGreaterThanOrEqual(25);
  });
});
