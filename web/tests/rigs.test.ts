import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Schemas } from "../src/api/types";
import { Rigs } from "../src/shell/rigs.svelte";
import { ABOUT, rigOf } from "./support/bench";

/** Answers of the server, given when the test says. */
const asked = new Map<string, (answer: unknown) => void>();
const says = (path: string, items: unknown[]) => asked.get(path)?.({ items });
const settled = () => new Promise((resume) => setTimeout(resume));

beforeEach(() => {
  vi.stubGlobal("fetch", (address: string) => {
    return new Promise((resolve) => {
      asked.set(address.replace("/api/v1", ""), (answer) => resolve(Response.json(answer)));
    });
  });
});
afterEach(() => {
  asked.clear();
  vi.unstubAllGlobals();
});

function known(rigs: Rigs) {
  const state = { here: false };
  void rigs.known().then(() => {
    state.here = true;
  });
  return state;
}

describe("the bench of a run", () => {
  const other: Schemas["Bench"] = { ...ABOUT, id: "other" };

  it("does not wait for the rigs where there is one bench", async () => {
    const rigs = new Rigs();
    const state = known(rigs);
    expect([...asked.keys()].sort()).toEqual(["/benches", "/rig-classes", "/rigs"]); // at once
    says("/benches", [ABOUT]);
    await settled();
    expect(state.here).toBe(true);
    expect(rigs.benchOf(undefined)?.about.id).toBe("made-up");
  });

  it("is the rig's own where there are several, and is not shown before the rig is known", async () => {
    const rigs = new Rigs();
    const state = known(rigs);
    says("/benches", [other, ABOUT]);
    await settled();
    expect(state.here).toBe(false);
    says("/rig-classes", []);
    says("/rigs", [rigOf("sim-1", true)]);
    await settled();
    expect(state.here).toBe(true);
    expect(rigs.benchOf(rigs.find("sim-1"))?.about.id).toBe("made-up");
    expect(rigs.benchOf(rigs.find("gone"))?.about.id).toBe("other");
  });
});
