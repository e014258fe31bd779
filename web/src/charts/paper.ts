/**
 * Calls `draw` before the page is printed and again when it is back on the screen. Before
 * printing it is called twice: before the layout for paper and, if the browser reports it,
 * after.
 * @returns a function that ends this
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
