import type { FaultKind, FaultPool } from "../contract/types";
import { localInput } from "../i18n/times";

export interface PoolTimes {
  fromS: number;
  toS: number;
  healthyShare: number;
  /** Abrupt where absent. */
  kind?: FaultKind;
  /** Of a drift or an intermittent fault. */
  lastsS?: number;
}

/** One item for each part: every value it can have is as likely as another, and so is every part. */
export function poolOf(
  parts: { component: string; values: number[] }[],
  { fromS, toS, healthyShare, kind, lastsS }: PoolTimes,
): FaultPool {
  const items = parts.map(({ component, values }) => ({
    component,
    values,
    onset_from_s: fromS,
    onset_to_s: toS,
    ...(kind === undefined ? {} : { kind, lasts_s: lastsS }),
  }));
  return { items, healthy_share: healthyShare };
}

const DAYS = 7;

/** A week from now, at the end of the day. */
export function duePreset(now: Date): string {
  return localInput(new Date(now.getFullYear(), now.getMonth(), now.getDate() + DAYS, 23, 59));
}
