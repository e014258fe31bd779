import type { EventKind, RunEvent, Story } from "../contract/types";
import type { Key } from "../i18n/catalogue";
import { t } from "../i18n/i18n.svelte";
import { formatSeconds } from "../i18n/quantity";
import { eventWords } from "../i18n/rig_words";
import type { Bench } from "../plant/bench";
import { anyOf } from "./verdict_words";

const DETECTED = {
  first: "say_detected",
  further: "say_detected_further",
  return: "say_detected_return",
} as const;
const SAID: Partial<Record<EventKind, Key>> = {
  started: "say_started",
  relay_confirmed: "say_confirmed",
  refused: "say_refused",
  change_waits: "say_waits",
  learnt: "event_learnt",
  not_learnt: "event_not_learnt",
  isolated: "say_isolated",
  returned: "say_returned",
  compensated: "say_compensated",
  compensation_ended: "say_compensation_ended",
  trip: "say_trip",
};

/**
 * The announcement of an event for screen readers, if there is one. @param story  with this event
 */
export function announcementOf(
  event: RunEvent,
  story: Story,
  bench: Bench,
  period: number,
): string | null {
  const time = formatSeconds(event.index * period, period);
  if (event.kind === "detected") {
    const detection = story.episodes.at(-1)?.detections.at(-1);
    // a detection that was told before, or of an earlier episode, is not said again
    const now = detection && Math.abs(detection.detected_at_s - event.index * period) <= period / 2;
    return now ? t(DETECTED[detection.of], { time }) : null;
  }
  const key = SAID[event.kind];
  const component = event.component ?? anyOf(event.components ?? []);
  const value = event.component ? bench.format(event.component, event.value) : "";
  return key ? t(key, { component, value, time, reason: eventWords(event) }) : null;
}
