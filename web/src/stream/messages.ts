import type { Component, Diagnosis, RunEvent, RunPlan, RunState, Story } from "../contract/types";
import type { Refused } from "../i18n/words";

/** JSON messages of /ws. */
export interface Hello {
  type: "hello";
  state: RunState;
  epoch: number;
  nominal: { swa: number[]; sia: number[] };
  plan: RunPlan;
  positions: Record<Component, { value: number }>;
  /** Run time at which the healthy rig is learnt; null when nothing has to wait for that. */
  learning_until_s: number | null;
  /** Values of the changes that wait for it. */
  waiting: Record<Component, number>;
  can_command: boolean;
  events: RunEvent[];
  verdict: Diagnosis | null;
  story: Story;
}

export type ServerMessage =
  | Hello
  | ({ type: "event"; story?: Story } & RunEvent)
  | ({ type: "verdict"; story?: Story } & Diagnosis)
  | { type: "readout" }
  | {
      type: "ack";
      id: number;
      ok: boolean;
      error?: Refused;
    }
  | { type: "pong"; t: number; server_t: number }
  | { type: "error"; message: string }
  | { type: "dropped"; samples: number }
  | { type: "end"; state: RunState };

export type ClientMessage =
  | {
      type: "command";
      epoch: number;
      id: number;
      action: "set" | "nominal" | "stop";
      component?: Component;
      value?: number;
    }
  | { type: "ping"; t: number }
  | { type: "resume"; since: number };
