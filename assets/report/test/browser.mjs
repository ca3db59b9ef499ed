// Headless Chromium and utilities for tests: errors, downloads, screenshots, pixels.

import { existsSync } from "node:fs";
import { mkdir, mkdtemp, readdir, readFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { delimiter, join } from "node:path";
import { pathToFileURL } from "node:url";
import puppeteer from "puppeteer-core";

/** WebGL without a graphics card, and without the watchdog, which would give up drawing on a loaded machine. */
const FLAGS = [
  "--no-sandbox",
  "--use-gl=angle",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--disable-gpu-watchdog",
  "--hide-scrollbars",
];

/** The browser from $CHROMIUM or the PATH, or null. */
export function chromium() {
  const named = process.env.CHROMIUM;
  if (named) return named;
  const found = (process.env.PATH ?? "").split(delimiter).map((folder) => join(folder, "chromium"));
  return found.find(existsSync) ?? null;
}

export function launch() {
  return puppeteer.launch({ executablePath: chromium(), headless: true, args: FLAGS, protocolTimeout: 60_000 });
}

/** Opens a file; `complaints` lists all errors and warnings of the page and its network requests. */
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

/** Waits for two frames, after which the effects of a click have been laid out and painted. */
export function settle(page) {
  return page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 60)))));
}

/** The name and text of the file that `action` downloads. */
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

/** Saves a screenshot of the whole page or of an element in the folder $SHOTS, if it is set. */
export async function shot(page, name, selector) {
  const folder = process.env.SHOTS;
  if (!folder) return;
  await mkdir(folder, { recursive: true });
  const path = join(folder, `${name}.png`);
  if (selector) await (await page.$(selector)).screenshot({ path });
  else await page.screenshot({ path, fullPage: true });
}

/** An element as a picture: PNG in base64. */
export async function picture(page, selector) {
  return (await page.$(selector)).screenshot({ encoding: "base64" });
}

/**
 * The share of the pixels of a picture for which `kind`, a self-contained function of r, g, b, is true. The picture is
 * decoded as a bitmap in the front page: neither waits for a frame, which a background page may never draw.
 */
export function share(page, image, kind) {
  const count = async (image, kind) => {
    const bytes = Uint8Array.from(atob(image), (character) => character.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) if (kind(data[i], data[i + 1], data[i + 2])) count++;
    return (4 * count) / data.length;
  };
  return page.evaluate(`(${count})(${JSON.stringify(image)}, ${kind})`);
}
