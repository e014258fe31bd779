import { describe, expect, it } from "vitest";
import { studyPath } from "../src/learn/demonstrations.svelte";
import { GainPair } from "../src/live/circuits/gain_pair";
import { Bench } from "../src/plant/bench";
import { ABOUT, amplifier, bench as madeUp } from "./support/bench";

const pair = GainPair.of(amplifier) as GainPair;

describe("two parts with one gain", () => {
  it("are those of the inverting amplifier, and of no other structure", () => {
    expect([pair.input, pair.feedback]).toEqual(["R9", "R12"]);
    const other = { ...ABOUT, structure: { name: "motor-driver", title: "" } };
    expect(GainPair.of(new Bench(other))).toBeNull();
    expect(GainPair.of(madeUp)).toBeNull(); // it cannot change R9
  });
  it("have the nominal gain of the paper, and its smallest", () => {
    expect(pair.gain(10e3, 10e3)).toBeCloseTo(2.4, 12);
    expect(pair.gainMin).toBeCloseTo(1.2, 12);
  });
  it.each([
    [33e3, 5818],
    [56e3, 5071],
    [100e3, 4600],
  ])("R9 = %d looks like R12 = %d", (input, feedback) => {
    const gain = pair.gain(input, 10e3);
    expect(pair.feedbackFor(gain, 10e3)).toBeCloseTo(feedback, -0.5);
    expect(pair.inputFor(gain, 10e3)).toBeCloseTo(input, 5);
  });
  it("R9 explains no gain that is too small", () => {
    expect(pair.inputFor(pair.gain(10e3, 2e3), 10e3)).toBeNull();
  });
  it("the tap depends on one of them", () => {
    expect(pair.tapGain(10e3)).toBeCloseTo(0.4, 12);
    expect(pair.tapGain(33e3)).not.toBeCloseTo(0.4, 2);
  });
});

describe("the address of a study", () => {
  it("names what is changed and leaves out what is nominal", () => {
    expect(studyPath(madeUp, "", [["R12", 4700]])).toBe(`/benches/${ABOUT.id}/demonstration`);
    expect(
      studyPath(
        madeUp,
        "/estimates",
        [
          ["R1", 100],
          ["R12", 4700],
          ["J", 3e-5],
        ],
        { window: 50 },
      ),
    ).toBe(`/benches/${ABOUT.id}/demonstration/estimates?changes=R1%3A100%2CJ%3A0.00003&window=50`);
  });
});
