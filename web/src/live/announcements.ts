import type { RunEvent, Story } from "../contract/types";
import { t } from "../i18n/i18n.svelte";
import { formatSeconds } from "../i18n/quantity";
import { eventWords } from "../i18n/rig_words";
import type { Bench } from "../plant/bench";
import { anyOf } from "./verdict_words";

const SAID = {
  first: "say_detected",
  further: "say_detected_further",
  return: "say_detected_return",
} as const;

/**
 * The announcement of an event for screen readers, if there is one. @param story  with this event
 */
export function announcementOf(
  event: RunEvent,
  story: Story,
  bench: Bench,
  period: number,
): string | null {
  const component = event.component ?? "";
  const time = formatSeconds(event.index * period, period);
  const value = event.component ? bench.format(event.component, event.value) : "";
  const detection = story.episodes.at(-1)?.detections.at(-1);
  switch (event.kind) {
    case "started":
      return t("say_started");
    case "relay_confirmed":
      return t("say_confirmed", { component, value, time });
    case "refused":
      return t("say_refused", { component, reason: eventWords(event) });
    case "change_waits":
      return t("say_waits", { component, value });
    case "learnt":
      return t("event_learnt");
    case "not_learnt":
      return t("event_not_learnt");
    case "detected":
      // a detection that was told before, or of an earlier episode, is not said again
      if (!detection || Math.abs(detection.detected_at_s - event.index * period) > period / 2)
        return null;
      return t(SAID[detection.of], { time });
    case "isolated":
      return t("say_isolated", { component: anyOf(event.components ?? []), time });
    case "returned":
      return t("say_returned", { time });
    case "compensated":
      return t("say_compensated", { component, value, time });
    case "compensation_ended":
      return t("say_compensation_ended", { component, reason: eventWords(event) });
    case "trip":
      return t("say_trip", { reason: eventWords(event) });
    default:
      return null;
  }
}
