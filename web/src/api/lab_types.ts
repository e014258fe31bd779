import type { Fault } from "./types";

/** The lab's JSON: accounts, queue, calendar, sessions, fault sets. Times are ISO 8601, UTC. */

export interface RigClass {
  id: string;
  rigs?: number;
  ready?: number;
  elastic?: boolean;
  waiting?: number;
  members?: LabRig[];
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
  disabled: boolean;
  version: number;
}

export interface AuditEntry {
  id: number;
  at: string;
  actor: string;
  verb: string;
  object: string;
  detail: string;
}

export interface Course {
  id: number;
  name: string;
  teaches: boolean;
  members: number;
}

export interface ApiKey {
  id: number;
  name: string;
  scopes: string[];
  expires_at: string;
  revoked: boolean;
  /** Shown once, when the key is made. */
  key?: string;
}

export interface Job {
  id: string;
  batch: string;
  name: string;
  state: string;
  run: string | null;
  error: string | null;
  progress: number;
  created_at: string;
}

/** A rig as the lab sees it: may it be handed out? */
export interface LabRig {
  id: string;
  rig_class: string;
  status: string;
  reason: string;
  wear_s: number;
}

export interface RigHealth extends LabRig {
  outages: (Span & { id: number; reason: string })[];
}

export interface LabEvent {
  id: number;
  topic: string;
  text: string;
  at?: string;
}
