// A report in a real browser: the file $REPORT_HTML, or one with artificial data. Expected values are read from the
// data in the page; sections without data are skipped.

import assert from "node:assert/strict";
import { mkdtemp, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { after, before, describe, test } from "node:test";
import { chromium, download, launch, open, picture, reveal, settle, share, shot } from "./browser.mjs";
import { fixture } from "./fixture.mjs";
import { page as fill } from "./page.mjs";

const missing = chromium() ? false : "chromium is not on the PATH and CHROMIUM is not set";

describe("a report", { skip: missing }, () => {
  let browser, page, complaints, data, file;

  before(async () => {
    file = process.env.REPORT_HTML && resolve(process.env.REPORT_HTML);
    if (!file) {
      file = join(await mkdtemp(join(tmpdir(), "report-")), "report.html");
      await writeFile(file, await fill(fixture()));
    }
    browser = await launch();
    ({ page, complaints } = await open(browser, file));
    data = await page.$eval("#report-data", (element) => JSON.parse(element.textContent));
  });
  after(() => browser?.close());

  const text = (selector) => page.$eval(selector, (element) => element.textContent);
  const press = async (selector) => {
    await page.$eval(selector, (element) => element.scrollIntoView({ block: "center", behavior: "instant" }));
    await (await page.$(selector)).click();
    await settle(page);
  };
  const choose = (label, value) => press(`[role=group][aria-label="${label}"] button[data-value="${value}"]`);
  const lines = () => page.$$eval("#curves .line", (paths) => paths.map((path) => path.getAttribute("d")));
  const groups = () => page.$$eval("#curves .curves > g", (all) => all.map((one) => one.dataset.solver));
  /** A test of a section, skipped if the report does not have it. */
  const on = (id, name, step) =>
    test(name, async (t) => {
      if (!(await page.$(`#${id}`))) return t.skip(`this report has no section ${id}`);
      await reveal(page, id);
      await step();
    });

  test("opens with its question, origin and warnings", async () => {
    assert.equal(await text("h1"), data.question || data.name);
    const head = await text("header");
    assert.ok(head.includes(data.program));
    for (const machine of data.machines) assert.ok(head.includes(machine.cpu));
    const starts = data.runs.flatMap((run) => run.manifest.start ?? []);
    assert.equal(/Made\D+\d{1,2}, \d{4}/.test(head), starts.length > 0);
    const notices = (await page.$$eval(".notice", (all) => all.map((one) => one.textContent))).join("\n");
    assert.equal(notices.includes("Loaded machine"), data.runs.some((run) => run.loaded));
    const first = data.machines.find((machine) => machine.first);
    const elsewhere = first !== undefined && data.runs.some((run) => run.machine !== first.id);
    assert.equal(notices.includes("another machine"), elsewhere);
  });

  on("summary", "summarizes every instance", async () => {
    assert.equal((await page.$$("#summary .card")).length >= 2, true);
    if (!(await page.$("#target"))) return;
    const rows = () => page.$$eval("#summary tbody tr", (all) => all.map((row) => row.textContent));
    assert.equal((await rows()).length, Math.min(100, data.instances.length));
    const loosest = await page.$eval("#target", (select) => select.options[1].value);
    await page.select("#target", loosest);
    for (const row of await rows()) assert.ok(row.includes("1e-1"), row);
    await page.select("#target", "tightest");
  });

  on("curves", "changes both axes and both scales", async () => {
    const drawn = new Set([String(await lines())]);
    const different = async (what) => {
      const now = String(await lines());
      assert.ok(!drawn.has(now), `${what} does not change the curves`);
      drawn.add(now);
    };
    await choose("x scale", "linear");
    await different("a linear x axis");
    await choose("y scale", "linear");
    await different("a linear y axis");
    await choose("x", "seconds");
    await different("seconds");
    assert.match(await text("#curves svg"), /seconds in the solver/);
    await choose("x scale", "log");
    await choose("y scale", "log");
    await shot(page, "seconds", ".chart");
    await choose("x scale", "linear");
    await choose("y scale", "linear");
    await choose("y", "energy");
    await different("energy");
    assert.match(await text("#curves svg"), /energy/);
    await shot(page, "energy", ".chart");
    await choose("y", "suboptimality");
    assert.match(await text("#curves svg"), /suboptimality/);
    await choose("y", "relative_gap");
    await choose("y scale", "log");
    await choose("x", "iteration");
    await choose("x scale", "log");
    assert.ok(drawn.has(String(await lines())), "the original settings restore the first drawing");
    if (await page.$('[aria-label="repetitions"]')) {
      await choose("repetitions", "every");
      assert.ok((await lines()).length > (await groups()).length);
      await choose("repetitions", "median");
    }
  });

  on("curves", "hides and isolates solvers without moving the others", async () => {
    const all = await groups();
    const entry = (id) => `.entry[data-solver="${id}"]`;
    const first = all[0];
    const others = (await lines()).slice(1);
    await press(entry(first));
    assert.deepEqual(await groups(), all.slice(1));
    assert.deepEqual(await lines(), others);
    assert.equal(await page.$eval(entry(first), (button) => button.getAttribute("aria-pressed")), "false");
    await press(entry(first));
    assert.deepEqual(await groups(), all);
    const last = all.at(-1);
    await (await page.$(entry(last))).click({ count: 2 });
    await settle(page);
    assert.deepEqual(await groups(), [last]);
    if (all.length > 1) await press(".legend > .plain");
    assert.deepEqual(await groups(), all);
    await page.keyboard.down("Alt");
    await press(entry(first));
    await page.keyboard.up("Alt");
    assert.deepEqual(await groups(), [first]);
    if (all.length > 1) await press(".legend > .plain");
    assert.deepEqual(await groups(), all);
  });

  /** The position of the midpoint of a curve in the window. */
  const onCurve = () =>
    page.$eval("#curves .line", (path) => {
      const point = path.getPointAtLength(path.getTotalLength() / 2);
      const box = path.ownerSVGElement.getBoundingClientRect();
      return { x: box.left + point.x, y: box.top + point.y };
    });

  on("curves", "reads the sample under the pointer and by arrow keys", async () => {
    await page.$eval(".plot", (plot) => plot.scrollIntoView({ block: "center", behavior: "instant" }));
    const { x, y } = await onCurve();
    await page.mouse.move(x, y);
    await settle(page);
    const tip = await text(".tip:not([hidden])");
    assert.match(tip, /relative gap\d\.\d\de[-+]\d+iteration[\d,]+seconds[\d.e-]+ srun[0-9a-z]+/);
    assert.ok(data.solvers.some(({ label }) => tip.startsWith(label)), tip);
    await shot(page, "tooltip", ".chart");
    await page.mouse.move(2, 2);
    await settle(page);
    assert.equal(await page.$(".tip:not([hidden])"), null);
    await page.focus(".plot");
    await page.keyboard.press("ArrowRight");
    const one = await text(".tip");
    await page.keyboard.press("ArrowRight");
    assert.notEqual(await text(".tip"), one);
    await page.$eval(".plot", (plot) => plot.blur());
  });

  on("curves", "zooms by drag and back", async () => {
    const whole = String(await lines());
    const { x, y } = await onCurve();
    await page.mouse.move(x - 60, y - 60);
    await page.mouse.down();
    await page.mouse.move(x + 20, y + 20, { steps: 4 });
    await page.mouse.move(x + 60, y + 60);
    await page.mouse.up();
    await settle(page);
    assert.notEqual(String(await lines()), whole);
    await shot(page, "zoomed", ".chart");
    await press('#curves .actions button:not([data-action])');
    assert.equal(String(await lines()), whole);
  });

  on("curves", "saves the chart as SVG", async () => {
    const { name, text: svg } = await download(page, () => press('[data-action="save-chart"]'));
    assert.match(name, /\.svg$/);
    assert.match(svg, /^<svg xmlns="http:\/\/www.w3.org\/2000\/svg"/);
    assert.doesNotMatch(svg, /<image|foreignObject|NaN|undefined/);
    assert.equal(svg.match(/class="line"/g).length, (await groups()).length);
    for (const id of await groups()) {
      const { label } = data.solvers.find((solver) => solver.id === id);
      assert.ok(svg.includes(`>${label.replaceAll("&", "&amp;")}</text>`), `no ${label} in the legend`);
    }
  });

  on("curves", "finds an instance by its label", async () => {
    const input = "#curves [role=combobox]";
    const target = data.instances.at(-1);
    await page.click(input);
    assert.equal((await page.$$("#curves [role=option]")).length, data.instances.length);
    await page.type(input, target.label);
    await page.keyboard.press("Enter");
    await settle(page);
    assert.equal(await page.$eval(input, (field) => field.value), target.label);
    assert.ok((await text("#curves .facts")).includes(target.mesh));
    await page.$eval(input, (field) => field.blur());
  });

  on("figures", "shows and saves the figures", async () => {
    const shown = await page.$$eval(".paper", (all) => all.map((one) => one.shadowRoot.querySelector("svg")?.getBoundingClientRect().height ?? 0));
    assert.equal(shown.length, data.figures.length);
    for (const height of shown) assert.ok(height > 50);
    const captions = await page.$$eval("#figures figcaption p", (all) => all.map((one) => one.textContent));
    assert.deepEqual(captions, data.figures.map((one) => one.caption).filter(Boolean));
    const saved = await download(page, () => press("#figures figcaption button"));
    assert.deepEqual(saved, { name: `${data.figures[0].stem}.svg`, text: data.figures[0].svg });
  });

  on("tables", "sorts numbers first, then texts, then missing cells", async () => {
    for (const [t, { columns, rows }] of data.tables.entries()) {
      const section = `#tables .sub:nth-child(${t + 1})`;
      const shownOrder = async () => {
        await page.evaluate(() => { navigator.clipboard.writeText = async (text) => { window.copied = text; }; });
        await press(`${section} .table-tools .plain`);
        return page.evaluate(() => window.copied);
      };
      for (const [c, column] of columns.entries()) {
        const values = rows.map((row) => row[c]);
        const numbers = values.filter((cell) => typeof cell === "number").sort((a, b) => a - b);
        const nothing = values.filter((cell) => cell === null).length;
        for (const direction of ["ascending", "descending"]) {
          await press(`${section} th:nth-child(${c + 1}) button`);
          assert.equal(await page.$eval(`${section} th:nth-child(${c + 1})`, (th) => th.getAttribute("aria-sort")), direction);
          const cells = await page.$$eval(`${section} tbody td:not(.nothing):nth-child(${c + 1})`, (all) => all.map((td) => td.title || td.textContent));
          assert.equal(cells.length, Math.min(100, rows.length));
          if (rows.length > 100 || !column.numeric) continue;
          const wanted = direction === "ascending" ? numbers : numbers.toReversed();
          const copied = csvColumn(await shownOrder(), c).slice(1);
          assert.deepEqual(copied.slice(0, numbers.length).map(Number), wanted, column.label);
          assert.ok(copied.slice(copied.length - nothing).every((cell) => cell === ""), column.label);
          assert.ok(cells.slice(cells.length - nothing).every((cell) => cell === "no value"), column.label);
        }
        await press(`${section} th:nth-child(${c + 1}) button`);
      }
      assert.equal((await shownOrder()).split("\r\n").length, rows.length + 2);
    }
  });

  on("viewer", "shows data, labels, uncertainty and differences of every solver", async () => {
    const instance = data.instances.find(({ scene }) => scene !== null && data.scenes[scene]);
    const { solutions } = data.scenes[instance.scene];
    const solved = data.solvers.filter(({ id }) => solutions[id]);
    const look = () => picture(page, "#viewer canvas");
    const isRed = (r, g, b) => r > 90 && g < 0.45 * r && b < 0.45 * r;
    const seen = new Set();
    for (const mode of ["data", "labels", "uncertainty", "difference"]) {
      await choose("Show", mode);
      const image = await look();
      assert.ok(!seen.has(image), `${mode} looks the same as another mode`);
      seen.add(image);
      await shot(page, `viewer-${mode}`, "#viewer .viewer");
    }
    assert.equal((await page.$$('#viewer [aria-label="Solver"] button')).length, solved.length);
    if (solved.length < 2) return;

    const labels = (id) => Buffer.from(solutions[id].labels, "base64");
    const distance = (a, b) => labels(a).reduce((sum, label, v) => sum + (label === labels(b)[v] ? 0 : 1), 0);
    for (const a of solved) {
      await choose("Solver", a.id);
      for (const b of solved) {
        await choose("Compared with", b.id);
        const count = distance(a.id, b.id);
        assert.ok((await text(".difference")).startsWith(`${count.toLocaleString("en-US")} vert`));
        const red = await share(page, await look(), isRed);
        if (count === 0) assert.equal(red, 0);
        if (count > 0.02 * instance.vertices) assert.ok(red > 0, "differences are not red");
      }
    }
    await choose("Show", "labels");
    await choose("Solver", solved[0].id);
    const first = await look();
    const far = solved.find(({ id }) => distance(solved[0].id, id) > 0.02 * instance.vertices);
    if (far) {
      await choose("Solver", far.id);
      assert.notEqual(await look(), first);
      await choose("Solver", solved[0].id);
      assert.equal(await look(), first, "the camera stays");
    }
  });

  on("viewer", "turns, zooms and returns", async () => {
    const look = async () => (await settle(page), picture(page, "#viewer canvas"));
    await page.$eval("#viewer canvas", (canvas) => canvas.scrollIntoView({ block: "center", behavior: "instant" }));
    const start = await look();
    const box = await (await page.$("#viewer canvas")).boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width / 2 + 120, box.y + box.height / 2 + 40, { steps: 5 });
    await page.mouse.up();
    const turned = await look();
    assert.notEqual(turned, start);
    await page.mouse.wheel({ deltaY: -400 });
    const zoomed = await look();
    assert.notEqual(zoomed, turned);
    await page.keyboard.press("ArrowLeft");
    assert.notEqual(await look(), zoomed);
    await press("#viewer .actions button");
    await page.$eval("#viewer canvas", (canvas) => canvas.scrollIntoView({ block: "center", behavior: "instant" }));
    await page.mouse.move(2, 2);
    assert.equal(await look(), start);
  });

  on("runs", "lists the runs and opens a manifest", async () => {
    assert.equal((await page.$$("#runs tbody tr")).length, Math.min(100, data.runs.length));
    const repetitions = await page.$$eval("#runs tbody tr td:nth-child(4)", (all) => all.map((one) => Number(one.textContent)));
    assert.equal(Math.min(...repetitions), 1);
    // Statuses are explained where they are shown.
    const meanings = await text("#runs");
    for (const status of new Set(data.runs.map((run) => run.status))) {
      if (status !== "converged") assert.ok(meanings.includes(`“${status}”: `), status);
    }
    await press("#runs tbody tr:first-child td:nth-child(2)");
    const opened = await text("#runs .manifest");
    for (const [key, value] of Object.entries(data.runs[0].manifest)) {
      assert.ok(opened.includes(key));
      if (typeof value === "string") assert.ok(opened.includes(value), `${key} is not shown unchanged`);
    }
    await shot(page, "manifest", "#runs");
    await page.focus("#runs .opener");
    await page.keyboard.press("Enter");
    assert.equal(await page.$("#runs .manifest"), null);
  });

  test("fits the window, light and dark, wide and narrow", async () => {
    for (const [name, width, scheme] of [["light", 1280, "light"], ["dark", 1280, "dark"], ["narrow", 800, "light"]]) {
      const other = await open(browser, file, { width, scheme });
      for (const id of await other.page.$$eval("main > section", (all) => all.map((one) => one.id))) await reveal(other.page, id);
      const { scroll, window: wide } = await other.page.evaluate(() => ({ scroll: document.documentElement.scrollWidth, window: innerWidth }));
      assert.ok(scroll <= wide, `${name}: ${scroll} pixels in a window of ${wide}`);
      // Figures have no white background in the dark theme, and no legend is longer than its chart.
      const papers = await other.page.$$eval(".paper", (all) =>
        all.flatMap((one) => [...one.shadowRoot.querySelectorAll("[fill]")].map((part) => part.getAttribute("fill").toLowerCase())));
      if (scheme === "dark") assert.ok(!papers.includes("#ffffff") && !papers.includes("#222222"), `${name}: ${papers}`);
      const legends = await other.page.$$eval(".legend-list", (all) => all.map((one) => one.clientHeight));
      for (const height of legends) assert.ok(height <= 480, `${name}: a legend of ${height} pixels`);
      await other.page.evaluate(() => scrollTo({ top: 0, behavior: "instant" }));
      await shot(other.page, name);
      assert.deepEqual(other.complaints, []);
      await other.page.close();
    }
  });

  test("causes no errors and no network requests", () => {
    assert.deepEqual(complaints, []);
  });
});

/** One column of CSV text; cells are quoted only where they must be. */
function csvColumn(csv, column) {
  return csv.trimEnd().split("\r\n").map((line) => {
    const cells = line.match(/("(?:[^"]|"")*"|[^,]*)(?:,|$)/g).map((cell) => cell.replace(/,$/, "").replace(/^"|"$/g, ""));
    return cells[column];
  });
}
