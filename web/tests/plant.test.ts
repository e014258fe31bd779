import { describe, expect, it } from "vitest";
import { beforeAfter } from "../src/live/before_after";
import { ESTIMATORS, type EstimatorShape, settleS } from "../src/live/estimators";
import { formatNumber, formatQuantity, formatWithSigma } from "../src/plant/quantity";
import { Slide } from "../src/stream/slide";
import { bench, rigOf } from "./support/bench";
import { block } from "./support/blocks";

describe("a bench", () => {
  it("gives the values that can be set and the line of each", () => {
    expect(bench.values("R1")).toEqual([2, 100, 220]);
    expect(bench.line("R1", 220)).toBe("Do7");
    expect(bench.line("R1", Math.fround(100.000001))).toBe("Do8");
    expect(bench.line("R1", 97)).toBeNull(); // a simulator took it: no relay did
    expect(bench.nominal("R12")).toBe(4700);
    expect(bench.isNominal("R12", 10e3)).toBe(false);
    expect(bench.moves("R1")).toBe("b0, a1");
  });
  it("offers what only simulators can change on simulators only", () => {
    expect(bench.components(rigOf("sim", true))).toEqual(["R1", "R12", "J"]);
    expect(bench.components(rigOf("real", false))).toEqual(["R1", "R12"]);
    expect(bench.components(undefined)).toEqual(["R1", "R12"]);
  });
  it("knows what was published about a fault, and of no other", () => {
    expect(bench.published("R1", 100)?.swa).toEqual([0.1, 0.2, 0.3]);
    expect(bench.published("R1", 220)).toBeUndefined();
    expect(bench.published("J", 100)).toBeUndefined();
  });
  it("has no value for a component that it does not have", () => {
    expect(bench.nominal("B")).toBeNaN();
    expect(bench.isNominal("B", 1)).toBe(false);
    expect(bench.values("B")).toEqual([]);
  });
});

describe("an estimator", () => {
  it("settles after its window, in samples of the run's own period", () => {
    const [, swa100, , , sia100] = ESTIMATORS as [
      never,
      EstimatorShape,
      never,
      never,
      EstimatorShape,
    ];
    expect(settleS(swa100, 0.01)).toBeCloseTo(0.99, 12);
    expect(settleS(swa100, 0.02)).toBeCloseTo(1.98, 12);
    expect(settleS(sia100, 0.01)).toBeCloseTo(1.19, 12);
  });
});

describe("before and after", () => {
  it("averages the healthy and the settled part only", () => {
    const slide = new Slide(2000, 0.01);
    const estimator = ESTIMATORS[1];
    if (!estimator) throw new Error("no estimator");
    // 1 before the fault at 10 s, 2 after it; nonsense while the window holds both
    slide.append(block(0, 2000, (_, index) => (index < 1000 ? 1 : index < 1000 + 99 ? 1e6 : 2)));
    const rows = beforeAfter(slide, estimator, 10, 20, [3, 4, 5], undefined);
    expect(rows.map((row) => row.before)).toEqual([1, 1, 1]);
    expect(rows.map((row) => row.after)).toEqual([2, 2, 2]);
    expect(rows.map((row) => row.predicted)).toEqual([3, 4, 5]);
    expect(rows.map((row) => row.published)).toEqual([null, null, null]);
  });
});

describe("quantities", () => {
  it("are written as a person reads them", () => {
    expect(formatQuantity("R12", 5600)).toBe("5.6 kΩ");
    expect(formatQuantity("C8", 47e-12)).toBe("47 pF");
    expect(formatQuantity("C8", 1e-6)).toBe("1 µF");
    expect(formatQuantity("R1", 100)).toBe("100 Ω");
    expect(formatQuantity("J", 1.43e-6)).toBe("1.43·10⁻⁶ kg·m²");
  });
  it("carry the digits that their error leaves", () => {
    expect(formatWithSigma("R1", 99.62, 0.41)).toBe("99.6 ± 0.4 Ω");
    expect(formatWithSigma("R1", 99.62, 0.123)).toBe("99.62 ± 0.12 Ω");
    expect(formatWithSigma("R1", 99.62, null)).toBe("99.6 Ω");
    expect(formatWithSigma("B", 1.834e-5, 2e-7)).toBe("(1.83 ± 0.02)·10⁻⁵ Nm·s/rad");
    expect(formatWithSigma("R9", 56012, 130)).toBe("56.01 ± 0.13 kΩ");
  });
  it("show a missing number as a dash", () => {
    expect(formatNumber(Number.NaN)).toBe("–");
    expect(formatNumber(null)).toBe("–");
    expect(formatNumber(-0.5751)).toBe("−0.5751");
  });
});
