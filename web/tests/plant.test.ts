import { describe, expect, it } from "vitest";
import { beforeAfter, delayOf } from "../src/live/before_after";
import { ESTIMATORS } from "../src/live/estimators";
import { continuousModel, discreteModel } from "../src/plant/model";
import { publishedFor } from "../src/plant/published";
import { formatNumber, formatQuantity, formatWithSigma } from "../src/plant/quantity";
import { Slide } from "../src/stream/slide";
import { block } from "./support/blocks";

describe("the paper's Eq. 4", () => {
  it("gives the nominal parameters of the paper", () => {
    const nominal = continuousModel();
    expect(nominal.b0).toBeCloseTo(2.3935, 4);
    expect(nominal.b1).toBeCloseTo(0.0382, 4);
    expect(nominal.a1).toBeCloseTo(0.01807, 5);
  });
  it("gives the nominal discrete parameters of Eq. 9 without delay", () => {
    const discrete = discreteModel(continuousModel(), 0.01, 0);
    expect(discrete.b0d).toBeCloseTo(2.1146, 3);
    expect(discrete.b1d).toBeCloseTo(-1.0975, 3);
    expect(discrete.a1d).toBeCloseTo(-0.5751, 4);
  });
  it("predicts b1 = 0.0373 for R1 = 10 ohm, where the paper prints 0.0546", () => {
    expect(continuousModel({ R1: 10 }).b1).toBeCloseTo(0.0373, 4);
    expect(publishedFor("R1", 10)?.sia[1]).toBe(0.0546);
  });
  it("tells the sampling delay from the nominal discrete parameters", () => {
    for (const delay of [0.0045, 0.0095]) {
      const { b0d, b1d, a1d } = discreteModel(continuousModel(), 0.01, delay);
      expect(delayOf([b0d, b1d, a1d])).toBeCloseTo(delay, 9);
    }
  });
});

describe("before and after", () => {
  it("averages the healthy and the settled part only", () => {
    const slide = new Slide(2000, 0.01);
    const estimator = ESTIMATORS[1];
    if (!estimator) throw new Error("no estimator");
    // 1 before the fault at 10 s, 2 after it; nonsense while the window holds both
    slide.append(block(0, 2000, (_, index) => (index < 1000 ? 1 : index < 1000 + 99 ? 1e6 : 2)));
    const fault = { component: "R1", value: 100 } as const;
    const rows = beforeAfter(slide, estimator, 10, 20, fault, 0.0095);
    expect(rows.map((row) => row.before)).toEqual([1, 1, 1]);
    expect(rows.map((row) => row.after)).toEqual([2, 2, 2]);
    expect(rows[0]?.published).toBe(0.29);
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
