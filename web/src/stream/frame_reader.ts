import { decodeFrame, FrameError, type SampleBlock } from "./frame";

const LENGTH_BYTES = 4;

/**
 * The frames of a recorded run: u32 little-endian length, frame, length, frame, .. They come in
 * pieces cut anywhere; what is not whole yet is kept, so no more than a frame and a piece is held.
 */
export class FrameReader {
  private rest = new Uint8Array(0);

  constructor(private readonly onBlock: (block: SampleBlock) => void) {}

  take(piece: Uint8Array): void {
    const bytes = this.rest.length > 0 ? joined(this.rest, piece) : piece;
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    let at = 0;
    while (at + LENGTH_BYTES <= bytes.length) {
      const length = view.getUint32(at, true);
      if (at + LENGTH_BYTES + length > bytes.length) break;
      this.onBlock(
        decodeFrame(bytes.buffer as ArrayBuffer, bytes.byteOffset + at + LENGTH_BYTES, length),
      );
      at += LENGTH_BYTES + length;
    }
    this.rest = bytes.slice(at);
  }

  end(): void {
    if (this.rest.length > 0) throw new FrameError("the recording ended inside a frame");
  }
}

function joined(a: Uint8Array, b: Uint8Array): Uint8Array<ArrayBuffer> {
  const all = new Uint8Array(a.length + b.length);
  all.set(a);
  all.set(b, a.length);
  return all;
}

export async function readFrames(
  response: Response,
  onBlock: (block: SampleBlock) => void,
): Promise<void> {
  const frames = new FrameReader(onBlock);
  const reader = response.body?.getReader();
  for (;;) {
    const { done, value } = (await reader?.read()) ?? { done: true };
    if (done || !value) break;
    frames.take(value);
  }
  frames.end();
}
