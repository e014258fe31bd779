import { describe, expect, it } from "vitest";
import type { RunEvent } from "../src/contract/types";
import { FaultCommands } from "../src/live/fault_commands.svelte";
import { PlanModel } from "../src/live/plan_model.svelte";
import { faultyComponents } from "../src/live/positions";
import type { ClientMessage, Hello } from "../src/stream/messages";
import { ABOUT, bench, know } from "./support/bench";
import { NOTHING } from "./support/stories";

const PERIOD = 0.01;

function hello(more: Partial<Hello> = {}): Hello {
  return {
    type: "hello",
    state: "running",
    epoch: 3,
    nominal: { swa: [], sia: [] },
    plan: {} as Hello["plan"],
    positions: { R1: { value: 2 } },
    learning_until_s: 5,
    waiting: {},
    can_command: true,
    events: [],
    verdict: null,
    story: NOTHING,
    ...more,
  };
}

function made(first = hello()) {
  const sent: ClientMessage[] = [];
  const faults = new FaultCommands(bench, (message) => sent.push(message) > 0);
  faults.take(first);
  const says = (kind: RunEvent["kind"], value?: number, component: RunEvent["component"] = "R1") =>
    faults.apply({ kind, index: 100, t_s: 1, component, value }, PERIOD);
  return { faults, sent, says };
}

describe("a change while the healthy rig is learnt", () => {
  it("waits as soon as the server says so, and the rig's value stays what it was", () => {
    const { faults, says } = made();
    faults.set("R1", 100);
    expect(faults.shown.R1?.state).toBe("commanded");
    says("change_waits", 100);
    expect(faults.shown.R1).toMatchObject({ state: "waiting", asked: 100, actual: 2 });
    expect(faults.settings.R1?.state).toBe("nominal");
    expect(faultyComponents(bench, faults.shown)).toEqual(["R1"]);
  });

  it("is replaced by the newest, and acts when the rig is told", () => {
    const { faults, says } = made();
    says("change_waits", 10);
    says("change_waits", 56);
    expect(faults.waiting).toEqual({ R1: 56 });
    says("fault_commanded", 10); // of the plan
    expect(faults.waiting).toEqual({ R1: 56 });
    says("fault_commanded", 56);
    expect(faults.shown.R1?.state).toBe("commanded");
    says("relay_confirmed", 56);
    expect(faults.shown.R1).toMatchObject({ state: "confirmed", actual: 56 });
  });

  it("is taken back by the nominal value", () => {
    const { faults, sent, says } = made();
    says("change_waits", 100);
    faults.set("R1", bench.nominal("R1"));
    expect(sent.at(-1)).toMatchObject({ action: "set", component: "R1", value: 2, epoch: 3 });
    says("change_dropped", 100);
    expect(faults.shown.R1?.state).toBe("nominal");
    expect(faults.waiting).toEqual({});
  });

  it("is known to who comes later, and to nobody after the run", () => {
    const { faults, says } = made(hello({ waiting: { R12: 2000 } }));
    expect(faults.shown.R12).toMatchObject({ state: "waiting", asked: 2000 });
    expect(faults.learningUntilS).toBe(5);
    faults.apply({ kind: "stopped", index: 200, t_s: 2 }, PERIOD);
    expect(faults.waiting).toEqual({});
    says("change_waits", 100);
    faults.take(hello({ learning_until_s: null }));
    expect(faults.waiting).toEqual({});
    expect(faults.learningUntilS).toBeNull();
  });

  it("says why the rig refused it in the end", () => {
    const { faults } = made();
    faults.apply({ kind: "change_waits", index: 100, t_s: 1, component: "R1", value: 100 }, PERIOD);
    faults.apply(
      { kind: "refused", index: 501, t_s: 5.01, component: "R1", value: 100, text: "not yours" },
      PERIOD,
    );
    expect(faults.shown.R1).toMatchObject({ state: "refused", reason: "not yours" });
  });
});

describe("a planned fault", () => {
  it("is told to be too early while the healthy rig is learnt", () => {
    know([ABOUT]);
    const plan = new PlanModel();
    expect(plan.tooEarly).toBe(false);
    plan.atS.value = 6.9; // the bench is learnt at 7 s
    expect(plan.tooEarly).toBe(true);
    plan.set("R1", bench.nominal("R1"));
    expect(plan.tooEarly).toBe(false);
  });
});
