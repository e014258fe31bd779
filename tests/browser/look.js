// What a page looks like, measured: sizes of text, what is wider than the screen, colours of pixels.

const TEXT_LEAST_PX = 12;

/** Visible texts that are smaller than 12 px on the screen. */
export function smallTexts(page) {
  return page.evaluate((least) => {
    const found = new Set();
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    for (let node = walker.nextNode(); node; node = walker.nextNode()) {
      const element = node.parentElement;
      const words = node.textContent.trim();
      if (!words || element.closest(".visually-hidden, script, style, title, option")) continue;
      if (!element.checkVisibility({ visibilityProperty: true, opacityProperty: true })) continue;
      const size = Number.parseFloat(getComputedStyle(element).fontSize);
      // a drawing is scaled to its place
      const drawing = element instanceof SVGGraphicsElement ? element.getScreenCTM() : null;
      const shown = size * Math.abs(drawing?.d ?? 1);
      if (shown < least - 0.05) found.add(`${shown.toFixed(1)} px: ${words.slice(0, 40)}`);
    }
    return [...found];
  }, TEXT_LEAST_PX);
}

/** By how many pixels the page is wider than the screen, and controls that stand outside of it. */
export function outside(page) {
  return page.evaluate(() => {
    const wide = document.documentElement.scrollWidth - document.documentElement.clientWidth;
    const lost = [...document.querySelectorAll("a, button, input, select, summary, h1, h2")]
      .filter(
        (each) => each.checkVisibility() && !each.closest(".scroll-x, .visually-hidden, .skip"),
      )
      .filter((each) => {
        const { left, right } = each.getBoundingClientRect();
        return left < -1 || right > document.documentElement.clientWidth + 1;
      })
      .map((each) => each.outerHTML.slice(0, 80));
    return wide > 0 ? [`${wide} px wider than the screen`, ...lost] : lost;
  });
}

/** [r, g, b] of a picture at points that are given as shares of its width and height. */
export function coloursAt(page, png, points) {
  return page.evaluate(
    async ([base64, points]) => {
      const bytes = Uint8Array.from(atob(base64), (each) => each.charCodeAt(0));
      const picture = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
      const context = new OffscreenCanvas(picture.width, picture.height).getContext("2d");
      context.drawImage(picture, 0, 0);
      return points.map(([x, y]) => [
        ...context
          .getImageData(Math.floor(x * picture.width), Math.floor(y * picture.height), 1, 1)
          .data.slice(0, 3),
      ]);
    },
    [png.toString("base64"), points],
  );
}

/** Number of pixels in which two pictures of one place differ. */
export function differences(page, one, other) {
  return page.evaluate(
    async (both) => {
      const [a, b] = await Promise.all(
        both.map(async (base64) => {
          const bytes = Uint8Array.from(atob(base64), (each) => each.charCodeAt(0));
          const picture = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
          const context = new OffscreenCanvas(picture.width, picture.height).getContext("2d");
          context.drawImage(picture, 0, 0);
          return context.getImageData(0, 0, picture.width, picture.height).data;
        }),
      );
      if (a.length !== b.length) return Number.POSITIVE_INFINITY;
      let count = 0;
      for (let at = 0; at < a.length; at += 4) {
        if ([0, 1, 2].some((channel) => Math.abs(a[at + channel] - b[at + channel]) > 40)) count++;
      }
      return count;
    },
    [one.toString("base64"), other.toString("base64")],
  );
}

/** Contrast of two colours as WCAG defines it, from 1 to 21. */
export function contrast(one, other) {
  const luminance = (rgb) => {
    const [r, g, b] = rgb.map((each) => {
      const share = each / 255;
      return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const [low, high] = [luminance(one), luminance(other)].sort((a, b) => a - b);
  return (high + 0.05) / (low + 0.05);
}
