const PLACES = "dialog, section, aside, form, main";

/**
 * Keeps the keyboard's place: when the focused element is removed or disabled, the browser leaves
 * the focus on the body, at the top of the page. It then goes to the nearest part of the page that
 * is still there, and back when a disabled element is enabled again. A person who clicks
 * elsewhere or leaves a field is left alone.
 */
export function keepFocus(): void {
  let last: HTMLElement | null = null;
  let ancestors: HTMLElement[] = [];
  /** Where the focus was put while `last` is disabled. */
  let stand: HTMLElement | null = null;

  const isOn = (element: HTMLElement) => element.isConnected && !element.matches(":disabled");
  const take = (element: HTMLElement) => {
    last = element;
    ancestors = [];
    for (let each = element.parentElement; each; each = each.parentElement) ancestors.push(each);
  };
  const stayOn = (element: HTMLElement) => {
    if (!element.hasAttribute("tabindex")) element.tabIndex = -1;
    element.focus({ preventScroll: true });
  };

  document.addEventListener("focusin", ({ target }) => {
    if (target === stand || !(target instanceof HTMLElement)) return;
    stand = null;
    take(target);
  });
  document.addEventListener("focusout", ({ target, relatedTarget }) => {
    if (relatedTarget || target !== last) return;
    const left = last;
    // a removal is only seen when it is complete
    queueMicrotask(() => {
      if (left && left === last && isOn(left) && document.hasFocus()) last = null;
    });
  });
  new MutationObserver(() => {
    const focused = document.activeElement;
    if (!last) return;
    if (stand && focused === stand && isOn(last)) {
      const back = last;
      stand = null;
      back.focus({ preventScroll: true });
      return;
    }
    if ((focused && focused !== document.body) || isOn(last)) return;
    const place =
      ancestors.find((each) => each.isConnected && each.matches(PLACES)) ??
      document.querySelector<HTMLElement>("main");
    if (!place) return;
    stand = place;
    stayOn(place);
  }).observe(document.body, {
    childList: true,
    subtree: true,
    attributes: true,
    attributeFilter: ["disabled"],
  });
}
