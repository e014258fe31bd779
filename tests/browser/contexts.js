// Browser contexts that the stories of a file use one after the other. A page in a context that has
// been used costs half of one in a new context: its process runs, its fonts and scripts are there.
// The next story finds nothing of the one before: no page, cookie, stored item or permission.

/** browser -> how its contexts were made -> those that nobody uses */
const resting = new WeakMap();
const kinds = new WeakMap();
/** Contexts that cannot be made as new. */
const changed = new WeakSet();

/** A context with an empty page that keeps its process; `options` are those of newContext. */
export async function takeContext(browser, options) {
  const kind = JSON.stringify(options);
  if (!resting.has(browser)) resting.set(browser, new Map());
  const left = resting.get(browser).get(kind)?.pop();
  if (left) return left;
  const context = await browser.newContext(options);
  kinds.set(context, kind);
  for (const name of ["addInitScript", "route", "exposeFunction", "setOffline"]) {
    const change = context[name].bind(context);
    context[name] = (...values) => {
      changed.add(context);
      return change(...values);
    };
  }
  await context.newPage();
  return context;
}

/** `origin` is that of the pages which were open in it. */
export async function giveBack(context, origin) {
  if (changed.has(context)) return context.close();
  const [first, ...others] = context.pages();
  for (const page of others) await page.close();
  await context.clearCookies();
  await context.clearPermissions();
  const devtools = await context.newCDPSession(first);
  await devtools.send("Storage.clearDataForOrigin", { origin, storageTypes: "all" });
  await devtools.detach();
  const kind = kinds.get(context);
  const same = resting.get(context.browser());
  same.set(kind, [...(same.get(kind) ?? []), context]);
}
