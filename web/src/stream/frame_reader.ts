import { decodeFrame, FrameError, type SampleBlock } from "./frame";

const LENGTH_BYTES = 4;
const FRAME_BYTES_MAX = 1 << 22;

/**
 * Cuts a recorded run's bytes, which arrive in pieces of any size, into frames:
 * u32 little-endian length, frame, length, frame, ..
 */
export class FrameReader {
  private pending = new Uint8Array(0);

  push(piece: Uint8Array, onBlock: (block: SampleBlock) => void): void {
    let bytes = piece;
    if (this.pending.length > 0) {
      bytes = new Uint8Array(this.pending.length + piece.length);
      bytes.set(this.pending);
      bytes.set(piece, this.pending.length);
    }
    let at = 0;
    while (bytes.length - at >= LENGTH_BYTES) {
      const length = new DataView(bytes.buffer, bytes.byteOffset + at, LENGTH_BYTES).getUint32(
        0,
        true,
      );
      if (length > FRAME_BYTES_MAX) throw new FrameError(`frame of ${length} bytes announced`);
      if (bytes.length - at - LENGTH_BYTES < length) break;
      const frame = bytes.slice(at + LENGTH_BYTES, at + LENGTH_BYTES + length);
      onBlock(decodeFrame(frame.buffer));
      at += LENGTH_BYTES + length;
    }
    this.pending = bytes.slice(at);
  }

  /** Throws if the bytes ended inside a frame. */
  end(): void {
    if (this.pending.length > 0) throw new FrameError("the recording ended inside a frame");
  }
}

export async function readFrames(
  response: Response,
  onBlock: (block: SampleBlock) => void,
): Promise<void> {
  const reader = response.body?.getReader();
  if (!reader) return;
  const frames = new FrameReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    frames.push(value, onBlock);
  }
  frames.end();
}
