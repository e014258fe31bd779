// A blind exercise: a teacher gives it to a course, a student answers, both see what came of it.
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { makeWorld, PASSWORD, pageOf } from "./lab_world.js";
import {
  axe,
  launchBrowser,
  openPage,
  SUITE_MS,
  startServer,
  story,
  until,
  waitForReview,
} from "./support.js";

describe("course", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;
  let teacher;
  let ann;
  let bob;
  let course;

  before(async () => {
    server = await startServer({ speed: 20 });
    browser = await launchBrowser();
    world = await makeWorld(server);
    teacher = await world.user("teacher", "A Teacher", "instructor");
    ann = await world.user("ann", "Ann Student", "student");
    bob = await world.user("bob", "Bob Student", "student");
    course = await world.course(teacher, "Diagnosis", [ann, bob]);
    await world.join(ann, course);
    await world.join(bob, course);
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  story("a teacher brings a class in by its list and a sheet of links", async () => {
    await world.call(teacher, "POST", "/courses", { name: "Newcomers" });
    const desk = await pageOf(browser, server, teacher, "/teach");
    const { page } = desk;
    await page.getByRole("button", { name: "Add members, Newcomers" }).click();
    await page
      .getByRole("textbox", { name: /^Students, one per line/ })
      .fill("Nachname;Vorname;Matrikelnummer\nGroß;Jörg;RA 301/2026\nKiss;Anna;RA 302/2026\n");
    await page.getByRole("button", { name: "Look at the list first" }).click();
    await page
      .getByText("Taken for logins: “Matrikelnummer”, for names: “Vorname + Nachname”.")
      .waitFor();
    await page.getByRole("row", { name: "ra-301-2026 Jörg Groß gets an account" }).waitFor();
    assert.deepEqual(await axe(page), []);
    await page.getByRole("button", { name: "Add all 2" }).click();
    await page.getByText("2 students added").waitFor();
    await page.getByText("2 of this course have no password yet.").waitFor();
    await page.getByRole("button", { name: "Make their links" }).click();
    await page.getByRole("dialog").getByRole("button", { name: "Make their links" }).click();
    const file = page.getByRole("link", { name: "CSV", exact: true });
    const text = decodeURIComponent(await file.getAttribute("href"));
    const [, link] = /"ra-302-2026","Anna Kiss","([^"]+)"/.exec(text);
    assert.deepEqual(await axe(page), []);

    await page
      .getByRole("textbox", { name: /^Students, one per line/ })
      .fill("login;name\nmistake;Somebody else\nra-302-2026;Anna Kiss\n");
    await page.getByRole("button", { name: "Look at the list first" }).click();
    await page.getByRole("button", { name: "Add all 2" }).click();
    await page.getByText("Somebody else", { exact: false }).first().waitFor();
    await page.getByRole("button", { name: "Take the list back" }).click();
    await page.getByRole("dialog").getByRole("button", { name: "Take the list back" }).click();
    await page.getByText(/^Taken back: /).waitFor();
    await desk.close();

    const anna = await openPage(browser, link);
    await anna.page.getByText("For the account of Anna Kiss, login ra-302-2026.").waitFor();
    await anna.page.getByLabel("New password").fill(PASSWORD);
    await anna.page.getByLabel("Repeat the password").fill(PASSWORD);
    assert.deepEqual(await axe(anna.page), []);
    await anna.page.getByRole("button", { name: "Save and sign in" }).click();
    await anna.page.getByRole("heading", { name: "My lab" }).waitFor();
    await anna.page.getByRole("link", { name: "Anna Kiss" }).waitFor();
    await anna.close();
  });

  story("a teacher makes an exercise, a student diagnoses blind, both see the grade", async () => {
    const desk = await pageOf(browser, server, teacher, "/teach");
    const form = desk.page.getByRole("form", { name: "New exercise" });
    await form.getByLabel("Name").fill("Exercise 1");
    await form.getByRole("button", { name: "Publish it in the course" }).click();
    await form.getByText("Choose at least one component.").waitFor();
    await form.getByRole("button", { name: "The 18 published faults" }).click();
    await form.getByRole("row", { name: /^J / }).first().waitFor();
    await form.getByText(/^A perfect student gets about \d+\.\d of 100 points,/).waitFor();
    await form.getByRole("checkbox", { name: "only the published values" }).uncheck();
    await form.getByRole("button", { name: "Choose all, or none" }).click();
    await form.getByRole("button", { name: "Choose all, or none" }).click();
    await form.getByRole("checkbox", { name: /^R1 / }).check();
    await form.getByText("Each of these faults can be seen and told from all others.").waitFor();
    await form.getByText("1.43·10⁻⁸ kg·m², 1.43·10⁻⁵ kg·m², 1.43·10⁻⁴ kg·m²").waitFor();
    await form.getByRole("checkbox", { name: "only the published values" }).check();
    await form.getByText("1.43·10⁻⁸ kg·m², 1.43·10⁻⁴ kg·m²", { exact: true }).waitFor();
    await form.getByRole("checkbox", { name: /^R9 / }).check();
    await form.getByRole("row", { name: /^R9 .* R12$/ }).waitFor();
    await form.getByRole("checkbox", { name: /^R9 / }).uncheck();
    await form.getByLabel("Without a fault, %").fill("0");
    await form.getByLabel("Truth and grade").selectOption("answer");
    await form.getByText("How answers are graded").click();
    await form.getByLabel("Points off per hint").fill("10");
    await form.getByRole("button", { name: "Publish it in the course" }).click();
    await form.getByText("Exercise 1 is given to the course.").waitFor();
    await desk.page.getByRole("button", { name: "Save as a file, Exercise 1" }).waitFor(); // what is drawn from is a set, too
    assert.deepEqual(await axe(desk.page), []);

    const { page, close } = await pageOf(browser, server, ann, "/tasks");
    await page.getByText("0 of 3 attempts used").waitFor();
    assert.deepEqual(await axe(page), []);
    await page.getByRole("button", { name: "Begin, Exercise 1" }).click();
    const card = page.getByRole("region", { name: "Exercise 1" });
    await waitForReview(page);
    await card.getByText("What has failed in this run").waitFor();
    assert.equal(await page.getByRole("heading", { name: "Diagnosis" }).count(), 0);
    const shown = await page.getByRole("main").innerText();
    assert.doesNotMatch(shown, /R1 →|verdict/i, "nothing tells the fault");

    await card.getByRole("button", { name: "Hint: when? (−10 %)" }).click();
    await page.getByText("It costs 10 % of the points of this attempt.").waitFor();
    await page.getByRole("dialog").getByRole("button", { name: "Hint: when?" }).click();
    await card.getByText(/^Hint: the lab noticed something at [\d.]+ s\.$/).waitFor();
    assert.deepEqual(await axe(page), []);

    await card.getByRole("button", { name: "Answer" }).click();
    await card.getByText("Choose a component and give its value").waitFor();
    await card.getByRole("combobox").selectOption("R1");
    await card.getByLabel("Value, Ω").fill("47");
    await card.getByLabel("Its standard error, Ω (optional)").fill("2");
    await card.getByLabel("Why").fill("b0 has fallen,\na1 has not");
    await card.getByRole("button", { name: "Choose on the charts" }).click();
    await page.getByLabel("Time of cursor A, s").fill("8");
    await page.getByLabel("Time of cursor B, s").fill("9.5");
    await card.getByRole("button", { name: "Mark from A to B" }).click();
    await card.getByRole("button", { name: "Remove, 8.00–9.50 s" }).waitFor();
    await page.reload();
    await waitForReview(page);
    assert.equal(await card.getByLabel("Value, Ω").inputValue(), "47", "the draft is kept");
    await card.getByRole("button", { name: "Show it on the charts, 8.00–9.50 s" }).click();
    assert.deepEqual(await axe(page), []);
    await card.getByRole("button", { name: "Answer" }).click();
    await page.getByRole("dialog").getByRole("button", { name: "Answer: R1 → 47 Ω" }).click();
    await card.getByText(/of 100 points/).waitFor();
    await card.getByText("10 % of the points went for hints.").waitFor();
    // The run is open now: the lab's own verdict stands beside the grade.
    await page.locator(".heading").getByText(/R1/).waitFor();
    await card.getByText(/own diagnosis noticed it at .*It named R1 at/).waitFor();
    await card.getByText(/a1 has not/).waitFor();
    await card.getByText(/47.Ω.±.2.*Ω/).waitFor();
    await card.getByRole("button", { name: "Show it on the charts, 8.00–9.50 s" }).waitFor();
    await card.getByText("How the truth is sealed").click();
    await card.getByText(/printf '%s%s'/).waitFor();
    assert.deepEqual(await axe(page), []);
    await card.getByRole("link", { name: "All exercises" }).click();
    await page.getByText("1 of 3 attempts used").waitFor();
    await page.getByText(/of 100 points/).waitFor();
    await close();

    await desk.page.getByRole("button", { name: "Results, Exercise 1" }).click();
    const row = desk.page.getByRole("row", { name: /Ann Student|ann/ });
    await row.getByText("R1 → 47 Ω").waitFor();
    const faults = desk.page.getByRole("table", { name: /Rows are the true faults/ });
    await faults.getByText("100 %").waitFor();
    assert.deepEqual(await axe(desk.page), []);
    await row.getByRole("button", { name: /^Give points/ }).click();
    const award = desk.page.getByRole("form", { name: /^Give points/ });
    await award.getByLabel("Points").fill("95");
    await award.getByLabel("Why").fill("well argued");
    await award.getByRole("button", { name: "Save" }).click();
    await row.getByText("95.0*").waitFor();
    await desk.page
      .getByRole("combobox", { name: "More time for" })
      .selectOption({ label: "Ann Student" });
    const more = desk.page.getByRole("form", { name: /^More time for/ });
    await more.getByLabel(/^Due/).fill("2040-05-06T07:08");
    await more.getByRole("button", { name: "Save" }).click();
    await more.waitFor({ state: "detached" });
    await desk.page.getByRole("button", { name: "Edit Exercise 1" }).click();
    const terms = desk.page.getByRole("form", { name: "Edit Exercise 1" });
    await terms.getByLabel("Name").fill("Exercise A");
    await terms.getByText("How answers are graded").click();
    await terms.getByLabel("Value", { exact: true }).fill("0");
    await terms.getByRole("button", { name: "Save" }).click();
    await desk.page.getByText("Exercise A", { exact: true }).waitFor();
    await desk.page.getByRole("button", { name: "Copy Exercise A" }).click();
    const copy = desk.page.getByRole("form", { name: "Copy Exercise A" });
    await copy.getByLabel("Name").fill("Exercise B");
    await copy.getByRole("button", { name: "Publish it in the course" }).click();
    await desk.page.getByText("Exercise B", { exact: true }).waitFor();
    await form.getByLabel("Name").fill("Exercise C");
    await form.getByRole("combobox", { name: "Faults" }).selectOption({ label: "Exercise 1" });
    await form.getByText("Each of these faults can be seen and told from all others.").waitFor();
    await form.getByRole("button", { name: "Publish it in the course" }).click();
    await form.getByText("Exercise C is given to the course.").waitFor();
    await desk.page.reload();
    const keep = desk.page.getByRole("button", { name: "Save as a file, Exercise 1" });
    const [file] = await Promise.all([desk.page.waitForEvent("download"), keep.click()]);
    await desk.page.getByLabel("Take a set from a file (.json)").setInputFiles(await file.path());
    await until(
      () => keep.count(),
      (count) => count === 2,
    );
    assert.deepEqual(await axe(desk.page), []);

    await desk.page
      .getByText(/1 of 2 have answered, 1 have begun/)
      .first()
      .waitFor();

    const again = await pageOf(browser, server, ann, "/tasks");
    await again.page.getByText(/due Sun,? 6 May 2040, 07:08/).waitFor();
    await again.page.getByRole("link", { name: /\d\d:\d\d$/ }).click();
    await again.page.getByText(/A Teacher gave these points in place of .*: well argued/).waitFor();
    await again.close();
    await desk.close();
  });

  story("on a phone the answer is one press away", async () => {
    const { json: list } = await world.call(ann, "GET", "/assignments");
    const { json: trial } = await world.call(
      ann,
      "POST",
      `/assignments/${list.items[0].id}/trials`,
      {},
    );
    const { page, close } = await pageOf(browser, server, ann, `/runs/${trial.run}`, {
      viewport: { width: 390, height: 844 },
      hasTouch: true,
    });
    await waitForReview(page);
    const card = page.getByRole("region", { name: list.items[0].name });
    await page.getByRole("button", { name: "To the exercise" }).click();
    await until(
      () => card.getByRole("combobox").boundingBox(),
      (box) => box && box.y > 0 && box.y + box.height < 844,
    );
    assert.equal(await page.getByRole("button", { name: "Next run" }).count(), 0);
    assert.deepEqual(await axe(page), []);
    await close();
  });

  story("two students share an exercise", async () => {
    const { json: set } = await world.call(teacher, "POST", "/fault-sets", {
      name: "shared",
      course: course.id,
      bench: "paper",
      pool: { items: [{ component: "R1", values: [56], onset_from_s: 8 }], healthy_share: 0 },
    });
    await world.call(teacher, "POST", "/assignments", {
      course: course.id,
      fault_set: set.id,
      name: "Together",
      due: "2040-01-01T00:00:00Z",
      group_max: 2,
      plan: { duration_s: 12, free_excitation: true },
      rubric: { time_limit_min: 25 },
    });
    const one = await pageOf(browser, server, ann, "/tasks");
    const hers = one.page.getByRole("group", { name: "Group, Together" });
    await hers.getByRole("button", { name: "Form a group" }).click();
    const told = await hers.getByText(/Its code is/).innerText();
    const [, code] = /code is (\w+)/.exec(told);
    const two = await pageOf(browser, server, bob, "/tasks", { allow: /status of 400/ });
    const his = two.page.getByRole("group", { name: "Group, Together" });
    await his.getByLabel("Code of a group").fill("wrong");
    await his.getByRole("button", { name: "Join" }).click();
    await his.getByText("No group of this exercise has this code.").waitFor();
    await his.getByLabel("Code of a group").fill(code.toLowerCase());
    await his.getByRole("button", { name: "Join" }).click();
    await his.getByText(/Your group: Ann Student, Bob Student/).waitFor();
    assert.deepEqual(await axe(two.page), []);
    const item = one.page.getByRole("listitem").filter({ hasText: "Together" }).first();
    await item.locator("summary").click();
    await item.getByRole("combobox", { name: "Excitation" }).selectOption("multisine");
    await one.page.getByRole("button", { name: "Begin, Together" }).click();
    await waitForReview(one.page);
    await one.page.getByText(/Answer by .*:/).waitFor();
    await two.page.reload();
    await two.page.getByRole("link", { name: "Go on" }).click();
    await waitForReview(two.page);
    const card = two.page.getByRole("region", { name: "Together" });
    await card.getByRole("combobox").selectOption("healthy");
    await card.getByRole("button", { name: "Answer" }).click();
    await two.page
      .getByRole("dialog")
      .getByRole("button", { name: /^Answer/ })
      .click();
    await card.getByText(/Your answer was received/).waitFor();
    await one.page.reload();
    await one.page.getByText(/Your answer was received/).waitFor();
    await one.close();
    await two.close();
  });

  story(
    "a copy of a sealed record is not diagnosed, and the teacher sees who brought it",
    async () => {
      const { json: set } = await world.call(teacher, "POST", "/fault-sets", {
        name: "closed",
        course: course.id,
        bench: "paper",
        pool: {
          items: [{ component: "R1", values: [56], onset_from_s: 8 }],
          healthy_share: 0,
        },
      });
      const { json: task } = await world.call(teacher, "POST", "/assignments", {
        course: course.id,
        fault_set: set.id,
        name: "Closed room",
        due: "2040-01-01T00:00:00Z",
        plan: { duration_s: 12 },
      });
      const { json: trial } = await world.call(ann, "POST", `/assignments/${task.id}/trials`, {});
      await until(
        () => world.call(ann, "GET", `/trials/${trial.id}`),
        ({ json }) => json.state === "open",
      );
      const { page, close } = await pageOf(browser, server, bob, "/");
      const own = await pageOf(browser, server, ann, "/");
      const csv = await own.page.request.get(`${server.url}/api/v1/runs/${trial.run}/export.csv`);
      await page.setInputFiles('input[type="file"]', {
        name: "mine.csv",
        mimeType: "text/csv",
        buffer: await csv.body(),
      });
      const result = page.getByRole("status").filter({ hasText: "mine.csv" });
      await result.getByText("Sealed until the exercise is released").waitFor();
      await result.getByText(/a blind exercise that is still open/).waitFor();
      assert.deepEqual(await axe(page), []);
      await result.getByRole("link", { name: "Open" }).first().click();
      await page.getByText(/a blind exercise that is still open/).waitFor();
      assert.doesNotMatch(await page.locator("main").innerText(), /R1 ↑|56 Ω/);
      const desk = await pageOf(browser, server, teacher, "/teach");
      await desk.page.getByRole("button", { name: "Results, Closed room" }).click();
      await desk.page.getByText(/^Bob Student brought this record for a diagnosis/).waitFor();
      assert.deepEqual(await axe(desk.page), []);
      await close();
      await own.close();
      await desk.close();
    },
  );
});
