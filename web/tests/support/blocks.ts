import { CHANNELS, type SampleBlock } from "../../src/stream/frame";

/** A block in which `value` gives the value of a channel at an index; all estimates are excited. */
export function block(
  firstIndex: number,
  count: number,
  value: (channel: number, index: number) => number,
  status = 0,
): SampleBlock {
  const values = new Float32Array(count * CHANNELS);
  for (let row = 0; row < count; row++) {
    for (let channel = 0; channel < CHANNELS; channel++) {
      values[row * CHANNELS + channel] = value(channel, firstIndex + row);
    }
  }
  return {
    count,
    firstIndex,
    serverTime: (firstIndex + count) * 0.01,
    values,
    status: new Uint8Array(count * 8).fill(status),
  };
}

/** Seeded numbers in [0, 1): mulberry32. */
export function random(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 4294967296;
  };
}
