import type {
  Component,
  Diagnosis,
  EstimatorName,
  Position,
  RunEvent,
  RunPlan,
  RunState,
  Story,
} from "../contract/types";

/** JSON messages of /ws. */
export interface Hello {
  type: "hello";
  run: string;
  /** Id of its bench. */
  bench: string;
  state: RunState;
  epoch: number;
  first_index: number;
  next_index: number;
  rate_hz: number;
  channels: string[];
  estimators: EstimatorName[];
  nominal: { swa: number[]; sia: number[] };
  plan: RunPlan;
  positions: Record<Component, Position>;
  /** Run time at which the healthy rig is learnt; null when nothing has to wait for that. */
  learning_until_s: number | null;
  /** Values of the changes that wait for it. */
  waiting: Record<Component, number>;
  can_command: boolean;
  events: RunEvent[];
  verdict: Diagnosis | null;
  story: Story;
}

export interface Readout {
  name: EstimatorName;
  theta: (number | null)[];
  sigma: (number | null)[];
  condition: number | null;
  status: string;
  age: number;
}

export type ServerMessage =
  | Hello
  | ({ type: "event"; story?: Story } & RunEvent)
  | ({ type: "verdict"; story?: Story } & Diagnosis)
  | { type: "readout"; index: number; estimators: Readout[] }
  | {
      type: "ack";
      id: number;
      ok: boolean;
      waits_until_s?: number;
      error?: {
        code: string;
        message: string;
        reason?: string;
        parameters?: Record<string, string>;
      };
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
