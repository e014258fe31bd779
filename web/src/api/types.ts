/** The server's JSON, as its OpenAPI description (server/api/openapi.json) states it. */

export type Component = "R1" | "R9" | "R12" | "C8" | "Ra" | "J" | "B";
export type EstimatorName =
  | "swa_50"
  | "swa_100"
  | "swa_200"
  | "sia_20_5"
  | "sia_100_20"
  | "sia_500_20";

export interface Problem {
  type: string;
  title: string;
  status: number;
  detail?: string;
  field?: string;
}

export type Role = "guest" | "student" | "instructor" | "operator" | "admin" | "service";

export interface Me {
  role: Role;
  name: string;
  login?: string;
  csrf_token?: string;
}

export interface Rig {
  id: string;
  class: string;
  kind: "simulated" | "replay" | "remote" | "bench";
  profile?: string;
  state: string;
  in_use?: boolean;
  /** Why it is not ready, for people. */
  reason?: string;
  epoch: number;
  capabilities: {
    ua: boolean;
    ia: boolean;
    n: boolean;
    any_value: boolean;
    motor_faults: boolean;
    uc_v_min: number;
    uc_v_max: number;
  };
  nominal: Partial<Record<Component, number>>;
  relay_values: Partial<Record<Component, number[]>>;
}

export type Excitation =
  | { kind: "prbs"; low_v?: number; high_v?: number; clock_s?: number; seed?: number }
  | { kind: "step"; low_v?: number; high_v?: number; at_s?: number }
  | { kind: "multisine"; offset_v?: number; amplitude_v?: number; lines?: number; seed?: number }
  | {
      kind: "chirp";
      offset_v?: number;
      amplitude_v?: number;
      from_hz?: number;
      to_hz?: number;
    }
  | { kind: "samples"; uc_v: number[] };

export type FaultKind = "abrupt" | "drift" | "intermittent";

export interface Fault {
  component: Component;
  value: number;
  at_s: number;
  kind?: FaultKind;
  until_s?: number;
}

export interface RunRequest {
  rig?: string;
  excitation?: Excitation;
  period_s?: number;
  duration_s?: number;
  faults?: Fault[];
  seed?: number;
  recording?: string;
  /** A saved schedule of faults, instead of `faults`. */
  fault_set?: number;
  name?: string;
}

export interface RunPlan {
  rig?: string;
  excitation?: Excitation;
  period_s?: number;
  duration_s?: number;
  faults?: Fault[];
  seed?: number;
  recording?: string;
  name?: string;
}

export type RunState = "queued" | "running" | "finished" | "stopped" | "failed" | "interrupted";

export type EventKind =
  | "started"
  | "fault_commanded"
  | "relay_confirmed"
  | "refused"
  | "trip"
  | "overrun"
  | "gap"
  | "detected"
  | "isolated"
  | "returned"
  | "finished"
  | "stopped";

export interface RunEvent {
  kind: EventKind;
  index: number;
  t_s?: number;
  component?: Component;
  value?: number;
  text?: string;
}

export interface Run {
  id: string;
  name?: string;
  rig: string;
  state: RunState;
  epoch?: number;
  plan?: RunPlan;
  created_at?: string;
  period_s?: number;
  samples?: number;
  events?: RunEvent[];
  verdict?: string | Diagnosis | null;
}

export interface Page<T> {
  items: T[];
  next_cursor?: string | null;
}

export interface Candidate {
  component: Component;
  value: number;
  sigma: number | null;
  unit?: string;
  bound?: "<" | ">" | null;
  score?: number;
  margin?: number;
}

export interface PathStep {
  question: string;
  answer: boolean;
  value?: number | null;
  threshold?: number | null;
  leads_to?: string;
}

export type VerdictKind = "calibrating" | "nominal" | "fault" | "unknown_fault" | "not_excited";

/** The object of `faultlab diagnose --json`, with the decision path. */
export interface Diagnosis {
  verdict: VerdictKind;
  detected_at_s?: number | null;
  onset_s?: number | null;
  detector?: string;
  group?: Component[];
  candidates?: Candidate[];
  settled?: boolean;
  reason?: string;
  path?: PathStep[];
  fit_percent?: Record<string, number | null>;
  calibration?: { delta_s?: number | null } | null;
  estimates?: Record<string, unknown>;
  models?: Record<string, unknown>;
}

export interface Recording {
  id: string;
  name?: string;
  samples: number;
  period_s: number;
  channels?: string[];
  created_at?: string;
}

export interface Position {
  value: number;
  state: string;
}
