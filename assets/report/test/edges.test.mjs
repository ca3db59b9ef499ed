// Edge cases of a report: no data, no scene, no WebGL, very many runs.

import assert from "node:assert/strict";
import { mkdtemp, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import { fileURLToPath } from "node:url";
import { chromium, launch, open, picture, reveal, settle, share } from "./browser.mjs";
import { fixture } from "./fixture.mjs";
import { page as fill } from "./page.mjs";

const missing = chromium() ? false : "chromium is not on the PATH and CHROMIUM is not set";

describe("edge cases of a report", { skip: missing }, () => {
  let browser, folder;

  before(async () => {
    folder = await mkdtemp(join(tmpdir(), "report-"));
    browser = await launch();
  });
  after(() => browser?.close());

  async function show(name, data, options) {
    const file = join(folder, `${name}.html`);
    await writeFile(file, await fill(data));
    return open(browser, file, options);
  }
  const sections = (page) => page.$$eval("main > section", (all) => all.map((one) => one.id));
  const revealAll = async (page) => {
    for (const id of await sections(page)) await reveal(page, id);
  };

  test("the bare template explains itself", async () => {
    const { page, complaints } = await open(browser, fileURLToPath(new URL("../dist/template.html", import.meta.url)));
    assert.match(await page.$eval("main", (main) => main.textContent), /template of a report/);
    assert.deepEqual(complaints, []);
  });

  test("with empty lists only the header remains", async () => {
    const empty = { machines: [], solvers: [], instances: [], runs: [], tables: [], figures: [], scenes: {} };
    const { page, complaints } = await show("empty", { ...fixture(), ...empty });
    assert.deepEqual(await sections(page), []);
    assert.deepEqual(complaints, []);
  });

  test("a report without any recorded value or scene has its other sections", async () => {
    const data = fixture();
    for (const instance of data.instances) Object.assign(instance, { scene: null, best_bound: null, best_energy: null, lambda: null });
    for (const run of data.runs) {
      Object.assign(run, { seconds: null, energy: null, dual_bound: null, relative_gap: null, iterations: null, manifest: {} });
      for (const key of Object.keys(run.trace)) run.trace[key] = run.trace[key].map(() => null);
    }
    const { page, complaints } = await show("nothing", { ...data, figures: [], tables: [] });
    await revealAll(page);
    assert.deepEqual(await sections(page), ["summary", "curves", "runs"]);
    assert.match(await page.$eval("#curves .empty", (element) => element.textContent), /No run of this instance/);
    assert.deepEqual(complaints, []);
  });

  test("text that looks like markup stays text", async () => {
    const question = 'Is <b>a</b> </script><img src=x onerror="window.hit = 1"> & b safe?';
    const { page, complaints } = await show("markup", { ...fixture(), question });
    assert.equal(await page.$eval("h1", (element) => element.textContent), question);
    assert.equal(await page.evaluate(() => window.hit), undefined);
    assert.deepEqual(complaints, []);
  });

  test("without WebGL the viewer reports it and the rest works", async () => {
    const before = () => {
      const real = HTMLCanvasElement.prototype.getContext;
      HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
        return kind.startsWith("webgl") ? null : real.call(this, kind, ...rest);
      };
    };
    const { page, complaints } = await show("no-webgl", fixture(), { before });
    await revealAll(page);
    assert.match(await page.$eval("#viewer", (element) => element.textContent), /no WebGL/);
    assert.ok((await page.$$("#curves .line")).length > 0);
    assert.deepEqual(complaints, []);
  });

  test("the camera stays when the instance changes", async () => {
    const data = fixture();
    // The second instance shows the same mesh, ten times as large and translated.
    const scene = data.scenes.g0;
    const positions = new Float32Array(new Uint8Array(Buffer.from(scene.positions, "base64")).buffer).map((x) => 10 * x + 50);
    data.scenes.g1 = { ...scene, positions: Buffer.from(positions.buffer).toString("base64") };
    data.instances[1].scene = "g1";
    const { page, complaints } = await show("two-scenes", data);
    await reveal(page, "viewer");
    await page.focus("#viewer canvas");
    for (let i = 0; i < 5; i++) await page.keyboard.press("ArrowLeft");
    const pink = async () => share(page, await picture(page, "#viewer canvas"), (r, g, b) => r > 1.3 * g && b > 1.1 * g);
    await settle(page);
    const turned = await pink();
    const input = "#viewer [role=combobox]";
    await page.click(input);
    await page.type(input, "bunny");
    await page.keyboard.press("Enter");
    await settle(page);
    const switched = await pink();
    await page.$eval("#viewer .actions button", (button) => button.click());
    await settle(page);
    const reset = await pink();
    assert.ok(Math.abs(switched - turned) < 1e-3, `${turned} of the picture before, ${switched} after`);
    assert.ok(Math.abs(reset - turned) > 1e-2, "the rotation is too small to detect");
    assert.deepEqual(complaints, []);
  });

  test("two hundred runs of a thousand samples open quickly", async () => {
    const data = fixture();
    const model = data.runs[0];
    data.runs = Array.from({ length: 200 }, (_, r) => {
      const iteration = Array.from({ length: 1000 }, (_, i) => i);
      const relative_gap = iteration.map((i) => Math.exp(-i / (60 + r)) + 1e-7);
      const trace = {
        iteration,
        relative_gap,
        seconds: iteration.map((i) => i * 1e-3 * (1 + (r % 5) / 10)),
        energy: relative_gap,
        suboptimality: relative_gap,
      };
      return { ...model, id: `run${r}`, solver: `s${r % 4}`, instance: r < 100 ? "i0" : "i1", repetition: Math.floor(r / 4) % 25, trace };
    });
    const start = Date.now();
    const { page, complaints } = await show("many", data);
    const opened = Date.now() - start;
    await reveal(page, "curves");
    await page.$eval(".plot", (plot) => plot.scrollIntoView({ block: "center", behavior: "instant" }));
    const hover = await page.evaluate(() => {
      const plot = document.querySelector(".plot");
      const box = plot.getBoundingClientRect();
      const start = performance.now();
      plot.dispatchEvent(new PointerEvent("pointermove", { clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 }));
      return performance.now() - start;
    });
    await reveal(page, "runs");
    assert.equal((await page.$$("#runs tbody tr")).length, 100);
    await page.click("#runs .table > .plain");
    assert.equal((await page.$$("#runs tbody tr")).length, 200);
    // Generous, since test machines are busy.
    assert.ok(opened < 6000, `opened in ${opened} ms`);
    assert.ok(hover < 250, `a pointer move takes ${hover} ms`);
    assert.deepEqual(complaints, []);
  });
});
