// The data of a report: what the Rust program writes into the page, and the few questions every section asks of it.

/** A number that may be missing: not reached, infinite or not recorded. */
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

/** Directions in the mesh's axes: to the viewer, and up. */
export interface ViewData {
  towards: [number, number, number];
  up: [number, number, number];
}

export interface SceneData {
  /** The scene whose positions and faces it has, if they are not its own. */
  mesh?: string;
  positions?: string;
  faces?: string;
  data: string;
  palette: [number, number, number][];
  solutions: Record<string, Solution>;
  /** Where the program would look from, if it says so. */
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

/** The data with its look-ups. */
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

  /** Whether the seconds of a run may be compared: seconds of different machines may not. */
  timed(run: Run): boolean {
    return this.first === undefined || run.machine === this.first.id;
  }
}

/** The report written into the page, or null in the bare template. */
export function readReport(): Report | null {
  const text = document.getElementById("report-data")?.textContent?.trim() ?? "";
  // The placeholder of the bare template is a comment, which no JSON begins with.
  if (text === "" || text.startsWith("/*")) return null;
  return new Report(JSON.parse(text) as ReportData);
}
