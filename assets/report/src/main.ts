// The page: a header, and a section for everything there is data for.

import { readReport, type Report } from "./data";
import { h } from "./dom";
import { whenNear } from "./lazy";
import { charts } from "./sections/charts";
import { figures } from "./sections/figures";
import { header } from "./sections/header";
import { runs } from "./sections/runs";
import { summary } from "./sections/summary";
import { tables } from "./sections/tables";
import { viewer } from "./sections/viewer";

interface Section {
  id: string;
  title: string;
  any: boolean;
  build: (report: Report) => Node;
}

function sections({ data }: Report): Section[] {
  const ran = data.instances.some((instance) => data.runs.some((run) => run.instance === instance.id));
  const seen = data.instances.some((instance) => instance.scene !== null && data.scenes[instance.scene]);
  return [
    { id: "summary", title: "Summary", any: ran, build: summary },
    { id: "curves", title: "Convergence", any: ran, build: charts },
    { id: "figures", title: "Figures", any: data.figures.length > 0, build: figures },
    { id: "tables", title: "Tables", any: data.tables.length > 0, build: tables },
    { id: "viewer", title: "Meshes", any: seen, build: viewer },
    { id: "runs", title: "Runs", any: data.runs.length > 0, build: runs },
  ].filter((section) => section.any);
}

function show(report: Report): Node[] {
  document.title = `${report.data.name} – meshseg`;
  const present = sections(report);
  return [
    header(report),
    h("nav", { "aria-label": "Sections" }, ...present.map(({ id, title }) => h("a", { href: `#${id}` }, title))),
    ...present.map(({ id, title, build }) => {
      const section = h("section", { id, "aria-labelledby": `${id}-title` }, h("h2", { id: `${id}-title` }, title));
      whenNear(section, () => build(report));
      return section;
    }),
  ];
}

function alone(title: string, text: string): Node[] {
  return [h("header", {}, h("h1", {}, title), h("p", {}, text))];
}

function page(): Node[] {
  try {
    const report = readReport();
    if (report) return show(report);
    return alone("A report without data", "This is the template of a report: the program writes the data of an experiment into it.");
  } catch (error) {
    return alone("This report cannot be read", error instanceof Error ? error.message : String(error));
  }
}

document.querySelector("main")?.append(...page());
