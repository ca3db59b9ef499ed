// The data of a report: the format that the Rust program writes into the page, and look-ups shared by the sections.

/** A number, or null if it was not reached, is infinite or was not recorded. */
export type Maybe = number | null;
export type Cell = string | number | null;

export interface Machine {
  id: string;
  cpu: string;
  cores: number;
  memory_gib: number;
  first: boolean;
}

export interface Solver {
  id: string;
  label: string;
  /** Position in the palette and in the list of dashes. */
  style: number;
}

export interface Instance {
  id: string;
  label: string;
  mesh: string | null;
  vertices: number;
  faces: number;
  regions: number;
  lambda: Maybe;
  mass: string | null;
  best_bound: Maybe;
  best_energy: Maybe;
  scene: string | null;
}

export interface Trace {
  iteration: Maybe[];
  seconds: Maybe[];
  energy: Maybe[];
  relative_gap: Maybe[];
  suboptimality: Maybe[];
  /** Of surfaces that evolve, as the next two. */
  distance?: Maybe[];
  mislabeled?: Maybe[];
  silhouette_iou?: Maybe[];
}

export interface Run {
  id: string;
  instance: string;
  solver: string;
  repetition: number;
  machine: string;
  loaded: boolean;
  status: string;
  iterations: Maybe;
  seconds: Maybe;
  energy: Maybe;
  dual_bound: Maybe;
  relative_gap: Maybe;
  manifest: Record<string, unknown>;
  trace: Trace;
}

export interface TableData {
  title: string;
  columns: { label: string; numeric: boolean }[];
  rows: Cell[][];
}

export interface FigureData {
  title: string;
  /** What the title does not say; may be empty. */
  caption: string;
  svg: string;
  stem: string;
  /** The page on which its surfaces can be turned, if it has some. */
  surfaces: string | null;
}

export interface Solution {
  labels: string;
  certainty: string;
}

/** Directions in the mesh's axes: toward the viewer, and up. */
export interface ViewData {
  towards: [number, number, number];
  up: [number, number, number];
}

export interface SceneData {
  /** The scene that holds its positions and faces, if they are not in this one. */
  mesh?: string;
  positions?: string;
  faces?: string;
  data: string;
  palette: [number, number, number][];
  solutions: Record<string, Solution>;
  /** The program's default view, if it provides one. */
  view?: ViewData;
}

/** A surface of a figure: 16 bits for each coordinate, from -1 to 1, and for each index. */
export interface FigureSurface {
  positions: string;
  faces: string;
  /** The number of vertices before it was coarsened for the page. */
  vertices: number;
  view: ViewData;
}

/** A color bar: with a range, a map from numbers to colors; without, a color for each region. */
export interface BarData {
  colors: [number, number, number][];
  range?: [number, number];
  label?: string;
}

export interface PanelData {
  /** The index of its surface; null if there is nothing to show. */
  surface: number | null;
  colors: string;
  /** The region of each vertex, if the panel has a cut. */
  labels: string | null;
  /** Whether colors change at the cut instead of between vertices. */
  sharp: boolean;
  /** The color of the cut. */
  cut: [number, number, number] | null;
  caption: string;
  bar: BarData | null;
}

/** A figure of surfaces, row by row. */
export interface SurfaceFigure {
  title: string;
  program: string;
  columns: number;
  column_headings: string[];
  row_headings: string[];
  /** Whether each row is one surface on its way, with the columns on a slider. */
  film?: boolean;
  panels: PanelData[];
  surfaces: (FigureSurface | null)[];
}

export interface ReportData {
  name: string;
  question: string;
  program: string;
  written: string;
  machines: Machine[];
  solvers: Solver[];
  instances: Instance[];
  runs: Run[];
  tables: TableData[];
  figures: FigureData[];
  scenes: Record<string, SceneData>;
}

/** The data with look-ups. */
export class Report {
  readonly first: Machine | undefined;
  private readonly byInstance = new Map<string, Run[]>();
  private readonly solvers: Map<string, Solver>;
  private readonly instances: Map<string, Instance>;

  constructor(readonly data: ReportData) {
    this.first = data.machines.find((machine) => machine.first) ?? data.machines[0];
    this.solvers = new Map(data.solvers.map((solver) => [solver.id, solver]));
    this.instances = new Map(data.instances.map((instance) => [instance.id, instance]));
    for (const run of data.runs) {
      const runs = this.byInstance.get(run.instance);
      if (runs) runs.push(run);
      else this.byInstance.set(run.instance, [run]);
    }
  }

  runsOf(instance: string, solver: string): Run[] {
    return (this.byInstance.get(instance) ?? []).filter((run) => run.solver === solver);
  }

  solverLabel(id: string): string {
    return this.solvers.get(id)?.label ?? id;
  }

  instanceLabel(id: string): string {
    return this.instances.get(id)?.label ?? id;
  }

  /** Whether the times of a run can be compared: times from different machines cannot. */
  hasComparableTime(run: Run): boolean {
    return this.first === undefined || run.machine === this.first.id;
  }
}

/** The report or the figure written into the page, or null in the bare template. */
export function readData(): Report | SurfaceFigure | null {
  const text = document.getElementById("report-data")?.textContent?.trim() ?? "";
  // The placeholder of the bare template is a comment, and no JSON starts with one.
  if (text === "" || text.startsWith("/*")) return null;
  const data = JSON.parse(text) as ReportData | { figure: SurfaceFigure };
  return "figure" in data ? data.figure : new Report(data);
}
