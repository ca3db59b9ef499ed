// The page: a header, and a section for each kind of data that is present.

import { readData, Report } from "./data";
import { h } from "./dom";
import { buildWhenNear } from "./lazy";
import { charts } from "./sections/charts";
import { figures } from "./sections/figures";
import { header } from "./sections/header";
import { panels } from "./sections/panels";
import { runs } from "./sections/runs";
import { summary } from "./sections/summary";
import { tables } from "./sections/tables";
import { viewer } from "./sections/viewer";

interface Section {
  id: string;
  title: string;
  present: boolean;
  build: (report: Report) => Node;
}

function sections({ data }: Report): Section[] {
  const hasRuns = data.instances.some((instance) => data.runs.some((run) => run.instance === instance.id));
  const hasScenes = data.instances.some((instance) => instance.scene !== null && data.scenes[instance.scene]);
  return [
    { id: "summary", title: "Summary", present: hasRuns, build: summary },
    { id: "curves", title: "Convergence", present: hasRuns, build: charts },
    { id: "figures", title: "Figures", present: data.figures.length > 0, build: figures },
    { id: "tables", title: "Tables", present: data.tables.length > 0, build: tables },
    { id: "viewer", title: "Meshes", present: hasScenes, build: viewer },
    { id: "runs", title: "Runs", present: data.runs.length > 0, build: runs },
  ].filter((section) => section.present);
}

function show(report: Report): Node[] {
  document.title = `${report.data.name} – meshseg`;
  const present = sections(report);
  return [
    header(report),
    h("nav", { "aria-label": "Sections" }, ...present.map(({ id, title }) => h("a", { href: `#${id}` }, title))),
    ...present.map(({ id, title, build }) => {
      const section = h("section", { id, "aria-labelledby": `${id}-title` }, h("h2", { id: `${id}-title` }, title));
      buildWhenNear(section, () => build(report));
      return section;
    }),
  ];
}

function messagePage(title: string, text: string): Node[] {
  return [h("header", {}, h("h1", {}, title), h("p", {}, text))];
}

function page(): Node[] {
  try {
    const data = readData();
    if (data instanceof Report) return show(data);
    if (data) {
      document.title = `${data.title} – meshseg`;
      return panels(data);
    }
    return messagePage("A report without data", "This is the template of a report. The program inserts the data of an experiment.");
  } catch (error) {
    return messagePage("This page cannot be read", error instanceof Error ? error.message : String(error));
  }
}

document.querySelector("main")?.append(...page());
