// A headless Chromium and what a test needs of it: complaints, downloads, screenshots, pixels.

import { existsSync } from "node:fs";
import { mkdir, mkdtemp, readdir, readFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { delimiter, join } from "node:path";
import { pathToFileURL } from "node:url";
import puppeteer from "puppeteer-core";

/** WebGL without a graphics card. */
const FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars"];

/** The browser of the environment or of the PATH, or null. */
export function chromium() {
  const named = process.env.CHROMIUM;
  if (named) return named;
  const found = (process.env.PATH ?? "").split(delimiter).map((folder) => join(folder, "chromium"));
  return found.find(existsSync) ?? null;
}

export function launch() {
  return puppeteer.launch({ executablePath: chromium(), headless: true, args: FLAGS });
}

/** Opens a file; everything the page complains about or asks the network for is listed in `complaints`. */
export async function open(browser, file, { width = 1280, height = 900, scheme = "light", before } = {}) {
  const page = await browser.newPage();
  const complaints = [];
  page.on("console", (message) => {
    if (["error", "warn", "warning"].includes(message.type())) complaints.push(`console: ${message.text()}`);
  });
  page.on("pageerror", (error) => complaints.push(`exception: ${error.message}`));
  page.on("requestfailed", (request) => complaints.push(`failed: ${request.url().slice(0, 80)}`));
  page.on("request", (request) => {
    const address = request.url();
    const own = address.startsWith(pathToFileURL(file).href) || /^(data|blob):/.test(address);
    if (!own) complaints.push(`request: ${address}`);
  });
  await page.setViewport({ width, height });
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
  if (before) await page.evaluateOnNewDocument(before);
  await page.goto(pathToFileURL(file).href);
  return { page, complaints };
}

/** Scrolls a section into the window and waits until it is built. */
export async function reveal(page, id) {
  await page.evaluate((id) => document.getElementById(id).scrollIntoView({ behavior: "instant" }), id);
  await page.waitForFunction((id) => !document.getElementById(id).classList.contains("waiting"), {}, id);
  await settle(page);
}

/** Two frames: what a click asked for has been laid out and painted. */
export function settle(page) {
  return page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 60)))));
}

/** What `action` downloads: name and text. */
export async function download(page, action) {
  const folder = await mkdtemp(join(tmpdir(), "report-"));
  const session = await page.createCDPSession();
  await session.send("Browser.setDownloadBehavior", { behavior: "allow", downloadPath: folder, eventsEnabled: true });
  const done = new Promise((resolve) => {
    session.on("Browser.downloadProgress", ({ state }) => {
      if (state === "completed") resolve();
    });
  });
  await action();
  await done;
  const [name] = await readdir(folder);
  return { name, text: await readFile(join(folder, name), "utf8") };
}

/** Into the folder SHOTS, if there is one. The whole page, or an element. */
export async function shot(page, name, selector) {
  const folder = process.env.SHOTS;
  if (!folder) return;
  await mkdir(folder, { recursive: true });
  const path = join(folder, `${name}.png`);
  if (selector) await (await page.$(selector)).screenshot({ path });
  else await page.screenshot({ path, fullPage: true });
}

/** Share of the pixels of an element that are of a kind, `kind` being the text of a function of r, g, b. */
export async function pixels(browser, page, selector, kind) {
  const image = await (await page.$(selector)).screenshot({ encoding: "base64" });
  const blank = await blankPage(browser);
  const share = await blank.evaluate(
    async (image, kind) => {
      const picture = new Image();
      picture.src = `data:image/png;base64,${image}`;
      await picture.decode();
      const canvas = new OffscreenCanvas(picture.width, picture.height);
      const context = canvas.getContext("2d");
      context.drawImage(picture, 0, 0);
      const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
      const is = new Function("r", "g", "b", `return ${kind}`);
      let count = 0;
      for (let i = 0; i < data.length; i += 4) if (is(data[i], data[i + 1], data[i + 2])) count++;
      return (4 * count) / data.length;
    },
    image,
    kind,
  );
  return { share, image };
}

/** Where pictures are looked at: the page that a browser starts with. */
async function blankPage(browser) {
  const [first] = await browser.pages();
  return first;
}
