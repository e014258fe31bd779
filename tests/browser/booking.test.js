import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { makeWorld, pageOf } from "./lab_world.js";
import { axe, confirmIn, launchBrowser, SUITE_MS, startServer, story } from "./support.js";

describe("booking", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;
  let student;
  let other;

  before(async () => {
    server = await startServer({ speed: 10, benches: 1 });
    browser = await launchBrowser();
    world = await makeWorld(server);
    student = await world.user("pera", "Pera", "student");
    other = await world.user("mika", "Mika", "student");
    await world.benchesReady(1);
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  const zone = { timezoneId: "Europe/Belgrade", locale: "en-GB" };

  story(
    "a slot is chosen in the week grid by keyboard, booked, seen as taken by others, cancelled",
    async () => {
      const mine = await pageOf(browser, server, student, "/book", zone);
      const grid = mine.page.getByRole("grid", { name: "Week of slots" });
      await grid.getByRole("button", { name: /free$/ }).first().waitFor();
      await mine.page.getByLabel("Minutes").selectOption("60");
      // tomorrow, 10:00: the second column, six half hours after 07:00
      await grid.locator('[data-at="0-0"]').focus();
      for (const key of ["ArrowRight", ...Array(6).fill("ArrowDown"), "Enter"]) {
        await mine.page.keyboard.press(key);
      }
      const choice = mine.page.locator(".card", { hasText: "Your choice" });
      await choice.getByText(/, 10:00.11:00$/).waitFor();
      await choice.getByText("The rig is checked in the last 30 s.").waitFor();
      assert.equal(await grid.locator('[aria-pressed="true"]').count(), 2, "an hour is two slots");
      assert.deepEqual(await axe(mine.page), []);
      await choice.getByRole("button", { name: "Book", exact: true }).click();
      const booking = mine.page.getByRole("listitem").filter({ hasText: "booked" });
      await booking.getByText(/, 10:00.11:00/).waitFor();

      const theirs = await pageOf(browser, server, other, "/book", zone);
      await theirs.page.locator('[data-at="1-6"].taken').waitFor();
      // The hour before follows on: its check is at its end.
      await theirs.page.locator('[data-at="1-4"].free').waitFor();
      const before = theirs.page.locator('[data-at="1-5"].short');
      assert.match(await before.getAttribute("aria-label"), /09:30, too short$/);
      assert.match(
        await theirs.page.locator('[data-at="1-6"]').getAttribute("aria-label"),
        /10:00, taken$/,
      );
      await theirs.page.getByLabel("Minutes").selectOption("60");
      await theirs.page.locator('[data-at="1-6"].taken').click();
      await theirs.page.getByText("No rig is free for all of it.").waitFor();
      assert.deepEqual(await axe(theirs.page), []);
      await theirs.page.getByRole("button", { name: "Wait for this time" }).click();
      const waits = theirs.page.getByRole("listitem").filter({ hasText: "waiting for this time" });
      await waits.getByText(/, 10:00.11:00/).waitFor();

      await mine.page.goto(`${server.url}/book`);
      await mine.page.locator('[data-at="1-6"].mine').waitFor();
      await mine.page.goto(`${server.url}/my`);
      await booking.getByRole("button", { name: "Cancel booking" }).click();
      await confirmIn(mine.page);
      await mine.page.getByText("No booking.").waitFor();
      await theirs.page.getByText("The time that you waited for is yours").first().waitFor();
      await waits.waitFor({ state: "detached" });
      const given = theirs.page.getByRole("listitem").filter({ hasText: "booked" });
      await given.getByRole("button", { name: "Cancel booking" }).click();
      await confirmIn(theirs.page);
      await theirs.close();
      await mine.close();
    },
  );

  story(
    "the next free start books in two presses; what others took meanwhile is refused in words",
    async () => {
      const mine = await pageOf(browser, server, student, "/book", {
        ...zone,
        allow: /status of 4(09|22)/,
      });
      const free = mine.page.locator(".card", { hasText: "Next free" }).getByRole("button");
      await free.first().waitFor();
      const offered = await free.first().innerText();
      await free.nth(1).click();
      const { json } = await world.call(
        other,
        "GET",
        `/rig-classes/bench/availability?minutes=240`,
      );
      await world.call(other, "POST", "/bookings", {
        rig_class: "bench",
        ...span(json.next_free[0]),
      });
      await mine.page.getByRole("button", { name: "Book", exact: true }).click();
      await mine.page.getByRole("alert").waitFor();
      await mine.page.locator(".taken").first().waitFor(); // and the grid shows the reason
      await free.first().filter({ hasNotText: offered }).waitFor();
      await free.first().click();
      await mine.page.getByRole("button", { name: "Book", exact: true }).click();
      await mine.page.getByRole("listitem").filter({ hasText: "booked" }).waitFor();
      await mine.close();
    },
  );

  const span = ({ start, end }) => ({ start, end });
});
