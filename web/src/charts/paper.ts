/**
 * Calls `draw` when the page goes to paper and when it is back on the screen. On the way to paper it
 * is called twice: before the page is laid out for it, and, where the browser tells, after.
 * @returns how to end that
 */
export function onPaper(draw: () => void): () => void {
  const media = matchMedia("print");
  addEventListener("beforeprint", draw);
  media.addEventListener("change", draw);
  return () => {
    removeEventListener("beforeprint", draw);
    media.removeEventListener("change", draw);
  };
}
