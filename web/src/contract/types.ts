import type { components } from "../../generated/api";

export type * from "../../generated/api";

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

/** The symbol of a component: which there are, the bench says (plant/bench). */
export type Component = string;
export type FaultKind = NonNullable<Schemas["Fault"]["kind"]>;
export type RunPlan = Schemas["Plan"];

export type ReferenceShape = NonNullable<Schemas["SpeedReference"]["shape"]>;
export type Controller = NonNullable<Schemas["SpeedControl"]["controller"]>;

export type RunState = Schemas["Run"]["state"];
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
/** What the server says of one stretch in which the rig is not nominal. */
export type Finding = Pick<
  Diagnosis,
  "verdict" | "detected_at_s" | "onset_s" | "group" | "candidates"
> &
  Partial<
    Pick<
      Diagnosis,
      "settled" | "reason" | "path" | "path_outcome" | "further" | "sensor" | "friction"
    >
  > & {
    ended_at_s?: number | null;
  };

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

/** The part of a calibration that the page shows. */
export interface StoredCalibration {
  run: string;
  at: string;
  calibration: {
    delta_s: number;
    used_um?: boolean;
    um_noise_v: number;
    ia_noise_a?: number;
    quantities: {
      name: string;
      unit: string;
      value: number | null;
      sigma: number | null;
      prior_value: number | null;
    }[];
  };
}
export type Span = Pick<Schemas["Availability"]["next_free"][number], "start" | "end">;
/** What another course or laboratory needs of a fault set. */
export type SetFile = Pick<Schemas["FaultSet"], "name" | "bench"> &
  Partial<Pick<Schemas["FaultSet"], "visible" | "faults" | "pool">>;
/** `Trial.truth`, read. */
export interface Truth {
  faults: Schemas["Fault"][];
  seed: number;
}
