import { t } from "../i18n/i18n.svelte";
import { standsIn } from "../i18n/rig_words";
import { benches } from "../shell/benches.svelte";
import { rigs } from "../shell/rigs.svelte";

/** What rigs of a class are, once they are known: the title of their bench. */
export function classWords(id: string): string {
  void rigs.once();
  const members = rigs.list.filter((rig) => rig.class === id);
  const title = benches.find(members[0]?.bench)?.title;
  if (!title) return id;
  return members.every(standsIn) ? t("class_simulated", { title }) : title;
}
