// The page of a figure of surfaces in a real browser: the file $FIGURE_HTML, or one with artificial data.

import assert from "node:assert/strict";
import { mkdtemp, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { after, before, describe, test } from "node:test";
import { chromium, launch, open, picture, settle, share, shot } from "./browser.mjs";
import { figure } from "./figure.mjs";
import { page as fill } from "./page.mjs";

const missing = chromium() ? false : "chromium is not on the PATH and CHROMIUM is not set";

describe("a figure of surfaces", { skip: missing }, () => {
  let browser, page, complaints, data, file;

  before(async () => {
    file = process.env.FIGURE_HTML && resolve(process.env.FIGURE_HTML);
    if (!file) {
      file = join(await mkdtemp(join(tmpdir(), "figure-")), "figure.html");
      await writeFile(file, await fill({ figure: figure() }));
    }
    browser = await launch();
    ({ page, complaints } = await open(browser, file));
    data = await page.$eval("#report-data", (element) => JSON.parse(element.textContent).figure);
    await settle(page);
  });
  after(() => browser?.close());

  /** The panels as pictures: what each canvas holds, whether or not it is in the window. */
  const look = async () => {
    await settle(page);
    return page.$$eval(".panels canvas", (all) => all.map((one) => one.toDataURL().split(",")[1]));
  };
  /** The share of the pixels of a panel that are not transparent, which decode as black. */
  const covered = (image) => share(page, image, (r, g, b) => r + g + b > 0);

  test("shows every panel with its headings, caption and key", async () => {
    const panels = await look();
    assert.equal(panels.length, data.panels.length);
    const text = await page.$eval("main", (main) => main.textContent);
    for (const part of [data.title, ...data.column_headings, ...data.row_headings, ...data.panels.map((panel) => panel.caption)]) {
      assert.ok(text.includes(part), `${part} is missing`);
    }
    for (const [i, image] of panels.entries()) {
      const part = await covered(image);
      if (data.panels[i].surface === null) assert.equal(part, 0);
      else assert.ok(part > 0.1 && part < 0.95, `panel ${i} covers ${part}`);
    }
    const ranges = data.panels.filter(({ bar }) => bar?.range).length;
    assert.equal((await page.$$(".panels .ramp")).length, ranges);
    await shot(page, "figure");
  });

  test("turns and zooms all surfaces together, and returns", async () => {
    const start = await look();
    const changed = async (before, what) => {
      const now = await look();
      for (const [i, image] of now.entries()) {
        if (data.panels[i].surface !== null) assert.notEqual(image, before[i], `${what} does not change panel ${i}`);
      }
      return now;
    };
    const box = await (await page.$(".panels canvas")).boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 60, y + 25, { steps: 5 });
    await page.mouse.up();
    const turned = await changed(start, "dragging");
    await shot(page, "figure-turned");
    const height = () => page.evaluate(() => scrollY);
    const before = await height();
    await page.mouse.wheel({ deltaY: -300 });
    const zoomed = await changed(turned, "the wheel");
    assert.equal(await height(), before, "the wheel scrolls the page");
    await page.focus(".panels");
    await page.keyboard.press("ArrowLeft");
    const left = await changed(zoomed, "an arrow key");
    await page.keyboard.press("-");
    await changed(left, "minus");
    await page.click(".actions button");
    assert.deepEqual(await look(), start);
  });

  test("fits the window, light and dark, wide and narrow", async () => {
    for (const [name, width, scheme] of [["figure-dark", 1280, "dark"], ["figure-narrow", 700, "light"]]) {
      const other = await open(browser, file, { width, scheme });
      await settle(other.page);
      const { scroll, window: wide } = await other.page.evaluate(() => ({ scroll: document.documentElement.scrollWidth, window: innerWidth }));
      assert.ok(scroll <= wide, `${name}: ${scroll} pixels in a window of ${wide}`);
      await shot(other.page, name);
      assert.deepEqual(other.complaints, []);
      await other.page.close();
    }
  });

  test("says what is missing without WebGL", async () => {
    const before = () => { HTMLCanvasElement.prototype.getContext = () => null; };
    const other = await open(browser, file, { before });
    assert.match(await other.page.$eval(".empty:not([hidden])", (message) => message.textContent), /no WebGL/);
    assert.deepEqual(other.complaints, []);
    await other.page.close();
  });

  test("causes no errors and no network requests", async () => {
    assert.ok((await picture(page, "main")).length > 0);
    assert.deepEqual(complaints, []);
  });
});
