import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { makeWorld, pageOf } from "./lab_world.js";
import { axe, confirmIn, launchBrowser, SUITE_MS, startServer, story } from "./support.js";

describe("hours of the lab", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;
  let teacher;
  let ann;
  let bob;
  const zone = { timezoneId: "Europe/Belgrade", locale: "en-GB" };

  before(async () => {
    server = await startServer({ speed: 10, benches: 1 });
    browser = await launchBrowser();
    world = await makeWorld(server);
    teacher = await world.user("teacher", "Vera", "instructor");
    ann = await world.user("ann", "Ann", "student");
    bob = await world.user("bob", "Bob", "student");
    const course = await world.course(teacher, "Drives", [ann]);
    await world.join(ann, course);
    await world.benchesReady(1);
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  /** "2027-01-04" in the browser's zone, so many days ahead. */
  const dayAhead = (page, days) =>
    page.evaluate((ahead) => {
      const now = new Date();
      const day = new Date(now.getFullYear(), now.getMonth(), now.getDate() + ahead, 12);
      return day.toISOString().slice(0, 10);
    }, days);

  async function fill(card, page, { title, first, from, to, repeat, until }) {
    await card.getByLabel("What for").fill(title);
    await card.getByLabel("First day").fill(await dayAhead(page, first));
    await card.getByLabel("From").fill(from);
    await card.getByLabel("To", { exact: true }).fill(to);
    await card.getByLabel("Repeats").selectOption({ label: repeat });
    if (until) await card.getByLabel("Last day").fill(await dayAhead(page, until));
    await card.getByRole("button", { name: "Add hours" }).click();
  }

  story("an admin opens it by day, a course has its hour, and the week shows both", async () => {
    const admin = await pageOf(browser, server, world.admin, "/admin", zone);
    const open = admin.page.locator("section", {
      has: admin.page.getByRole("heading", { name: "Opening hours" }),
    });
    await fill(open, admin.page, {
      title: "Day",
      first: 0,
      from: "08:00",
      to: "20:00",
      repeat: "every day",
      until: 30,
    });
    await open.getByText("The hours are set.").waitFor();
    await open
      .getByRole("listitem")
      .filter({ hasText: /08:00.20:00/ })
      .waitFor();
    assert.deepEqual(await axe(admin.page), []);
    await admin.close();

    const teach = await pageOf(browser, server, teacher, "/teach", zone);
    await teach.page.getByRole("button", { name: "Add members, Drives" }).click();
    const own = teach.page.locator("section section", {
      has: teach.page.getByRole("heading", { name: "Hours of this course" }),
    });
    await fill(own, teach.page, {
      title: "Drives, group 2",
      first: 1,
      from: "10:00",
      to: "11:00",
      repeat: "every week",
      until: 20,
    });
    await own
      .getByRole("listitem")
      .filter({ hasText: /10:00.11:00/ })
      .waitFor();
    assert.deepEqual(await axe(teach.page), []);
    await teach.close();

    const stranger = await pageOf(browser, server, bob, "/book", zone);
    const cell = stranger.page.locator('[data-at="1-6"]'); // tomorrow, 10:00
    await stranger.page.locator('[data-at="1-6"].closed').waitFor();
    assert.match(await cell.getAttribute("aria-label"), /10:00, closed, for Drives, group 2$/);
    await stranger.page.locator('[data-at="1-0"].closed').waitFor();
    await stranger.page.locator('[data-at="1-8"].free').waitFor();
    assert.deepEqual(await axe(stranger.page), []);
    await stranger.close();
  });

  story("who is in the course books its hour, two weeks on end", async () => {
    const book = await pageOf(browser, server, ann, "/book", zone);
    await book.page.getByLabel("Minutes").selectOption("30");
    await book.page.locator('[data-at="1-6"].free').click();
    const choice = book.page.locator(".card", { hasText: "Your choice" });
    await choice.getByLabel("Repeats").selectOption({ label: "in 2 weeks, same hour" });
    await choice.getByRole("button", { name: "Book", exact: true }).click();
    const booked = book.page.getByRole("listitem").filter({ hasText: "booked" });
    await booked.nth(1).waitFor();
    assert.equal(await booked.count(), 2);
    await book.close();
  });

  story("hours that are removed close nothing", async () => {
    const admin = await pageOf(browser, server, world.admin, "/admin", zone);
    await admin.page.getByRole("button", { name: "Remove, Day" }).click();
    await confirmIn(admin.page, "Remove");
    await admin.page.getByRole("button", { name: "Remove, Day" }).waitFor({ state: "detached" });
    await admin.close();
    const stranger = await pageOf(browser, server, bob, "/book", zone);
    await stranger.page.locator('[data-at="1-0"].free').waitFor();
    await stranger.close();
  });
});
