// Bundles src/ into the self-contained file dist/template.html, and writes the licenses of its packages to LICENSES.txt.

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
  // A function, because `$` is special in a replacement string.
  page = page.replace(`{{${mark}}}`, () => text);
}
if (page.split(PLACEHOLDER).length !== 2) throw new Error(`${PLACEHOLDER} must occur exactly once in the template`);
if (/<\/script/i.test(js)) throw new Error("the script contains </script>, which would end its element");

await mkdir(join(root, "dist"), { recursive: true });
await writeFile(join(root, "dist/template.html"), page);
await writeFile(join(root, "LICENSES.txt"), licenses);
console.log(`dist/template.html  ${(Buffer.byteLength(page) / 1024).toFixed(0)} KiB`);

/** The licenses of all packages that contribute at least one byte to the bundle. */
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
    if (!file) throw new Error(`${name} has no license file`);
    return `${name} ${version} (${license})\n\n${(await readFile(file, "utf8")).trim()}\n`;
  });
  return (await Promise.all(parts)).join(`\n${"-".repeat(80)}\n\n`);
}
