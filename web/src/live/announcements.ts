import type { Diagnosis, RunEvent } from "../api/types";
import { t } from "../i18n/i18n.svelte";
import type { Bench } from "../plant/bench";
import { formatSeconds } from "../plant/quantity";

/** The announcement of an event for screen readers, if there is one. */
export function announcementOf(
  event: RunEvent,
  verdict: Diagnosis | null,
  bench: Bench,
  period: number,
): string | null {
  const component = event.component ?? "";
  const time = formatSeconds(event.index * period, period);
  const value = event.component ? bench.format(event.component, event.value) : "";
  switch (event.kind) {
    case "started":
      return t("say_started");
    case "relay_confirmed":
      return t("say_confirmed", { component, value, time });
    case "refused":
      return t("say_refused", { component, reason: event.text ?? "" });
    case "change_waits":
      return t("say_waits", { component, value });
    case "learnt":
      return t("event_learnt");
    case "not_learnt":
      return t("event_not_learnt");
    case "detected":
      return t("say_detected", { time });
    case "isolated":
      return t("say_isolated", { component: component || (verdict?.group ?? []).join(", "), time });
    case "trip":
      return t("say_trip", { reason: event.text ?? "" });
    default:
      return null;
  }
}
