// The template filled with data, escaped as by the Rust program.

import { readFile } from "node:fs/promises";

const template = new URL("../dist/template.html", import.meta.url);

export async function page(data) {
  const json = JSON.stringify(data)
    .replaceAll("</", "<\\/")
    .replaceAll("\u2028", "\\u2028")
    .replaceAll("\u2029", "\\u2029");
  return (await readFile(template, "utf8")).replace("/*REPORT_DATA*/", () => json);
}
