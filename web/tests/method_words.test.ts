import { describe, expect, it } from "vitest";
import type { MethodRun } from "../src/contract/types";
import { answerOf, knownAfterS } from "../src/live/method_words";
import { amplifier as bench } from "./support/bench";

const look = (
  after_s: number,
  answer: [string, number | null][],
  isolation: "cannot" | "not_yet" | "given" = "given",
): MethodRun["looks"][number] => ({
  after_s,
  isolation,
  identification: answer.some(([, value]) => value === null) ? "cannot" : "given",
  answer: answer.map(([component, value]) => ({ component, value, unit: "Ω" })),
});
const run = (...looks: MethodRun["looks"]): MethodRun => ({
  method: "ls",
  title: "",
  detected_at_s: 8,
  looks,
});

describe("what a method says", () => {
  it("is its last answer, with all that it cannot tell apart", () => {
    expect(answerOf(run(look(0.2, [["R9", 33e3]]), look(6, [["R12", 5600]])), bench)).toBe(
      "R12\u00a0=\u00a05.6\u00a0kΩ",
    );
    expect(
      answerOf(
        run(
          look(6, [
            ["R9", null],
            ["R12", null],
          ]),
        ),
        bench,
      ),
    ).toMatch(/^R9 or R12 \(/);
    expect(answerOf(run(look(6, [], "cannot")), bench)).toMatch(/cannot tell/);
    expect(answerOf(run(look(6, [], "not_yet")), bench)).toMatch(/no answer/);
    expect(answerOf(run(), bench)).toBe("");
  });

  it("is known from the first look that names the same as the last", () => {
    const looks = [look(0.2, [["R9", 1]]), look(0.5, [["R1", 90]]), look(6, [["R1", 56]])];
    expect(knownAfterS(run(...looks))).toBe(0.5);
    expect(knownAfterS(run(look(6, [], "not_yet")))).toBeNull();
    expect(knownAfterS(run())).toBeNull();
  });
});
