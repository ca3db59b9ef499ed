// The template as a file, without a browser.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { readFile } from "node:fs/promises";
import { test } from "node:test";
import { fixture } from "./fixture.mjs";
import { page } from "./page.mjs";

const html = await readFile(new URL("../dist/template.html", import.meta.url), "utf8");

test("the placeholder occurs exactly once", () => {
  assert.equal(html.split("/*REPORT_DATA*/").length, 2);
  assert.ok(html.includes('<script id="report-data" type="application/json">/*REPORT_DATA*/</script>'));
});

test("the template is small and loads nothing from the network", () => {
  assert.ok(html.length < 1 << 20, `${html.length} bytes`);
  assert.doesNotMatch(html, /(?:src|href)="?https?:|@import|url\(["']?https?:/);
});

test("the policy allows only the script of the page", () => {
  const script = html.match(/<script>([\s\S]*)<\/script>/)[1];
  const hash = createHash("sha256").update(script).digest("base64");
  assert.ok(html.includes(`script-src 'sha256-${hash}'`));
});

test("the page contains the licenses of LICENSES.txt", async () => {
  const licenses = await readFile(new URL("../LICENSES.txt", import.meta.url), "utf8");
  assert.ok(html.includes(licenses.replaceAll("&", "&amp;").replaceAll("<", "&lt;")));
});

test("data in the page are unchanged, and the artificial data are reproducible", async () => {
  const filled = await page(fixture());
  assert.deepEqual(JSON.parse(filled.match(/type="application\/json">([\s\S]*?)<\/script>/)[1]), fixture());
});
