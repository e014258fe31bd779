import { decodeFrame, FrameError, type SampleBlock } from "./frame";

const LENGTH_BYTES = 4;

/** The frames of a recorded run: u32 little-endian length, frame, length, frame, .. */
export function decodeFrames(bytes: ArrayBuffer, onBlock: (block: SampleBlock) => void): void {
  const view = new DataView(bytes);
  let at = 0;
  while (at < bytes.byteLength) {
    if (bytes.byteLength - at < LENGTH_BYTES)
      throw new FrameError("the recording ended in a length");
    const length = view.getUint32(at, true);
    onBlock(decodeFrame(bytes, at + LENGTH_BYTES, length));
    at += LENGTH_BYTES + length;
  }
}

export async function readFrames(
  response: Response,
  onBlock: (block: SampleBlock) => void,
): Promise<void> {
  decodeFrames(await response.arrayBuffer(), onBlock);
}
