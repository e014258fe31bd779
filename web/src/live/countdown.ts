import type { Fault } from "../contract/types";
import { t } from "../i18n/i18n.svelte";
import type { Bench } from "../plant/bench";
import { announcer } from "../shell/announcer.svelte";
import type { Injection } from "./fault_commands.svelte";

const COUNTDOWN_S = 3;

/** Announces a planned fault once, three seconds before it. */
export class Countdown {
  private readonly said = new Set<string>();

  at(elapsedS: number, bench: Bench, faults: readonly Fault[], injection: Injection | null): void {
    const planned = faults.map(({ component, value, at_s = 0 }) => ({
      component,
      value,
      atS: at_s,
    }));
    for (const fault of injection ? [...planned, injection] : planned) {
      const left = fault.atS - elapsedS;
      const key = `${fault.component}@${fault.atS}`;
      if (left <= 0 || left > COUNTDOWN_S || this.said.has(key)) continue;
      this.said.add(key);
      const value = bench.format(fault.component, fault.value);
      announcer.say("countdown", t("say_countdown", { component: fault.component, value }));
    }
  }
}
