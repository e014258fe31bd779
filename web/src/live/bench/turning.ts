/** A turn on the screen is so many turns of the motor: faster, and a screen shows it backwards. */
export const SLOWER = 20;

/** Angle in degrees after `seconds` at `rpm`; where n is not known the motor stands. */
export function turned(angle: number, rpm: number, seconds: number): number {
  if (!Number.isFinite(rpm)) return angle;
  return (angle + ((rpm * 360) / 60 / SLOWER) * seconds) % 360;
}
