import type { Trial } from "../contract/types";
import { account } from "../shell/account.svelte";

/** Of one's own, or of one's group. */
export const isMine = (trial: Trial) =>
  trial.members.some((each) => account.me.owner === `user:${each}`);
