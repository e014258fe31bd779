import type { MethodRun } from "../contract/types";
import { t } from "../i18n/i18n.svelte";
import type { Bench } from "../plant/bench";

const unbroken = (text: string) => text.replaceAll(" ", "\u00a0");

/** "R1 = 100 Ω", "R9 or R12", or why there is none: what the method says at the end. */
export function answerOf(run: MethodRun, bench: Bench): string {
  const last = run.looks.at(-1);
  if (!last) return "";
  if (last.isolation === "cannot") return t("method_cannot_isolate");
  if (last.isolation === "not_yet" || last.answer.length === 0) return t("method_no_answer");
  const named = last.answer.map(({ component, value }) =>
    value === null ? component : unbroken(`${component} = ${bench.format(component, value)}`),
  );
  const said = named.join(` ${t("or")} `);
  return last.identification === "cannot" ? `${said} ${t("method_cannot_size")}` : said;
}

/** After the alarm: from when on it named what it names at the end; null if it names nothing. */
export function knownAfterS(run: MethodRun): number | null {
  const last = run.looks.at(-1);
  if (last?.isolation !== "given" || last.answer.length === 0) return null;
  const named = (look: MethodRun["looks"][number]) =>
    look.answer
      .map(({ component }) => component)
      .sort()
      .join();
  let from = run.looks.length - 1;
  while (from > 0 && named(run.looks[from - 1] as (typeof run.looks)[number]) === named(last))
    from--;
  return run.looks[from]?.after_s ?? null;
}
