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
  mesh: string;
  vertices: number;
  faces: number;
  regions: number;
  lambda: Maybe;
  mass: string;
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
  svg: string;
  stem: string;
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

/** The report written into the page, or null in the bare template. */
export function readReport(): Report | null {
  const text = document.getElementById("report-data")?.textContent?.trim() ?? "";
  // The placeholder of the bare template is a comment, and no JSON starts with one.
  if (text === "" || text.startsWith("/*")) return null;
  return new Report(JSON.parse(text) as ReportData);
}
