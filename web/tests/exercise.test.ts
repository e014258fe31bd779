import { afterEach, describe, expect, it, vi } from "vitest";
import {
  drawFault,
  equivalentTo,
  faultsOf,
  firstFault,
  gradeOf,
  hiddenFault,
  PATIENCE_S,
  partsOf,
  type Seen,
  STAGES,
  stageOf,
  stepOf,
} from "../src/learn/exercise";
import { ExerciseRun } from "../src/learn/exercise_run.svelte";
import { bench } from "./support/bench";
import { change } from "./support/stories";

const broken = change("R1", 220, 8);
const back = change("R1", 2, 14);
const hidden = change("R12", 2000, 20);
const seen = (more: Partial<Seen>): Seen => ({
  running: true,
  learnt: "yes",
  changes: [],
  elapsedS: 10,
  verdict: "other",
  settleS: 2,
  answered: false,
  ...more,
});

describe("the step of the exercise", () => {
  it("follows what happens in the run", () => {
    const story: [Partial<Seen>, string][] = [
      [{ learnt: "no", elapsedS: 3 }, "learning"],
      [{ verdict: "nominal" }, "break"],
      [{ changes: [broken], elapsedS: 8.2 }, "diagnosing"],
      [{ changes: [broken], elapsedS: 9, verdict: "named" }, "named"],
      [{ changes: [broken, back], elapsedS: 14.1, verdict: "named" }, "returning"],
      [{ changes: [broken, back], elapsedS: 15, verdict: "nominal" }, "hide"],
      [{ changes: [broken, back, hidden], elapsedS: 21 }, "settling"],
      [{ changes: [broken, back, hidden], elapsedS: 22.1 }, "answer"],
      [{ changes: [broken, back, hidden], elapsedS: 30, answered: true }, "result"],
    ];
    for (const [what, step] of story) expect(stepOf(seen(what)), step).toBe(step);
  });
  it("goes on when the diagnosis names nothing", () => {
    expect(stepOf(seen({ changes: [broken], elapsedS: 8 + PATIENCE_S }))).toBe("diagnosing");
    expect(stepOf(seen({ changes: [broken], elapsedS: 8.1 + PATIENCE_S }))).toBe("named");
    const returned = { changes: [broken, back], elapsedS: 14.1 + PATIENCE_S };
    expect(stepOf(seen(returned))).toBe("hide");
  });
  it("is over when the run ends too soon, or the rig cannot be learnt", () => {
    expect(stepOf(seen({ running: false }))).toBe("over");
    expect(stepOf(seen({ learnt: "refused" }))).toBe("over");
    const unsettled = { running: false, changes: [broken, back, hidden], elapsedS: 21 };
    expect(stepOf(seen(unsettled))).toBe("over");
  });
  it("can be answered after the run", () => {
    const ended = { running: false, changes: [broken, back, hidden], elapsedS: 40 };
    expect(stepOf(seen(ended))).toBe("answer");
    expect(stepOf(seen({ ...ended, answered: true }))).toBe("result");
  });
  it("belongs to one stage", () => {
    expect(STAGES.flat()).toHaveLength(new Set(STAGES.flat()).size);
    expect(stageOf("start")).toBe(1);
    expect(stageOf("result")).toBe(STAGES.length);
    expect(stageOf("over")).toBe(0);
  });
});

describe("the hidden fault", () => {
  it("is the first after the return to nominal", () => {
    expect(hiddenFault([broken])).toBeUndefined();
    expect(hiddenFault([broken, back])).toBeUndefined();
    expect(hiddenFault([broken, back, hidden])).toBe(hidden);
    const again = change("R1", 100, 25);
    expect(hiddenFault([broken, back, hidden, again])).toBe(hidden);
  });
  it("is one that relays can switch, and not the one that was shown", () => {
    expect(partsOf(bench)).not.toContain("J");
    const first = firstFault(bench);
    expect(first).toEqual({ component: "R1", value: 220 });
    const drawn = [0, 0.3, 0.6, 0.999].map((chance) => drawFault(bench, first, chance));
    for (const fault of drawn) {
      expect(faultsOf(bench)).toContainEqual(fault);
      expect(fault).not.toEqual(first);
    }
    expect(new Set(drawn.map((each) => JSON.stringify(each))).size).toBeGreaterThan(1);
  });
});

describe("the answer", () => {
  const truth = { component: "R12", value: 2000 };
  const given = { value: 3e4, given: true };
  it.each([
    [{ component: "R12", value: 2000 }, [], given, "exact"],
    [{ component: "R12", value: 3300 }, ["R12"], given, "part"],
    [{ component: "R9", value: 3e4 }, ["R12", "R9"], given, "group"],
    [{ component: "R9", value: 3e3 }, ["R12", "R9"], { ...given, given: false }, "other_value"],
    [{ component: "R9", value: 3e4 }, ["R12", "R9"], null, "wrong"],
    [{ component: "R9", value: 3e4 }, ["R12"], given, "wrong"],
    [{ component: "R1", value: 100 }, ["R12", "R9"], given, "wrong"],
  ] as const)("%o is judged with the group %o and %o: %s", (answer, group, equivalent, grade) => {
    expect(gradeOf(answer, truth, [...group], equivalent)).toBe(grade);
  });

  it("of another part is judged by what the diagnosis found", () => {
    const found = [{ component: "J", value: 3e-5 }];
    const say = (value: number) => equivalentTo({ component: "J", value }, found);
    expect(say(3.05e-5)).toEqual({ value: 3e-5, given: true });
    expect(say(6e-5)?.given).toBe(false);
    expect(equivalentTo({ component: "R1", value: 1 }, found)).toBeNull();
  });
});

describe("an exercise that is left", () => {
  afterEach(() => void vi.unstubAllGlobals());
  const sentBy = (prepare: (run: ExerciseRun) => void) => {
    const sent: unknown[] = [];
    vi.stubGlobal("fetch", async (path: string, init: RequestInit = {}) => {
      sent.push([init.method, path, init.keepalive]);
      return Response.json({});
    });
    const run = new ExerciseRun("run 1");
    prepare(run);
    run.leave();
    return sent;
  };
  it("gives its simulator back, also when the page goes away", () => {
    const running = sentBy((run) => {
      run.phase = "live";
    });
    expect(running).toEqual([["POST", "/api/v1/runs/run%201/stop", true]]);
  });
  it("leaves a run alone that has ended", () => {
    const ended = sentBy((run) => {
      run.phase = "review";
      run.state = "finished";
    });
    expect(ended).toEqual([]);
  });
});
