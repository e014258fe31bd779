import { describe, expect, it } from "vitest";
import { grown, mediansOf, narrowed, spread } from "../src/charts/y_range";

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
  it("shows a flat estimate that lies just above it", () => {
    const flat = Float32Array.from({ length: 500 }, (_, k) => 0.1287 + ((k % 10) - 4) * 1e-4);
    const range: [number, number] = [0.08, 0.1287];
    const found = spread([flat], 0, flat.length, 0.96) as [number, number];
    const [from, to] = grown(range, ...found, mediansOf([flat], 0, flat.length));
    expect(from).toBe(0.08);
    expect(to).toBeGreaterThan(Math.max(...flat));
  });
  it("shows one signal of several that lies just above it", () => {
    const inside = Array.from({ length: 5 }, () => new Float32Array(400).fill(0.5));
    const outside = new Float32Array(400).fill(1.004);
    const columns = [...inside, outside];
    const found = spread(columns, 0, 400, 0.96) as [number, number];
    expect(grown([0, 1], ...found, mediansOf(columns, 0, 400))[1]).toBeGreaterThan(1.004);
  });
  it("stays where only the noise of a signal leaves it, and after it has grown", () => {
    expect(grown([0, 1], 0.2, 1.003, [0.9])).toEqual([0, 1]);
    const wider = grown([0, 1], 0.2, 1.05, [0.99]);
    expect(wider[1]).toBeGreaterThan(1.05);
    expect(grown(wider, 0.19, 1.06, [1.001])).toBe(wider);
  });
});
