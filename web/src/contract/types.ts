import type { components } from "../../generated/api";

/** The server's JSON. All types come from the contract (server/api/openapi.json). */
export type Schemas = components["schemas"];

export type Problem = Partial<Schemas["Problem"]>;
export type Me = Pick<Schemas["Me"], "role" | "name"> & Partial<Schemas["Me"]>;
export type Role = Me["role"];
/**
 * `lab` and `reason` come from the lab: whether the rig may be given to a user, and if not, why.
 */
export type Rig = Schemas["Rig"] & {
  lab?: Schemas["LabRig"]["status"];
  reason?: string;
};

export type Fault = Schemas["Fault"];
/** The symbol of a component: which there are, the bench says (plant/bench). */
export type Component = string;
export type FaultKind = NonNullable<Fault["kind"]>;
export type Excitation = Schemas["Excitation"];
export type RunRequest = Schemas["RunRequest"];
export type RunPlan = Schemas["Plan"];

export type SpeedControl = Schemas["SpeedControl"];
export type ReferenceShape = NonNullable<Schemas["SpeedReference"]["shape"]>;
export type Controller = NonNullable<SpeedControl["controller"]>;
export type RunControl = Schemas["RunControl"];
export type ControlQuality = Schemas["ControlQuality"];

export type Run = Schemas["Run"];
export type RunState = Run["state"];
export type RunEvent = Omit<Schemas["Event"], "type">;
export type EventKind = RunEvent["kind"];

/** What happened in a run and what is known of it: the server tells it, the page shows it. */
export type Story = Schemas["RunStory"];
export type Episode = Schemas["StoryEpisode"];
/** One alarm. */
export type Detection = Schemas["StoryDetection"];
export type Change = Schemas["ConfirmedChange"];

/** The object of `faultlab diagnose --json`, with the decision path. */
export type Diagnosis = Omit<Schemas["Diagnosis"], "calibration" | "fit_percent"> & {
  detector?: string;
  settled?: boolean;
  reason?: string;
  calibration?: { delta_s?: number | null } | null;
  fit_percent?: Record<string, number | null>;
  /** What was found of each stretch in which the rig was not nominal; not of a run that goes on. */
  episodes?: Finding[];
};
export type VerdictKind = Diagnosis["verdict"];
/** One question of the decision path, with the number that decided it. */
export type PathStep = Schemas["PathStep"];
export type Candidate = Schemas["Candidate"];
/** What the server says of one stretch in which the rig is not nominal. */
export type Finding = Pick<
  Diagnosis,
  "verdict" | "detected_at_s" | "onset_s" | "group" | "candidates"
> &
  Partial<
    Pick<Diagnosis, "settled" | "reason" | "path" | "path_outcome" | "further" | "sensor">
  > & {
    ended_at_s?: number | null;
  };

export type Recording = Schemas["Recording"];

export interface Page<T> {
  items: T[];
  next_cursor: string | null;
}

/** A part of the stream, which OpenAPI does not describe. */
export type EstimatorName =
  | "swa_50"
  | "swa_100"
  | "swa_200"
  | "sia_20_5"
  | "sia_100_20"
  | "sia_500_20";

export interface Position {
  value: number;
  state: string;
}
