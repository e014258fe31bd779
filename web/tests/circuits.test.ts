import { describe, expect, it } from "vitest";
import { circuitOf } from "../src/live/circuits/circuits";
import { Parts } from "../src/live/circuits/parts";
import type { Settings } from "../src/live/positions";
import { ABOUT, bench, DRIVER, driver } from "./support/bench";

const set = (actual: number): Settings[string] => ({
  actual,
  asked: null,
  state: "confirmed",
  reason: "",
  atS: null,
});

describe("the parts of a drawing", () => {
  it("are the bench's components, with where the rig says they are", () => {
    const parts = new Parts(bench, { R1: set(100) }, () => {});
    expect(parts.of("R1")).toMatchObject({ label: "R1", value: "100 Ω", state: "faulty" });
    expect(parts.of("R12")).toMatchObject({ value: "4.7 kΩ", state: "nominal" });
  });
  it("bear the name that the bench gives them", () => {
    const parts = new Parts(driver, { Disc: set(2.2e-5) }, () => {});
    expect(parts.of("J")).toMatchObject({ label: "Disc", component: "Disc", state: "faulty" });
  });
  it("are drawn without a switch where the bench knows no fault of them, and not where they are not", () => {
    const parts = new Parts(driver, {}, () => {});
    expect(parts.of("Ra")).toMatchObject({ label: "Ra", state: "fixed" });
    expect(parts.of("Ra")?.component).toBeUndefined();
    expect(parts.of("Ra")?.meaning).toContain("2.5 Ω");
    expect(parts.of("Rs")).toBeUndefined(); // no shunt: 0 ohm
    expect(parts.of("R12")).toBeUndefined(); // of another structure
  });
});

describe("a drawing", () => {
  it("of each structure has a place for every component of its bench", () => {
    for (const each of [bench, driver]) {
      const { places } = circuitOf(each.about.structure.name);
      expect(new Parts(each, {}, () => {}).without(places)).toEqual([]);
    }
    expect(circuitOf(ABOUT.structure.name)).not.toBe(circuitOf(DRIVER.structure.name));
  });
  it("of a structure that the page does not know has blocks, and no place", () => {
    const blocks = circuitOf("hydraulic");
    expect(blocks.places).toEqual([]);
    expect(new Parts(driver, {}, () => {}).without(["J"])).toEqual(["k"]);
  });
});
