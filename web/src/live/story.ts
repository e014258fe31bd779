import type { Change, Episode, Story } from "../api/types";

/** Times that went through JSON are equal within this. */
const SAME_S = 1e-6;

/** The episode of an alarm after which something was named at `atS`. */
export function isolationAt({ episodes }: Story, atS: number): Episode | undefined {
  return episodes.find((each) =>
    each.detections.some((one) => Math.abs((one.isolated_at_s ?? Number.NaN) - atS) <= SAME_S),
  );
}

/** Without what tells which part was changed from `fromS` on. */
export function sealedFrom(story: Story, fromS: number): Story {
  const before = (each: Change) => each.at_s < fromS;
  const sealed = (each: Episode): Episode => {
    const [alarm] = each.detections;
    const onset_s = alarm?.detected_at_s ?? each.onset_s;
    const detections = each.detections.map((one) => ({
      ...one,
      delay_s: null,
      isolated_at_s: null,
    }));
    return { ...each, onset_s, since_s: onset_s, changes: [], detections, finding: null };
  };
  const episodes = story.episodes
    .filter((each) => each.onset_s < fromS || each.detections.length > 0)
    .map((each) => (each.onset_s < fromS ? each : sealed(each)));
  const changes = story.changes.filter(before);
  const alarms = episodes.filter((each) => each.changes.length === 0).map((each) => each.onset_s);
  const change_times_s = [...changes.map((each) => each.at_s), ...alarms].sort((a, b) => a - b);
  return { episodes, changes, change_times_s };
}
