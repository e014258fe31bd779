import type { Fault } from "./types";

/** The lab's JSON: accounts, queue, calendar, sessions, fault sets. Times are ISO 8601, UTC. */

export interface RigClass {
  id: string;
  rigs?: number;
  ready?: number;
  elastic?: boolean;
}

export interface Span {
  start: string;
  end: string;
}

export interface Availability {
  busy: (Span & { kind: "booking" | "mine" | "outage" })[];
  next_free: Span[];
}

export interface Ticket {
  id: string | number;
  rig_class: string;
  state: "waiting" | "offered" | "claimed" | "expired" | "left";
  place?: number;
  expected?: string | null;
  first_expected?: string | null;
  session?: string | number | null;
}

export interface Booking {
  id: string | number;
  rig_class: string;
  rig?: string;
  start: string;
  end: string;
  state: string;
  version: number;
  note?: string;
}

export interface Session {
  id: string | number;
  rig: string;
  rig_class: string;
  epoch: number;
  state: "held" | "active" | "closed";
  start: string;
  hard_end: string;
  claim_until?: string | null;
  still_there_until?: string | null;
  offered_to?: string | null;
  user?: string;
}

export interface FaultSet {
  id: string | number;
  name: string;
  course?: string | number | null;
  visible: boolean;
  version: number;
  faults: Fault[];
}

export interface User {
  id: string | number;
  login: string;
  name: string;
  role: string;
  disabled?: boolean;
}

export interface AuditEntry {
  id: string | number;
  at: string;
  who: string;
  what: string;
  object?: string;
  detail?: string;
}

export interface LabEvent {
  id: number;
  topic: string;
  text: string;
  at?: string;
}
