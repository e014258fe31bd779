import type { Bench, ChannelName } from "./bench";

/** A measured signal, and uc, which every bench has. */
export type SignalName = "uc" | ChannelName;

interface Signal {
  name: SignalName;
  /** Among the stream's channels. */
  channel: number;
  /** As charts write it. */
  label: string;
  unit: string;
}

export const SIGNALS: Record<SignalName, Signal> = {
  uc: { name: "uc", channel: 0, label: "Uc", unit: "V" },
  um: { name: "um", channel: 1, label: "Um", unit: "V" },
  ua: { name: "ua", channel: 2, label: "Ua", unit: "V" },
  ia: { name: "ia", channel: 3, label: "Ia", unit: "A" },
  n: { name: "n", channel: 4, label: "n", unit: "rpm" },
};

export function signalsOf(measured: ChannelName[]): Signal[] {
  return [SIGNALS.uc, ...measured.map((name) => SIGNALS[name])];
}

/** What the estimators' models predict: the signal to look at first. */
export function mainSignal(bench: Bench): Signal {
  return SIGNALS[bench.about.estimated.channel];
}
