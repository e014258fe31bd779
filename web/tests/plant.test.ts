import { describe, expect, it } from "vitest";
import { fixed } from "../src/i18n/numbers";
import {
  formatNumber,
  formatQuantity,
  formatSeconds,
  formatSpan,
  formatTick,
  formatWithSigma,
} from "../src/i18n/quantity";
import { beforeAfter } from "../src/live/before_after";
import {
  ESTIMATORS,
  type EstimatorShape,
  parameterUnit,
  settleS,
  windowS,
} from "../src/live/estimators";
import { signalsOf } from "../src/plant/signals";
import { Slide } from "../src/stream/slide";
import { bench, DRIVER, driver, rigOf } from "./support/bench";
import { block } from "./support/blocks";

describe("a bench", () => {
  it("gives the values that can be set and the line of each", () => {
    expect(bench.values("R1")).toEqual([2, 100, 220]);
    expect(bench.line("R1", 220)).toBe("Do7");
    expect(bench.line("R1", Math.fround(100.000001))).toBe("Do8");
    expect(bench.line("R1", 97)).toBeNull(); // only a simulator accepts it; no relay connects it
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
  it("writes values in the unit that its description gives them", () => {
    expect(bench.format("R12", 5600)).toBe("5.6 kΩ");
    expect(driver.format("Disc", 2.2e-5)).toBe("2.2·10⁻⁵ kg·m²");
    expect(driver.change("k", 2)).toBe("k → 2 V/V");
    expect(driver.formatWithSigma("k", 2.013, 0.02)).toBe("2.01 ± 0.02 V/V");
  });
  it("finds the component of a parameter that has another name", () => {
    expect(driver.componentOf("J")).toBe("Disc");
    expect(driver.componentOf("k")).toBe("k");
    expect(driver.componentOf("Ra")).toBeUndefined();
  });
  it("offers the channels that it has, and that its rig has", () => {
    expect(bench.channels()).toEqual(["um", "ua", "ia", "n"]);
    expect(signalsOf(driver.channels()).map((signal) => signal.name)).toEqual(["uc", "ia", "n"]);
    const blind = rigOf("blind", true);
    blind.capabilities.ua = false;
    expect(bench.channels(blind)).toEqual(["um", "ia", "n"]);
    expect(driver.channels(blind)).toEqual(["ia", "n"]); // the rig is another bench by now
    expect(driver.channels(rigOf("own", true, DRIVER))).toEqual(["ia", "n"]);
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
    expect(windowS(swa100, 0.001)).toBeCloseTo(0.1, 12);
    expect(windowS(sia100, 0.1)).toBeCloseTo(12, 12);
  });
});

describe("the parameters of a model", () => {
  it("have the units that follow from what it predicts", () => {
    const units = (unit: "V" | "A") =>
      ["b0", "b1", "a1", "b0d", "b1d", "a1d"].map((name) => parameterUnit(name, unit));
    expect(units("V")).toEqual(["V/V", "s", "s", "V/V", "V/V", "V/V"]);
    expect(units("A")).toEqual(["A/V", "A·s/V", "s", "A/V", "A/V", "A/A"]);
  });
});

describe("before and after", () => {
  it("averages the healthy and the settled part only", () => {
    const slide = new Slide(2000, 0.01);
    const estimator = ESTIMATORS[1];
    if (!estimator) throw new Error("no estimator");
    // 1 before the fault at 10 s, 2 after it; another value while the window contains both
    slide.append(block(0, 2000, (_, index) => (index < 1000 ? 1 : index < 1000 + 99 ? 1e6 : 2)));
    const rows = beforeAfter(
      slide,
      estimator,
      { fromS: 0, atS: 10, toS: 20 },
      [3, 4, 5],
      undefined,
    );
    expect(rows.map((row) => row.before)).toEqual([1, 1, 1]);
    expect(rows.map((row) => row.after)).toEqual([2, 2, 2]);
    expect(rows.map((row) => row.predicted)).toEqual([3, 4, 5]);
    expect(rows.map((row) => row.published)).toEqual([null, null, null]);
  });
});

describe("quantities", () => {
  it("are written as a person reads them", () => {
    expect(formatQuantity("ohm", 5600)).toBe("5.6 kΩ");
    expect(formatQuantity("F", 47e-12)).toBe("47 pF");
    expect(formatQuantity("farad", 1e-6)).toBe("1 µF");
    expect(formatQuantity("ohm", 100)).toBe("100 Ω");
    expect(formatQuantity("kg m^2", 1.43e-6)).toBe("1.43·10⁻⁶ kg·m²");
    expect(formatQuantity("kg m2", 2)).toBe("2 kg·m²");
    expect(formatQuantity("V/(rad/s)", 0.0255)).toBe("25.5 mV·s/rad");
    expect(formatQuantity("V/V", 4)).toBe("4 V/V");
    expect(formatQuantity("furlong", 3)).toBe("3 furlong");
    expect(formatQuantity("", 3)).toBe("3");
    expect(formatQuantity("ohm", 0)).toBe("0 Ω");
    expect(formatQuantity("ohm", null)).toBe("–");
  });
  it("stand on a scale without a long unit", () => {
    expect(formatTick("ohm", 5600, 10)).toBe("5.6 kΩ");
    expect(formatTick("kg m^2", 1.43e-6, 1)).toBe("1.43·10⁻⁶");
    expect(formatTick("V/V", 3.6, 4)).toBe("3.6");
    expect(formatTick("V/(rad/s)", 0.0117, 0.0234)).toBe("11.7");
  });
  it("carry the digits that their error leaves", () => {
    expect(formatWithSigma("ohm", 99.62, 0.41)).toBe("99.6 ± 0.4 Ω");
    expect(formatWithSigma("ohm", 99.62, 0.123)).toBe("99.62 ± 0.12 Ω");
    expect(formatWithSigma("ohm", 99.62, null)).toBe("99.6 Ω");
    expect(formatWithSigma("Nm/(rad/s)", 1.834e-5, 2e-7)).toBe("(1.83 ± 0.02)·10⁻⁵ Nm·s/rad");
    expect(formatWithSigma("ohm", 56012, 130)).toBe("56.01 ± 0.13 kΩ");
    expect(formatWithSigma("V/V", 3.61, 0.02)).toBe("3.61 ± 0.02 V/V");
  });
  it("show a missing number as a dash", () => {
    expect(formatNumber(Number.NaN)).toBe("–");
    expect(formatNumber(null)).toBe("–");
    expect(formatNumber(0)).toBe("0");
    expect(fixed(-0.04, 1)).toBe("0.0");
    expect(fixed(-0.4, 0)).toBe("0");
    expect(fixed(-0.6, 0)).toBe("−1");
    expect(formatNumber(0.0787)).toBe("0.07870");
    expect(formatNumber(-0.5751)).toBe("−0.5751");
  });
  it("of time have the decimals of the period", () => {
    expect(formatSeconds(10, 0.01)).toBe("10.00");
    expect(formatSeconds(10.0024, 0.002)).toBe("10.002");
    expect(formatSeconds(10.5, 0.1)).toBe("10.50");
    expect(formatSpan(0.05)).toBe("50 ms");
    expect(formatSpan(1.2)).toBe("1.2 s");
  });
});
