/**
 * `narrow`: no room for the faults beside the charts, they are in a sheet.
 * `phone`: shows the chosen charts only, two upright and one lying.
 */
export const PHONE = "(max-width: 760px), (max-width: 1000px) and (max-height: 500px)";
const NARROW = `(max-width: 1180px), ${PHONE}`;

export const screenSize = $state({ narrow: false, phone: false });

function watch(name: keyof typeof screenSize, query: string): void {
  const media = globalThis.matchMedia?.(query);
  if (!media) return; // a unit test
  screenSize[name] = media.matches;
  media.addEventListener("change", () => {
    screenSize[name] = media.matches;
  });
}
watch("narrow", NARROW);
watch("phone", PHONE);
