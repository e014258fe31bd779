import type { Schemas } from "./types";

/** The lab's JSON: accounts, queue, calendar, sessions, fault sets. Times are ISO 8601, UTC. */
export type RigClass = Schemas["RigClass"];
export type LabRig = Schemas["LabRig"];
export type RigHealth = Schemas["RigHealth"];
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
export type Availability = Schemas["Availability"];
export type Policy = Schemas["Policy"];
export type Span = Pick<Availability["next_free"][number], "start" | "end">;

export type Ticket = Schemas["Ticket"];
export type Booking = Schemas["Booking"];
export type Session = Schemas["Session"];
export type LabEvent = Schemas["LabEvent"];

export type User = Schemas["User"];
export type Course = Schemas["Course"];
export type Enrolled = Schemas["Enrolled"];
export type Invitation = Schemas["Invitation"];
export type ApiKey = Schemas["ApiKey"];
export type Identity = Schemas["Identity"];
export type Provider = Schemas["Provider"];
/** With its secret, which is shown only once. */
export type NewApiKey = Schemas["NewApiKey"];
export type AuditEntry = Schemas["AuditEntry"];

export type FaultSet = Schemas["FaultSet"];
export type Isolability = Schemas["Isolability"];
export type Job = Schemas["Job"];
/** What all methods have said of one recording so far. */
export type MethodsCompared = Schemas["MethodsCompared"];
export type MethodRun = Schemas["MethodRun"];
export type MethodName = MethodRun["method"];

/** What another course or laboratory needs of a fault set. */
export type SetFile = Pick<FaultSet, "name" | "bench"> &
  Partial<Pick<FaultSet, "visible" | "faults" | "pool">>;
