// Bundles src/ into dist/template.html, one file that needs nothing else, and writes LICENSES.txt of what is inside.

import { createHash } from "node:crypto";
import { existsSync } from "node:fs";
import { mkdir, readFile, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const root = dirname(fileURLToPath(import.meta.url));
const PLACEHOLDER = "/*REPORT_DATA*/";

const common = { absWorkingDir: root, bundle: true, minify: true, write: false, legalComments: "none", logLevel: "warning" };
const script = await build({ ...common, entryPoints: ["src/main.ts"], format: "iife", target: "es2022", charset: "utf8", metafile: true });
const style = await build({ ...common, entryPoints: ["src/style/main.css"], outdir: "dist", charset: "utf8" });
const js = script.outputFiles[0].text.trim();
const licenses = await licensesOf(script.metafile);

let page = await readFile(join(root, "src/index.html"), "utf8");
for (const [mark, text] of Object.entries({
  HASH: `sha256-${createHash("sha256").update(js).digest("base64")}`,
  STYLE: style.outputFiles[0].text.trim(),
  LICENSES: licenses.replaceAll("&", "&amp;").replaceAll("<", "&lt;"),
  SCRIPT: js,
})) {
  // A function, because `$` means something in a replacement text.
  page = page.replace(`{{${mark}}}`, () => text);
}
if (page.split(PLACEHOLDER).length !== 2) throw new Error(`${PLACEHOLDER} must occur once in the template`);
if (/<\/script/i.test(js)) throw new Error("the script would end its own element");

await mkdir(join(root, "dist"), { recursive: true });
await writeFile(join(root, "dist/template.html"), page);
await writeFile(join(root, "LICENSES.txt"), licenses);
console.log(`dist/template.html  ${(Buffer.byteLength(page) / 1024).toFixed(0)} KiB`);

/** The license of every package of which at least one byte is in the bundle. */
async function licensesOf({ outputs }) {
  const inputs = Object.values(outputs).flatMap((output) => Object.entries(output.inputs));
  const names = new Set();
  for (const [path, { bytesInOutput }] of inputs) {
    const name = path.match(/^node_modules\/((?:@[^/]+\/)?[^/]+)\//)?.[1];
    if (name && bytesInOutput > 0) names.add(name);
  }
  const parts = [...names].sort().map(async (name) => {
    const folder = join(root, "node_modules", name);
    const { version, license } = JSON.parse(await readFile(join(folder, "package.json"), "utf8"));
    const file = ["LICENSE", "LICENSE.txt", "LICENSE.md"].map((file) => join(folder, file)).find(existsSync);
    if (!file) throw new Error(`${name} comes without a license text`);
    return `${name} ${version} (${license})\n\n${(await readFile(file, "utf8")).trim()}\n`;
  });
  return (await Promise.all(parts)).join(`\n${"-".repeat(80)}\n\n`);
}
