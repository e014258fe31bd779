import { call } from "../api/client";
import type { Policy } from "../contract/types";

/** The settings in the order of the page, each with its unit and the seconds in that unit. */
export const POLICY_ROWS = [
  { name: "session_min_s", unit: "min", seconds: 60 },
  { name: "session_max_s", unit: "min", seconds: 60 },
  { name: "extend_step_s", unit: "min", seconds: 60 },
  { name: "extended_max_s", unit: "h", seconds: 3600 },
  { name: "week_max_s", unit: "h", seconds: 3600 },
  { name: "booking_min_s", unit: "min", seconds: 60 },
  { name: "booking_max_s", unit: "min", seconds: 60 },
  { name: "booking_ahead_s", unit: "d", seconds: 86_400 },
  { name: "live_bookings_max", unit: "", seconds: 1 },
  { name: "grace_s", unit: "s", seconds: 1 },
  { name: "no_show_charge_s", unit: "min", seconds: 60 },
  { name: "offer_s", unit: "s", seconds: 1 },
  { name: "idle_s", unit: "s", seconds: 1 },
  { name: "idle_answer_s", unit: "s", seconds: 1 },
  { name: "waiting_jobs_max", unit: "", seconds: 1 },
] as const satisfies { name: Exclude<keyof Policy, "version">; unit: string; seconds: number }[];

/** The policy as last read: of the lab (""), and what holds for a rig class. */
class PolicyView {
  private read = $state.raw<Record<string, Policy>>({});

  /** Null before. */
  of(rigClass = ""): Policy | null {
    return this.read[rigClass] ?? null;
  }

  async load(rigClass = ""): Promise<void> {
    const found = await (rigClass
      ? call("GET /rig-classes/{rig_class}/policy", { rig_class: rigClass })
      : call("GET /policy"));
    this.read = { ...this.read, [rigClass]: found };
  }
}

export const policy = new PolicyView();
