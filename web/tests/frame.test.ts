import { describe, expect, it } from "vitest";
import { CHANNELS, decodeFrame, encodeFrame, FrameError } from "../src/stream/frame";
import { FrameReader, readFrames } from "../src/stream/frame_reader";
import { block, random } from "./support/blocks";

describe("frame decoder", () => {
  it("reads what the encoder wrote, at any alignment", () => {
    const written = block(1234, 5, (channel, index) => channel * 1000 + index);
    const bytes = new Uint8Array(encodeFrame(written));
    for (let shift = 0; shift < 4; shift++) {
      const padded = new Uint8Array(bytes.length + shift);
      padded.set(bytes, shift);
      const read = decodeFrame(padded.buffer, shift);
      expect(read.firstIndex).toBe(1234);
      expect(read.count).toBe(5);
      expect(read.serverTime).toBe(written.serverTime);
      expect([...read.values]).toEqual([...written.values]);
      expect([...read.status]).toEqual([...written.status]);
    }
  });

  it("is 516 bytes for five samples, as the contract says", () => {
    expect(encodeFrame(block(0, 5, () => 0)).byteLength).toBe(16 + 5 * CHANNELS * 4 + 5 * 8);
  });

  it("refuses every truncation of a frame and every extension", () => {
    const bytes = encodeFrame(block(0, 3, () => 1));
    for (let length = 0; length < bytes.byteLength; length++) {
      expect(() => decodeFrame(bytes.slice(0, length))).toThrow(FrameError);
    }
    const longer = new Uint8Array(bytes.byteLength + 1);
    longer.set(new Uint8Array(bytes));
    expect(() => decodeFrame(longer.buffer)).toThrow(FrameError);
  });

  it("refuses or reads random bytes, and never breaks otherwise", () => {
    const next = random(7);
    for (let round = 0; round < 3000; round++) {
      const bytes = new Uint8Array(Math.floor(next() * 300));
      for (let at = 0; at < bytes.length; at++) bytes[at] = Math.floor(next() * 256);
      if (round % 2 === 0 && bytes.length > 4) bytes.set([1, 1, Math.floor(next() * 4), 0]);
      try {
        const read = decodeFrame(bytes.buffer);
        expect(read.values.length).toBe(read.count * CHANNELS);
      } catch (error) {
        expect(error).toBeInstanceOf(FrameError);
      }
    }
  });
});

describe("recorded frames", () => {
  function recorded(frames: ArrayBuffer[]): Uint8Array {
    const parts = frames.flatMap((frame) => {
      const length = new Uint8Array(4);
      new DataView(length.buffer).setUint32(0, frame.byteLength, true);
      return [length, new Uint8Array(frame)];
    });
    const all = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
    let at = 0;
    for (const part of parts) {
      all.set(part, at);
      at += part.length;
    }
    return all;
  }
  const frames = [0, 5, 10].map((first) => encodeFrame(block(first, 5, (c, i) => c + i)));
  const bytes = recorded(frames);

  function read(...pieces: Uint8Array[]): number[] {
    const firsts: number[] = [];
    const reader = new FrameReader((one) => {
      expect(one.values[1]).toBe(one.firstIndex + 1);
      firsts.push(one.firstIndex);
    });
    for (const piece of pieces) reader.take(piece);
    reader.end();
    return firsts;
  }

  it("are read one after the other, in pieces cut anywhere", () => {
    expect(read(bytes)).toEqual([0, 5, 10]);
    for (let cut = 0; cut <= bytes.length; cut++) {
      expect(read(bytes.subarray(0, cut), bytes.subarray(cut))).toEqual([0, 5, 10]);
    }
    expect(read(...[...bytes].map((byte) => Uint8Array.of(byte)))).toEqual([0, 5, 10]);
  });

  it("are read as they come", async () => {
    const firsts: number[] = [];
    const answer = new Response(
      new ReadableStream({
        start(controller) {
          for (let at = 0; at < bytes.length; at += 100) {
            controller.enqueue(bytes.slice(at, at + 100));
          }
          controller.close();
        },
      }),
    );
    await readFrames(answer, (one) => firsts.push(one.firstIndex));
    expect(firsts).toEqual([0, 5, 10]);
  });

  it("are refused when they end anywhere inside a frame or a length", () => {
    const whole = bytes.length / frames.length;
    for (let length = 1; length < bytes.length; length++) {
      if (length % whole === 0) continue;
      expect(() => read(bytes.subarray(0, length)), String(length)).toThrow(FrameError);
    }
  });
});
