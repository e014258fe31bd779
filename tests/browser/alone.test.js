// Nobody is left alone: losses are told where the person is looking, a cut link and a restarted
// server are survived, what cannot be taken back is asked, the keyboard keeps its place.
import assert from "node:assert/strict";
import { after, before, beforeEach, describe } from "node:test";
import { makeWorld, pageOf } from "./lab_world.js";
import {
  axe,
  holdRequests,
  launchBrowser,
  openPage,
  START,
  SUITE_MS,
  startPaperRun,
  startServer,
  startWire,
  story,
  temporaryDirectory,
  until,
  waitForReview,
  waitForRunTime,
} from "./support.js";

const CUT = /ERR_|WebSocket|Failed to load|status of 50[24]/;
const bodyText = (page) => page.innerText("body");
/** A page on which nothing is told that an earlier test has caused. */
async function freshPage(browser, server, who, path, options) {
  const one = await pageOf(browser, server, who, path, options);
  const dismiss = one.page.getByRole("button", { name: "Dismiss" });
  await one.page.waitForLoadState("networkidle");
  while ((await dismiss.count()) > 0) await dismiss.click();
  return one;
}
const focused = (page) =>
  page.evaluate(() => {
    const { activeElement } = document;
    return activeElement === document.body ? "BODY" : (activeElement?.tagName ?? "none");
  });
/** Waits until the keyboard has a place. */
const hasFocus = (page) => page.waitForFunction(() => document.activeElement !== document.body);

describe("in the lab", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;
  let pera;
  let mika;

  before(async () => {
    server = await startServer({ speed: 1, benches: 1 });
    browser = await launchBrowser();
    world = await makeWorld(server);
    pera = await world.user("pera", "Pera Peric", "student");
    mika = await world.user("mika", "Mika Mikic", "student");
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });
  beforeEach(async () => {
    const { json: rigs } = await world.call(world.admin, "GET", "/rigs/bench-1/health");
    if (rigs.status === "quarantined") {
      await world.call(world.admin, "POST", "/rigs/bench-1/release", {});
    }
    for (const who of [pera, mika]) {
      const { json } = await world.call(who, "GET", "/tickets");
      for (const each of json.items) {
        await world.call(who, "POST", `/tickets/${each.id}/leave`, {});
      }
    }
    const { json } = await world.call(world.admin, "GET", "/sessions?all=1");
    for (const each of json.items) {
      await world.call(world.admin, "POST", `/sessions/${each.id}/end`, {});
    }
    await world.benchesReady(1);
  });

  async function sessionOf(who) {
    const { json } = await world.call(who, "POST", "/tickets", {
      rig_class: "bench",
      min_s: 600,
      want_s: 1800,
    });
    return (await world.call(who, "POST", `/tickets/${json.ticket.id}/accept`, {})).json;
  }
  async function runOf(who) {
    const { json } = await world.call(who, "POST", "/runs", { rig: "bench-1", duration_s: 600 });
    return json.id;
  }
  const told = (page) => page.getByRole("region", { name: "News for you" });

  story("a take-over is told on the live page: who, why, what next; until it is seen", async () => {
    const session = await sessionOf(pera);
    const run = await runOf(pera);
    const one = await pageOf(browser, server, pera, `/lab/${run}`);
    await waitForRunTime(one.page, 1);
    await one.page.evaluate(() => {
      globalThis.said = [];
      const region = document.querySelector("[role=status].visually-hidden");
      new MutationObserver(() => globalThis.said.push(region.textContent)).observe(region, {
        characterData: true,
        childList: true,
        subtree: true,
      });
      scrollTo(0, document.body.scrollHeight);
    });
    const other = await one.context.newPage();
    await other.goto(`${server.url}/help`);
    await world.call(world.admin, "POST", `/sessions/${session.id}/take-over`, {
      reason: "the motor is hot",
    });
    const words = /has taken over bench-1\. Your session has ended\. Reason: the motor is hot/;
    for (const page of [one.page, other]) await told(page).getByText(words).waitFor();
    assert.ok(await told(one.page).isVisible());
    const box = await told(one.page).boundingBox();
    assert.ok(box.y >= 0 && box.y < 300, `in sight although scrolled down: ${box.y}`);
    await one.page.waitForFunction(() => globalThis.said.some((each) => /motor is hot/.test(each)));
    await one.page.locator(".chip", { hasText: "the session on the rig has ended" }).waitFor();
    assert.equal(await told(one.page).getByRole("link", { name: "See the recording" }).count(), 0);
    await told(other).getByRole("link", { name: "See the recording" }).waitFor();
    assert.deepEqual(await axe(one.page), []);

    await one.page.reload();
    await told(one.page).getByText(words).waitFor();
    await told(one.page).getByRole("button", { name: "Dismiss" }).click();
    await told(one.page).waitFor({ state: "detached" });
    await told(other).waitFor({ state: "detached" });
    await one.page.reload();
    await waitForReview(one.page);
    await one.page.waitForLoadState("networkidle");
    assert.equal(await told(one.page).count(), 0);
    await one.close();
  });

  story(
    "a rig that goes out of service and a turn that is lost are told, with a next step",
    async () => {
      const one = await freshPage(browser, server, pera, "/runs", {
        viewport: { width: 390, height: 844 },
      });
      await sessionOf(pera);
      await world.policy({ offer_s: 10 }); // nobody takes the one below
      const { json: ticket } = await world.call(mika, "POST", "/tickets", {
        rig_class: "bench",
        min_s: 600,
        want_s: 1800,
      });
      const two = await freshPage(browser, server, mika, "/help");
      await world.call(world.admin, "POST", "/rigs/bench-1/quarantine", {
        reason: "smells of smoke",
      });
      await told(one.page)
        .getByText(/bench-1 went out of service:.*Reason: smells of smoke/)
        .waitFor();
      assert.deepEqual(await axe(one.page), []);
      await told(one.page).getByRole("button", { name: "Wait in line" }).click();
      await one.page.waitForURL(/\/my$/);
      await one.page.getByText(/^Place 2 in the queue: .+\(simulated\)/).waitFor();
      await told(one.page).waitFor({ state: "detached" });

      await world.call(world.admin, "POST", "/rigs/bench-1/release", {});
      await two.page.getByText(/^It is your turn: /).waitFor();
      assert.equal(ticket.ticket.state, "waiting");
      await world.call(mika, "GET", "/tickets"); // the offer is not taken
      await told(two.page)
        .getByText(/bench-1 was offered to you, and the offer ran out/)
        .waitFor();
      await told(two.page).getByText("You keep your place in the queue").waitFor();
      await world.policy({ offer_s: 45 });
      await one.close();
      await two.close();
    },
  );

  story("a free rig that is kept for a booking is named, with its times", async () => {
    const start = new Date(Date.now() + 6 * 60_000);
    const end = new Date(start.getTime() + 30 * 60_000);
    const { json: booking, answer } = await world.call(mika, "POST", "/bookings", {
      rig_class: "bench",
      start: start.toISOString(),
      end: end.toISOString(),
    });
    const one = await freshPage(browser, server, pera, "/my");
    await one.page.getByRole("button", { name: "Ask for a rig now" }).click();
    await one.page.getByText(/^Place 1 in the queue: .+\(simulated\)/).waitFor();
    const time = (date) =>
      date.toLocaleTimeString("en-GB", { hour: "2-digit", minute: "2-digit", hourCycle: "h23" });
    const kept = await one.page.getByText(/bench-1 is free, but booked/).innerText();
    assert.ok(kept.includes(time(start)) && kept.includes(time(end)), kept);
    assert.match(kept, /Your turn starts after it/);
    assert.deepEqual(await axe(one.page), []);
    await one.page.getByRole("button", { name: "Leave the queue" }).click();
    await one.page.getByRole("dialog").getByText("Your place is lost").waitFor();
    await one.page.getByRole("dialog").getByRole("button", { name: "Leave the queue" }).click();
    await one.page.getByRole("button", { name: "Ask for a rig now" }).waitFor();
    await one.close();

    const two = await freshPage(browser, server, mika, "/my");
    const cancel = two.page.getByRole("button", { name: "Cancel booking" });
    await cancel.click();
    await two.page.getByRole("dialog").getByRole("button", { name: "Cancel", exact: true }).click();
    await two.page.getByRole("dialog").waitFor({ state: "detached" });
    assert.equal(await cancel.count(), 1, "not sure: nothing happens");
    assert.equal(await focused(two.page), "BUTTON", "back where it was");
    await cancel.click();
    await two.page.getByRole("dialog").getByRole("button", { name: "Cancel booking" }).click();
    await cancel.waitFor({ state: "detached" });
    assert.notEqual(await focused(two.page), "BODY");
    assert.ok(answer.ok && booking.id);
    await two.close();
  });

  story(
    "whoever finds all simulators in use waits in line, and the run begins by itself",
    async () => {
      const busy = [];
      for (const who of [pera, pera, mika, mika]) {
        busy.push(
          (await world.call(who, "POST", "/runs", { bench: "paper", duration_s: 600 })).json.id,
        );
      }
      const third = await world.user("zika", "Zika Zikic", "student");
      const { page, close } = await pageOf(browser, server, third, "/", { allow: /status of 503/ });
      await page.getByRole("button", { name: START }).click();
      const place = page.getByText("You are number 1 in line");
      await place.waitFor();
      await axe(page);
      await page.getByRole("button", { name: "Leave the line" }).click();
      await place.waitFor({ state: "detached" });
      await page.getByRole("button", { name: START }).click();
      await place.waitFor();
      await world.call(mika, "POST", `/runs/${busy.pop()}/stop`, {});
      await page.waitForURL(/\/lab\/./);
      await page.getByRole("button", { name: "Stop" }).click();
      await close();
      for (const id of busy.slice(0, 2)) await world.call(pera, "POST", `/runs/${id}/stop`, {});
      await world.call(mika, "POST", `/runs/${busy[2]}/stop`, {});
    },
  );

  story("a role is not changed by one arrow key", async () => {
    const one = await pageOf(browser, server, world.admin, "/admin");
    const role = one.page.getByLabel("Role mika", { exact: true });
    await role.selectOption("instructor");
    const dialog = one.page.getByRole("dialog");
    await dialog.getByText("Mika Mikic then has the rights of this role: instructor.").waitFor();
    assert.deepEqual(await axe(one.page), []);
    await one.page.keyboard.press("Escape");
    await dialog.waitFor({ state: "detached" });
    assert.equal(await role.inputValue(), "student");
    const { json } = await world.call(world.admin, "GET", "/users?limit=50");
    assert.equal(json.items.find((each) => each.login === "mika").role, "student");
    await one.close();
  });

  story("focus stays in the page after sign-in", async () => {
    const one = await openPage(browser, `${server.url}/signin?next=/my`);
    await one.page.getByLabel("Login").fill("pera");
    await one.page.getByLabel("Password").fill("correct horse battery");
    await one.page.keyboard.press("Enter");
    await one.page.waitForURL(/\/my$/);
    await one.page.getByRole("heading", { name: "My lab" }).waitFor();
    await hasFocus(one.page);
    await one.close();
  });
});

describe("when the link is cut or the server restarts", { timeout: SUITE_MS }, () => {
  let browser;
  let server;
  let data;
  const start = async (listen) => {
    server = await startServer({ speed: 1, data: data.path, listen });
    return server;
  };

  before(async () => {
    data = temporaryDirectory();
    browser = await launchBrowser();
    await start();
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
    data?.remove();
  });
  /** Stops the server until `away` is done. */
  async function restart(away) {
    const { host } = new URL(server.url);
    await server.stop();
    await away();
    await start(host);
  }

  story(
    "Stop pressed while the link is cut says that it waits, and is sent with the link",
    async () => {
      const wire = await startWire(server.url);
      const { page, close } = await openPage(browser, wire.url, { allow: CUT });
      // Parts that are still on their way; what tells that the link is cut is none.
      const parts = await holdRequests(page, /\/(gestures|RunNotices|LinkChip|ConnectionNotice)-/);
      const run = await startPaperRun(page);
      await hasFocus(page);
      await waitForRunTime(page, 1);
      wire.cut();
      await parts.letGo();
      await page.getByText("reconnecting").waitFor();
      await page.getByRole("button", { name: "Stop" }).click();
      const notice = page.getByRole("alert").filter({ hasText: "Stop waits and is sent" });
      await notice.waitFor();
      assert.match(await notice.innerText(), /limits and interlocks protect it/);
      const state = async () =>
        (await (await fetch(`${server.url}/api/v1/runs/${run}`)).json()).state;
      assert.notEqual(await state(), "stopped");
      wire.mend();
      await waitForReview(page);
      await page.locator(".chip", { hasText: /^by hand$/ }).waitFor();
      assert.notEqual(await focused(page), "BODY");
      assert.equal(await notice.count(), 0);
      await page.locator('.signals .plot[style*="pan-y"]').first().waitFor(); // fingers work, too
      await close();
      wire.close();
    },
  );

  for (const viewport of [
    { width: 1366, height: 768 },
    { width: 1000, height: 700 },
    { width: 360, height: 740 },
  ]) {
    story(`nothing that comes unasked moves Stop, ${viewport.width} wide`, async () => {
      const wire = await startWire(server.url);
      const { page, close } = await openPage(browser, wire.url, { viewport, allow: CUT });
      const answer = await fetch(`${server.url}/api/v1/runs`, {
        method: "POST",
        headers: { "Content-Type": "application/json" },
        body: JSON.stringify({
          duration_s: 600,
          name: "a long name that a student has given to a run",
          faults: [{ component: "R9", value: 200, at_s: 15 }],
        }),
      });
      const run = await answer.json();
      assert.equal(answer.status, 201, JSON.stringify(run));
      await page.goto(`${wire.url}/lab/${run.id}`);
      const stop = page.getByRole("button", { name: "Stop" });
      await waitForRunTime(page, 1);
      const before = await stop.boundingBox();
      await page.locator(".chip.countdown").waitFor();
      assert.deepEqual(await stop.boundingBox(), before, "a countdown moves it");
      wire.cut();
      const away = page.getByRole("alert").getByText("The server does not answer");
      await away.waitFor();
      assert.deepEqual(await stop.boundingBox(), before, "a notice moves it");
      const seen = await away.evaluate((notice) => {
        const { left, top, height } = notice.getBoundingClientRect();
        return notice === document.elementFromPoint(left + 20, top + height / 2);
      });
      assert.ok(seen, "the notice is in sight, under nothing");
      wire.mend();
      await away.waitFor({ state: "detached" });
      await stop.click();
      await waitForReview(page);
      await close();
      wire.close();
    });
  }

  story("two tabs agree on a stop, and both say why", async () => {
    const { page, context, close } = await openPage(browser, server.url);
    await startPaperRun(page);
    const other = await context.newPage();
    await other.goto(page.url());
    await waitForRunTime(other, 1);
    await other.getByRole("button", { name: "Stop" }).click();
    for (const each of [page, other]) {
      await waitForReview(each);
      await each.locator(".chip", { hasText: /^by hand$/ }).waitFor();
    }
    await close();
  });

  story("a tab that slept comes back live, without a gap and never stale", async () => {
    const { page, close } = await openPage(browser, server.url);
    await page.getByLabel("Duration, s").fill("60");
    await page.getByRole("button", { name: "Run this experiment" }).click();
    await waitForRunTime(page, 1);
    await page.evaluate(() => {
      globalThis.seen = [];
      globalThis.longestPause = 0;
      let ticked = performance.now();
      setInterval(() => {
        globalThis.longestPause = Math.max(globalThis.longestPause, performance.now() - ticked);
        ticked = performance.now();
      }, 100);
      new MutationObserver(() => {
        const chip = [...document.querySelectorAll(".chip")].find((each) =>
          /missing/.test(each.textContent),
        );
        if (chip) globalThis.seen.push(chip.textContent);
      }).observe(document.body, { childList: true, subtree: true, characterData: true });
    });
    // a visible page does not freeze when asked, so its process sleeps
    const devtools = await browser.newBrowserCDPSession();
    const { processInfo } = await devtools.send("SystemInfo.getProcessInfo");
    const renderers = processInfo.filter((each) => each.type === "renderer");
    for (const { id } of renderers) process.kill(id, "SIGSTOP");
    const run = page.url().split("/").at(-1);
    const measured = async () =>
      (await (await fetch(`${server.url}/api/v1/runs/${run}`)).json()).samples;
    const asleep = await measured();
    await until(measured, (samples) => samples >= asleep + 950);
    for (const { id } of renderers) process.kill(id, "SIGCONT");
    await waitForRunTime(page, 10);
    await page.locator(".chip", { hasText: "· 0 samples missing" }).waitFor();
    const { seen, longestPause } = await page.evaluate(() => ({
      seen: globalThis.seen,
      longestPause: globalThis.longestPause,
    }));
    assert.ok(longestPause > 8000, `it slept: ${longestPause} ms`);
    // A busy machine may be late by itself, but not by the time that the page slept.
    const age = (chip) => Number(/data ([\d.]+) s old/.exec(chip)?.[1] ?? 0);
    assert.deepEqual(
      seen.filter((each) => age(each) > 5 || /reconnecting/.test(each)),
      [],
    );
    await close();
  });

  story("after a restart the page comes back by itself, with its late parts", async () => {
    const { page, close } = await openPage(browser, server.url, { allow: CUT });
    await page.getByRole("button", { name: "Run this experiment" }).waitFor();
    let failed = 0;
    page.on("requestfailed", () => failed++);
    await restart(async () => {
      await page.getByRole("link", { name: "Runs", exact: true }).click(); // a part not loaded before
      await page.getByText("The server does not answer.").waitFor();
      const before = failed;
      await until(
        () => failed,
        (count) => count >= before + 2,
      ); // it has asked again
      assert.doesNotMatch(await bodyText(page), /TypeError|Failed to fetch/);
    });
    await page.getByRole("heading", { name: "Runs", exact: true }).waitFor();
    await page.getByRole("heading", { name: "Recent runs" }).waitFor();
    await page.getByText("The server does not answer.").waitFor({ state: "detached" });
    assert.doesNotMatch(await bodyText(page), /TypeError|Failed to fetch/);
    await close();
  });

  story(
    "a run that a restart cuts is shown with what was recorded, and a new one can be set up",
    async () => {
      const { page, close } = await openPage(browser, server.url, { allow: CUT });
      await startPaperRun(page);
      await waitForRunTime(page, 3);
      const texts = [];
      const watch = setInterval(async () => texts.push(await bodyText(page).catch(() => "")), 500);
      await restart(async () => {
        await page.getByRole("alert").getByText("The server does not answer").waitFor();
        const before = texts.length;
        await until(
          () => texts.length,
          (count) => count > before + 5,
        );
      });
      await waitForReview(page);
      await page.getByRole("heading", { name: "Next run" }).waitFor();
      await page.locator(".chip", { hasText: "the server was stopped" }).waitFor();
      clearInterval(watch);
      assert.ok(!texts.some((each) => /TypeError|Failed to fetch/.test(each)));
      await close();
    },
  );

  story("a new build is loaded once, not in a loop, and not over what somebody types", async () => {
    const { page, close } = await openPage(browser, server.url, {
      allow: /status of 404|dynamically imported/,
    });
    let loads = 0;
    page.on("load", () => loads++);
    await page.getByRole("button", { name: "Run this experiment" }).waitFor();
    await page.route(/\/assets\/RunsPage-.*\.js/, (route) => route.fulfill({ status: 404 }));
    await page.getByRole("link", { name: "Runs", exact: true }).click();
    await page.getByText("Part of this page could not be loaded").waitFor();
    await page.waitForLoadState("networkidle");
    assert.equal(loads, 1, "once, and then it is said");
    await page.unroute(/\/assets\/RunsPage-.*\.js/);
    await page.getByRole("button", { name: "Reload" }).click();
    await page.getByRole("heading", { name: "Recent runs" }).waitFor();

    await page.evaluate(() => sessionStorage.clear());
    await page.goto(server.url);
    await startPaperRun(page);
    await waitForRunTime(page, 1);
    await page.keyboard.press("Escape");
    await waitForReview(page);
    await page.getByLabel("Duration, s").fill("33");
    loads = 0;
    await page.route(/\/assets\/KeyboardHelp-.*\.js/, (route) => route.fulfill({ status: 404 }));
    await page.getByRole("button", { name: "Keys", exact: true }).click();
    await page.getByText("Part of this page could not be loaded").waitFor();
    await page.waitForLoadState("networkidle");
    assert.equal(loads, 0);
    assert.equal(await page.getByLabel("Duration, s").inputValue(), "33");
    await close();
  });
});
