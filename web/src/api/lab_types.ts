import type { Schemas } from "./types";

/** The lab's JSON: accounts, queue, calendar, sessions, fault sets. Times are ISO 8601, UTC. */
export type RigClass = Schemas["RigClass"];
export type LabRig = Schemas["LabRig"];
export type RigHealth = Schemas["RigHealth"];
export type Availability = Schemas["Availability"];
export type Span = Pick<Availability["next_free"][number], "start" | "end">;

export type Ticket = Schemas["Ticket"];
export type Booking = Schemas["Booking"];
export type Session = Schemas["Session"];
export type LabEvent = Schemas["LabEvent"];

export type User = Schemas["User"];
export type Course = Schemas["Course"];
export type ApiKey = Schemas["ApiKey"];
/** With its secret, which is shown once. */
export type NewApiKey = Schemas["NewApiKey"];
export type AuditEntry = Schemas["AuditEntry"];

export type FaultSet = Schemas["FaultSet"];
export type Job = Schemas["Job"];
