import type { Rig, Schemas } from "../../src/api/types";
import { Bench } from "../../src/plant/bench";
import { rigs } from "../../src/shell/rigs.svelte";

const values = (...pairs: [number, string | null][]) =>
  pairs.map(([value, line]) => ({ value, line }));

/** A bench that does not exist: what a test sees of it can only have come from here. */
export const ABOUT: Schemas["Bench"] = {
  id: "made-up",
  period_s: 0.02,
  healthy: { from_s: 1, to_s: 7 },
  run: { min_s: 2, max_s: 300 },
  components: [
    {
      symbol: "R1",
      unit: "ohm",
      switched_by: "relay",
      nominal: 2,
      values: values([2, "Do9"], [100, "Do8"], [220, "Do7"]),
      moves: ["b0", "a1"],
    },
    {
      symbol: "R12",
      unit: "ohm",
      switched_by: "relay",
      nominal: 4700,
      values: values([4700, "Do6"], [2000, "Do5"]),
      moves: ["b0"],
    },
    {
      symbol: "J",
      unit: "kg m^2",
      switched_by: "simulator",
      nominal: 3e-6,
      values: values([3e-6, null], [3e-5, null]),
      moves: ["a1"],
    },
  ],
  published: {
    source: "nowhere",
    faults: [
      {
        component: "R1",
        value: 100,
        swa: [0.1, 0.2, 0.3],
        sia: [1.1, 1.2, 1.3],
        identified: 90,
        tables: { swa: 1, sia: 2, identified: 3 },
      },
    ],
  },
};

export const bench = new Bench(ABOUT);

/** A rig of that bench. */
export function rigOf(id: string, motorFaults: boolean): Rig {
  return {
    id,
    class: "test",
    bench: "made-up",
    kind: "simulated",
    profile: "bench",
    state: "idle",
    epoch: 0,
    capabilities: {
      ua: true,
      ia: true,
      n: true,
      any_value: true,
      motor_faults: motorFaults,
      uc_v_min: 0,
      uc_v_max: 5,
      delta_s: 0.004,
      amplifier: { mode: "voltage", quadrants: 2 },
    },
    health: null,
    trip: null,
    link: null,
    calibration: null,
    loop: null,
  };
}

/** The page knows this bench and no rig. */
export function knowTheBench(): void {
  rigs.benches = [bench];
}
