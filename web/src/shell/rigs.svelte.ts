import { api } from "../api/client";
import type { Component, Rig } from "../api/types";
import { MOTOR_COMPONENTS, RELAY_COMPONENTS } from "../plant/components";

/** The rigs of this server, fetched once and again on demand. */
class Rigs {
  list = $state.raw<Rig[]>([]);
  failure = $state("");
  loaded = $state(false);

  async load(): Promise<void> {
    try {
      const [list, classes] = await Promise.all([api.rigs(), api.rigClasses()]);
      const lab = new Map(classes.flatMap((each) => each.members).map((rig) => [rig.id, rig]));
      this.list = list.map((rig) => {
        const known = lab.get(rig.id);
        return known ? { ...rig, lab: known.status, reason: known.reason } : rig;
      });
      this.failure = "";
      this.loaded = true;
    } catch (error) {
      this.failure = error instanceof Error ? error.message : String(error);
    }
  }

  find(id: string | undefined): Rig | undefined {
    return this.list.find((rig) => rig.id === id);
  }

  /** Motor parameters can be changed on simulators only. */
  componentsOf(rig: Rig | undefined): Component[] {
    return rig?.capabilities.motor_faults
      ? [...RELAY_COMPONENTS, ...MOTOR_COMPONENTS]
      : RELAY_COMPONENTS;
  }
}

export const rigs = new Rigs();
