import type { Change, Detection, Episode, Story } from "../contract/types";

/** Times that went through JSON are equal within this. */
const SAME_S = 1e-6;

/** The alarm after which something was first named at `atS`, and its episode. */
export function isolationAt(
  { episodes }: Story,
  atS: number,
): { alarm: Detection; episode: Episode } | undefined {
  for (const episode of episodes) {
    const alarm = episode.detections.find(
      ({ isolated_at_s }) => isolated_at_s !== null && Math.abs(isolated_at_s - atS) <= SAME_S,
    );
    if (alarm) return { alarm, episode };
  }
  return undefined;
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
      named: [],
    }));
    return { ...each, onset_s, since_s: onset_s, changes: [], detections, finding: null };
  };
  const episodes = story.episodes
    .filter((each) => each.onset_s < fromS || each.detections.length > 0)
    .map((each) => (each.onset_s < fromS ? each : sealed(each)));
  const changes = story.changes.filter(before);
  const alarms = episodes.filter((each) => each.changes.length === 0).map((each) => each.onset_s);
  const change_times_s = [...changes.map((each) => each.at_s), ...alarms].sort((a, b) => a - b);
  return { episodes, changes, change_times_s, set_back: false };
}
