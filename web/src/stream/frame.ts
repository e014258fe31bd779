/**
 * One binary message of the live stream, little endian:
 *   u8 version, u8 type, u16 n, u32 first_index, f64 t_server, n x 23 f32, n x 8 u8
 * The 23 numbers of a sample are uc, um, ua, ia, n and three parameters for each of six estimators;
 * the 8 bytes are the six estimators' statuses and two of padding. NaN means "not measured".
 */
export const CHANNELS = 23;
export const ESTIMATORS = 6;
const STATUS_BYTES = 8;
const HEADER_BYTES = 16;
const VERSION = 1;
const TYPE_SAMPLES = 1;

/** Status of one estimate, numbered as in core/types/estimate.h. */
export const STATUS_WEAK = 1;
export const STATUS_NOT_EXCITED = 2;

export interface SampleBlock {
  count: number;
  firstIndex: number;
  /** Seconds since the run's start, on the server's clock, when the frame was sent. */
  serverTime: number;
  values: Float32Array; // count x CHANNELS
  status: Uint8Array; // count x 8
}

export class FrameError extends Error {
  override name = "FrameError";
}

export function decodeFrame(
  buffer: ArrayBuffer,
  offset = 0,
  length = buffer.byteLength - offset,
): SampleBlock {
  if (length < HEADER_BYTES) throw new FrameError(`frame of ${length} bytes is too short`);
  if (offset + length > buffer.byteLength) throw new FrameError("frame reaches beyond its buffer");
  const view = new DataView(buffer, offset, length);
  const version = view.getUint8(0);
  if (version !== VERSION) throw new FrameError(`unknown frame version ${version}`);
  const type = view.getUint8(1);
  if (type !== TYPE_SAMPLES) throw new FrameError(`unknown frame type ${type}`);
  const count = view.getUint16(2, true);
  const valueBytes = count * CHANNELS * 4;
  const expected = HEADER_BYTES + valueBytes + count * STATUS_BYTES;
  if (length !== expected) {
    throw new FrameError(`frame of ${count} samples has ${length} bytes, expected ${expected}`);
  }
  const start = offset + HEADER_BYTES;
  const aligned = start % 4 === 0;
  return {
    count,
    firstIndex: view.getUint32(4, true),
    serverTime: view.getFloat64(8, true),
    values: aligned
      ? new Float32Array(buffer, start, count * CHANNELS)
      : new Float32Array(buffer.slice(start, start + valueBytes)),
    status: new Uint8Array(buffer, start + valueBytes, count * STATUS_BYTES),
  };
}

export function encodeFrame(block: SampleBlock): ArrayBuffer {
  const valueBytes = block.count * CHANNELS * 4;
  const buffer = new ArrayBuffer(HEADER_BYTES + valueBytes + block.count * STATUS_BYTES);
  const view = new DataView(buffer);
  view.setUint8(0, VERSION);
  view.setUint8(1, TYPE_SAMPLES);
  view.setUint16(2, block.count, true);
  view.setUint32(4, block.firstIndex, true);
  view.setFloat64(8, block.serverTime, true);
  new Float32Array(buffer, HEADER_BYTES, block.count * CHANNELS).set(block.values);
  new Uint8Array(buffer, HEADER_BYTES + valueBytes).set(block.status);
  return buffer;
}
