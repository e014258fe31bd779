import assert from "node:assert/strict";
import { after, before, beforeEach, describe } from "node:test";
import { makeWorld, pageOf } from "./lab_world.js";
import {
  axe,
  confirmIn,
  launchBrowser,
  SUITE_MS,
  startServer,
  story,
  waitForReview,
} from "./support.js";

describe("sessions", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;
  let students;

  before(async () => {
    server = await startServer({ speed: 10, benches: 1 });
    browser = await launchBrowser();
    world = await makeWorld(server);
    students = [];
    for (const login of ["pera", "mika", "laza"]) {
      students.push(await world.user(login, login, "student"));
    }
    await world.benchesReady(1);
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });
  beforeEach(clear);

  /** Ends all sessions and queue places, and waits for the check of the bench. */
  async function clear() {
    const { json: sessions } = await world.call(world.admin, "GET", "/sessions?all=1");
    for (const who of students) {
      const { json } = await world.call(who, "GET", "/tickets");
      for (const ticket of json.items.filter((each) => /waiting|offered/.test(each.state))) {
        await world.call(who, "POST", `/tickets/${ticket.id}/leave`, {});
      }
    }
    for (const session of sessions.items.filter((each) => each.state === "active")) {
      await world.call(world.admin, "POST", `/sessions/${session.id}/end`, {});
    }
    await world.benchesReady(1);
  }
  /** Takes the bench and starts a run on it that lasts longer than the test; the page shows it. */
  async function runOnBench(page) {
    await takeBench(page);
    await page.getByRole("link", { name: "Use the rig" }).click();
    await page.getByLabel("Duration, s").fill("600");
    await page.locator("#set-R1").focus();
    await page.keyboard.press("1");
    await page.getByRole("button", { name: "Run this experiment" }).click();
    await page.waitForURL(/\/lab\/.+/);
    await page.locator("#set-R12:not([disabled])").waitFor();
  }
  async function takeBench(page) {
    await page.getByRole("button", { name: "Ask for a rig now" }).click();
    await page.getByRole("button", { name: "Accept" }).click();
    await page.getByRole("heading", { name: "Your session" }).waitFor();
    await page.getByRole("link", { name: "Use the rig" }).waitFor();
  }

  story(
    "places and offers in the queue come without a reload, and the next session starts",
    async () => {
      const pages = [];
      for (const who of students) pages.push(await pageOf(browser, server, who, "/my"));
      const [first, second, third] = pages.map((each) => each.page);
      await takeBench(first);
      assert.deepEqual(await axe(first), []);

      await second.getByRole("button", { name: "Ask for a rig now" }).click();
      await second.getByText(/^Place 1 in the queue: .+\(simulated\)/).waitFor();
      await second.getByText(/^Expected start \w{3} \d+ \w{3}, \d\d:\d\d$/).waitFor();
      await third.getByRole("button", { name: "Ask for a rig now" }).click();
      await third.getByText(/^Place 2 in the queue: .+\(simulated\)/).waitFor();
      const expected = await third.getByText(/^Expected start/).innerText();
      assert.deepEqual(await axe(third), []);

      await first.getByRole("button", { name: "End session" }).click();
      await confirmIn(first);
      await second.getByText(/^It is your turn: /).waitFor();
      await first.getByRole("link", { name: "Past sessions" }).click();
      await first.getByRole("heading", { name: "Past sessions" }).waitFor();
      await first.getByRole("listitem").filter({ hasText: "you ended it" }).waitFor();
      await third.getByText(/^Place 1 in the queue: .+\(simulated\)/).waitFor();
      assert.notEqual(await third.getByText(/^Expected start/).innerText(), expected);
      await second.getByRole("button", { name: "Accept" }).click();
      await second.getByRole("heading", { name: "Your session" }).waitFor();
      await third.getByRole("button", { name: "Leave the queue" }).click();
      await confirmIn(third);
      await third.getByRole("button", { name: "Ask for a rig now" }).waitFor();
      for (const each of pages) await each.close();
    },
  );

  story(
    "a session goes on while nobody waits; when somebody does, its user is told why it ends",
    async () => {
      await world.policy({ offer_s: 20 });
      const one = await pageOf(browser, server, students[0], "/my");
      const short = { rig_class: "bench", min_s: 300, want_s: 300 };
      await world.call(students[0], "POST", "/tickets", short);
      await one.page.getByRole("button", { name: "Accept" }).click();
      const card = one.page.locator(".card.now", { hasText: "Your session" });
      await card.getByText("It goes on by itself as long as nobody waits").waitFor();
      const { json } = await world.call(students[1], "POST", "/tickets", short);
      const warning = one.page.getByText(/soon.*somebody waits/i).first();
      await warning.waitFor(); // its last 5 minutes begin after the offer's 20 s
      await card.getByText(/^4:\d\d$/).waitFor();
      await world.call(students[1], "POST", `/tickets/${json.ticket.id}/leave`, {});
      await card.getByText(/^14:\d\d$/).waitFor();
      await world.policy({ offer_s: 45 });
      await one.close();
    },
  );

  story(
    "control goes over by offer and accept, from whatever page the other one is on",
    async () => {
      const one = await pageOf(browser, server, students[0], "/my");
      const two = await pageOf(browser, server, students[1], "/runs");
      await takeBench(one.page);
      await one.page.getByLabel("Hand over to").fill("mika");
      await one.page.getByRole("button", { name: "Offer control" }).click();
      await one.page.getByText("Offered to mika.").waitFor();

      const bar = two.page.getByRole("complementary", { name: "My lab" });
      await bar.getByText("pera offers you control of bench-1.").waitFor();
      assert.deepEqual(await axe(two.page), []);
      await bar.getByRole("button", { name: "Accept" }).click();
      await bar.getByText("bench-1 ends in").waitFor();
      await one.page.getByRole("button", { name: "Ask for a rig now" }).waitFor();
      await one.page
        .getByRole("listitem")
        .filter({ hasText: "mika has accepted control of bench-1" })
        .waitFor();
      await one.close();
      await two.close();
    },
  );

  story(
    "an operator takes over with a reason, and the run of the one who loses the rig is stopped",
    async () => {
      const one = await pageOf(browser, server, students[2], "/my");
      await runOnBench(one.page);

      const operator = await pageOf(browser, server, world.admin, "/admin");
      await operator.page.getByRole("button", { name: "Take over bench-1" }).click();
      const dialog = operator.page.getByRole("dialog");
      assert.deepEqual(await axe(operator.page), []);
      await dialog.getByLabel("Reason").fill("the motor is hot");
      await dialog.getByRole("button", { name: /^Take over/ }).click();
      await operator.page
        .getByRole("complementary", { name: "My lab" })
        .getByText("bench-1 ends in")
        .waitFor();
      await waitForReview(one.page);
      await one.page.goto(`${server.url}/my`);
      await one.page.getByRole("listitem").filter({ hasText: "the motor is hot" }).waitFor();
      await operator.page.reload();
      await operator.page.getByText(/took over the session/).waitFor();
      await one.close();
      await operator.close();
    },
  );

  story(
    "an instructor watches a student of the course without commanding, and commands after taking over",
    async () => {
      const teacher = await world.user("prof", "Prof", "instructor");
      const stranger = await world.user("other", "Other", "instructor");
      await world.course(teacher, "Diagnosis", [students[2]]);
      const one = await pageOf(browser, server, students[2], "/my");
      await one.page.getByText("from Prof").waitFor();
      assert.deepEqual(await axe(one.page), []);
      await one.page.getByRole("button", { name: "Join the course, Diagnosis" }).click();
      await one.page.getByText("Invitations to courses").waitFor({ state: "detached" });
      await runOnBench(one.page);

      const none = await pageOf(browser, server, stranger, "/teach");
      await none.page.getByText(/^None of your students uses a rig now/).waitFor();
      await none.close();

      const two = await pageOf(browser, server, teacher, "/teach");
      await two.page.getByRole("link", { name: "Watch bench-1" }).click();
      await two.page.getByText("You are watching.").first().waitFor();
      await two.page.locator("#set-R1[disabled]").waitFor();
      assert.equal(await two.page.locator("#set-R1:not([disabled])").count(), 0);
      assert.deepEqual(await axe(two.page), []);

      await two.page.getByRole("link", { name: "Teach" }).click();
      await two.page.getByRole("button", { name: "Take over bench-1" }).click();
      const dialog = two.page.getByRole("dialog");
      await dialog.getByLabel("Reason").fill("the hour is over");
      await dialog.getByRole("button", { name: /^Take over/ }).click();
      const bar = two.page.getByRole("complementary", { name: "My lab" });
      await bar.getByText("bench-1 ends in").waitFor();
      await waitForReview(one.page);
      await runHeld(two.page);
      await one.close();
      await two.close();
    },
  );

  /** Uses the rig of the user's session, and commands it. */
  async function runHeld(page) {
    await page.goto(`${server.url}/my`);
    await page.getByRole("link", { name: "Use the rig" }).click();
    await page.getByRole("button", { name: "Run this experiment" }).click();
    await page.waitForURL(/\/lab\/.+/);
    await page.locator("#set-R1:not([disabled])").waitFor();
  }
});
