import { readFileSync } from "node:fs";
import type { Rig, Schemas } from "../../src/contract/types";
import { Bench } from "../../src/plant/bench";
import { benches } from "../../src/shell/benches.svelte";
import { rigs } from "../../src/shell/rigs.svelte";

const values = (...pairs: [number, string | null][]) =>
  pairs.map(([value, line]) => ({ value, line }));

type About = Schemas["Bench"];
type Sheet = [symbol: string, unit: string, value: number];

const channel = (min: number, max: number) => ({ exists: true, min, max });
const none = { exists: false, min: null, max: null };
const parameters = (...sheet: Sheet[]): About["parameters"] =>
  sheet.map(([symbol, unit, value]) => ({ symbol, unit, value, meaning: `what ${symbol} is` }));
const ranges: About["estimate_ranges"] = {
  b0: [1, 3],
  b1: [0, 0.08],
  a1: [0, 0.1],
  b0d: [0, 3],
  b1d: [-1.5, 0.5],
  a1d: [-1, 0],
};

/** A bench that does not exist: what a test sees of it can only have come from here. */
export const ABOUT: About = {
  id: "made-up-0123456789ab",
  name: "made-up",
  title: "A made-up amplifier",
  structure: { name: "inverting-amplifier", title: "Amplifier, resistor and motor" },
  period_s: 0.02,
  delta_s: 0.0195,
  gear_ratio: 3.8,
  excitation: { kind: "prbs", low_v: 2, high_v: 3, clock_s: 0.04 },
  input: { min_v: 0, max_v: 5 },
  channels: { um: channel(0, 8), ua: channel(0, 9), ia: channel(-1, 1), n: channel(0, 900) },
  estimated: { channel: "um", unit: "V" },
  estimate_ranges: ranges,
  parameters: parameters(
    ["R1", "ohm", 2],
    ["Ra", "ohm", 7],
    ["La", "henry", 7e-4],
    ["J", "kg m^2", 3e-6],
    ["R9", "ohm", 9e3],
    ["R12", "ohm", 4700],
    ["C8", "farad", 33e-12],
  ),
  healthy: { from_s: 1, to_s: 7 },
  run: { min_s: 2, max_s: 300 },
  control: { reachable_rad_s: 400, low_rad_s: 130, high_rad_s: 150, hold_s: 2 },
  components: [
    {
      symbol: "R1",
      changes: "R1",
      unit: "ohm",
      meaning: "resistor in series",
      switched_by: "relay",
      nominal: 2,
      values: values([2, "Do9"], [100, "Do8"], [220, "Do7"]),
      moves: ["b0", "a1"],
    },
    {
      symbol: "R12",
      changes: "R12",
      unit: "ohm",
      meaning: "feedback resistor",
      switched_by: "relay",
      nominal: 4700,
      values: values([4700, "Do6"], [2000, "Do5"]),
      moves: ["b0"],
    },
    {
      symbol: "J",
      changes: "J",
      unit: "kg m^2",
      meaning: "moment of inertia",
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

/** Another one, of the other structure: 1 kHz, no voltage measured, no relay, nothing published. */
export const DRIVER: About = {
  id: "driver-ba9876543210",
  name: "driver",
  title: "A made-up driver",
  structure: { name: "motor-driver", title: "Driver and motor" },
  period_s: 0.001,
  delta_s: 0.0008,
  gear_ratio: 1,
  excitation: { kind: "multisine", offset_v: 1.5, amplitude_v: 0.5, lines: 30 },
  input: { min_v: -5, max_v: 5 },
  channels: {
    um: none,
    ua: none,
    ia: channel(-10, 10),
    n: channel(0, 3000),
  },
  estimated: { channel: "ia", unit: "A" },
  estimate_ranges: { ...ranges, b0: [0, 0.4] },
  parameters: parameters(
    ["Rs", "ohm", 0],
    ["Ra", "ohm", 2.5],
    ["La", "henry", 2e-4],
    ["Ke", "V/(rad/s)", 0.0234],
    ["KT", "Nm/A", 0.0234],
    ["J", "kg m^2", 1.1e-5],
    ["B", "Nm/(rad/s)", 5e-6],
    ["k", "V/V", 4],
  ),
  healthy: { from_s: 0.5, to_s: 3 },
  run: { min_s: 1, max_s: 600 },
  control: null,
  components: [
    {
      symbol: "Disc",
      changes: "J",
      unit: "kg m^2",
      meaning: "the disc on the shaft",
      switched_by: "simulator",
      nominal: 1.1e-5,
      values: values([1.1e-5, null], [5.5e-6, null], [2.2e-5, null]),
      moves: ["b1", "a1"],
    },
    {
      symbol: "k",
      changes: "k",
      unit: "V/V",
      meaning: "gain of the driver",
      switched_by: "simulator",
      nominal: 4,
      values: values([4, null], [2, null]),
      moves: ["b0", "b1"],
    },
  ],
  published: null,
};

export const bench = new Bench(ABOUT);
export const driver = new Bench(DRIVER);

/** The resistors of the paper's amplifier, from its description. */
const paper = readFileSync(new URL("../../../benches/paper.toml", import.meta.url), "utf8");
const printed = (symbol: string) => Number(new RegExp(`^${symbol} = (\\S+)`, "m").exec(paper)?.[1]);
const resistors = ["R9", "R10", "R12", "R14", "R15"].map((symbol) => ({
  symbol,
  unit: "ohm",
  value: printed(symbol),
  meaning: "",
}));
const gainParts = ["R9", "R12"].map((symbol) => ({
  ...ABOUT.components[0],
  symbol,
  changes: symbol,
  nominal: printed(symbol),
  values: [{ value: printed(symbol), line: null }],
})) as Schemas["Bench"]["components"];
/** An amplifier whose gain R9 and R12 set. */
export const amplifier = new Bench({ ...ABOUT, parameters: resistors, components: gainParts });

/** A rig, of the first of them if nothing else is said. */
export function rigOf(id: string, motorFaults: boolean, about: About = ABOUT): Rig {
  return {
    id,
    class: "test",
    bench: about.id,
    kind: "simulated",
    profile: "bench",
    state: "idle",
    epoch: 0,
    capabilities: {
      um: about.channels.um.exists,
      ua: about.channels.ua.exists,
      ia: about.channels.ia.exists,
      n: about.channels.n.exists,
      any_value: true,
      motor_faults: motorFaults,
      controls_speed: about.channels.n.exists,
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

/** The page knows these benches, the first is the server's first, and these rigs. */
export function know(abouts: About[], list: Rig[] = []): void {
  benches.list = abouts.map((about) => benches.take(about));
  rigs.list = list;
}
