// A report with artificial but plausible numbers, the same at every call: four solvers, three repetitions, two
// instances, two machines, a run on a loaded machine, missing values, two figures and a torus to view.

const SOLVERS = [
  { id: "s0", label: "chambolle-pock", rate: 0.16, step: 1.0e-3 },
  { id: "s1", label: "douglas-rachford", rate: 0.34, step: 2.7e-3 },
  { id: "s2", label: "fista epsilon=1e-6", rate: 0.022, step: 0.8e-3 },
  { id: "s3", label: "projected-gradient", rate: 0.006, step: 0.7e-3 },
];
const INSTANCES = [
  { id: "i0", label: "torus:48x28, 4 regions, lambda 0.005", mesh: "torus:48x28", vertices: 1344, faces: 2688, regions: 4, lambda: 0.005, scene: "g0", best: 0.3674 },
  { id: "i1", label: "bunny.ply, 3 regions, lambda 0.02", mesh: "bunny.ply", vertices: 34834, faces: 69451, regions: 3, lambda: 0.02, scene: null, best: 0.1291 },
];
const REPETITIONS = 3;
const LIMIT = 1500;

/** Random numbers in [0, 1). G. Marsaglia, *Xorshift RNGs*, 2003. */
function random(seed) {
  let state = seed * 2654435761 >>> 0 || 1;
  return () => {
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    return (state >>> 0) / 2 ** 32;
  };
}

export function fixture() {
  const runs = [];
  INSTANCES.forEach((instance, i) =>
    SOLVERS.forEach((solver, s) => {
      for (let repetition = 0; repetition < REPETITIONS; repetition++) runs.push(run(instance, i, solver, s, repetition));
    }),
  );
  return {
    name: "energy-decay",
    question: "How fast does the certified gap of each solver fall?",
    program: "meshseg 0.1.0",
    written: "2026-11-22T08:00:00Z",
    machines: [
      { id: "m1", cpu: "Example CPU 9000 @ 3.00 GHz", cores: 2, memory_gib: 23.4, first: true },
      { id: "m2", cpu: "Other CPU 100", cores: 8, memory_gib: 62.7, first: false },
    ],
    solvers: SOLVERS.map(({ id, label }, style) => ({ id, label, style })),
    instances: INSTANCES.map(({ best, ...instance }) => ({
      ...instance,
      mass: "barycentric",
      best_bound: best * (1 - 2e-6),
      best_energy: best,
    })),
    runs,
    tables: [seconds(runs), { title: "An empty table", columns: [{ label: "nothing", numeric: false }], rows: [] }],
    figures: [
      { title: "Decay of the gap over iterations", caption: "Medians of 3 runs.", svg: figure("#0072b2"), stem: "decay-iterations" },
      { title: "Decay of the gap over seconds", caption: "", svg: figure("#d55e00"), stem: "decay-seconds" },
    ],
    scenes: { g0: torus(48, 28) },
  };
}

function run(instance, i, solver, s, repetition) {
  const next = random(1 + repetition + 10 * s + 100 * i);
  const noise = random(7 + s + 100 * i);
  const slow = 1 + 0.25 * next();
  const rate = solver.rate * (i === 1 ? 0.55 : 1);
  const trace = { iteration: [], seconds: [], energy: [], relative_gap: [], suboptimality: [] };
  let gap = 1;
  let iteration = 0;
  for (; iteration <= LIMIT && gap > 1e-5; iteration += iteration < 40 ? 2 : iteration < 300 ? 10 : 50) {
    // Geometric with a slow tail; the same in every repetition, as for a deterministic method.
    gap = 0.9 * Math.exp(-rate * iteration) + 0.02 / (1 + iteration) ** (1.4 + 4 * rate) * (0.75 + 0.5 * noise());
    const sub = gap * 0.4 - (gap < 1.5e-5 ? 1e-5 : 0);
    trace.iteration.push(iteration);
    trace.seconds.push(iteration * solver.step * slow * (i === 1 ? 14 : 1) * (1 + 0.05 * next()));
    trace.relative_gap.push(iteration === 0 ? null : gap);
    trace.suboptimality.push(s === 3 ? null : sub);
    trace.energy.push(instance.best * (1 + Math.max(0, gap * 0.4)));
  }
  const last = trace.iteration.length - 1;
  const broken = i === 1 && s === 3 && repetition === 2;
  return {
    id: (0xab12cd34 + runNumber(i, s, repetition) * 0x01357911 >>> 0).toString(16),
    instance: instance.id,
    solver: solver.id,
    repetition,
    machine: i === 1 && repetition === 2 ? "m2" : "m1",
    loaded: i === 0 && s === 1 && repetition === 1,
    status: broken ? "diverged" : gap <= 1e-5 ? "converged" : "iteration-limit",
    iterations: trace.iteration[last],
    seconds: broken ? null : trace.seconds[last],
    energy: broken ? null : trace.energy[last],
    dual_bound: broken ? null : trace.energy[last] * (1 - gap),
    relative_gap: broken ? null : trace.relative_gap[last],
    manifest: { start: `2026-11-2${repetition}T23:30:00.000Z`, commit: "571a3a9c0ffee", spec: "experiments/energy-decay.toml", seed: 7, threads: 2, precision: "f64", note: "a < b & \"quoted\" </script>" },
    trace: broken ? { iteration: [0], seconds: [0], energy: [null], relative_gap: [null], suboptimality: [null] } : trace,
  };
}

function runNumber(i, s, repetition) {
  return (i * SOLVERS.length + s) * REPETITIONS + repetition;
}

function seconds(runs) {
  return {
    title: "Seconds to a certified gap",
    columns: [{ label: "instance", numeric: false }, { label: "gap", numeric: true }, ...SOLVERS.map(({ label }) => ({ label, numeric: true }))],
    rows: INSTANCES.flatMap(({ id, label }) =>
      [1e-2, 1e-3, 1e-4].map((gap) => [
        label,
        gap,
        ...SOLVERS.map((solver, s) => {
          const { trace } = runs.find((run) => run.instance === id && run.solver === solver.id);
          const at = trace.relative_gap.findIndex((value) => value !== null && value <= gap);
          if (at >= 0) return trace.seconds[at];
          return s === 3 ? null : `> 60 (gap ${trace.relative_gap.at(-1).toExponential(0)})`;
        }),
      ]),
    ),
  };
}

/** Both figures use the same id and class, like figures drawn by the same program. */
function figure(color) {
  return (
    '<svg xmlns="http://www.w3.org/2000/svg" width="640" height="360" viewBox="0 0 640 360"><style>.line { fill: none; stroke: ' + color +
    '; stroke-width: 3 }</style><clipPath id="c"><rect x="60" y="20" width="560" height="290"/></clipPath>' +
    '<rect width="640" height="360" fill="#fff"/><path d="M60 20V310H620" fill="none" stroke="#555"/>' +
    '<g clip-path="url(#c)"><path class="line" d="M60 40C160 200 260 260 620 300"/></g>' +
    '<text x="340" y="345" font-family="sans-serif" font-size="16" text-anchor="middle">iterations</text></svg>'
  );
}

function base64(array) {
  return Buffer.from(array.buffer).toString("base64");
}

function torus(around, across) {
  const vertices = around * across;
  const positions = new Float32Array(3 * vertices);
  const faces = new Uint32Array(6 * vertices);
  const palette = [[0.337, 0.706, 0.914], [0.902, 0.624, 0], [0, 0.62, 0.451], [0.8, 0.475, 0.655]];
  const data = new Uint8Array(3 * vertices);
  const next = random(5);
  const index = (i, j) => (i % around) * across + (j % across);
  const angles = [];
  for (let i = 0; i < around; i++) {
    for (let j = 0; j < across; j++) {
      const a = (2 * Math.PI * i) / around;
      const b = (2 * Math.PI * j) / across;
      const v = index(i, j);
      angles[v] = a + 0.35 * Math.sin(b);
      positions.set([(1 + 0.4 * Math.cos(b)) * Math.cos(a), (1 + 0.4 * Math.cos(b)) * Math.sin(a), 0.4 * Math.sin(b)], 3 * v);
      faces.set([v, index(i + 1, j), index(i + 1, j + 1), v, index(i + 1, j + 1), index(i, j + 1)], 6 * v);
    }
  }
  const region = (angle) => Math.floor(((angle / (2 * Math.PI)) % 1 + 1) % 1 * 4);
  angles.forEach((angle, v) => {
    data.set(palette[region(angle)].map((value) => Math.min(255, Math.max(0, 255 * value + 90 * (next() - 0.5)))), 3 * v);
  });
  const solution = (shift) => {
    const labels = new Uint8Array(vertices);
    const certainty = new Uint8Array(vertices);
    angles.forEach((angle, v) => {
      const place = (((angle + shift) / (Math.PI / 2)) % 1 + 1) % 1;
      labels[v] = region(angle + shift);
      certainty[v] = Math.round(255 * Math.min(1, 0.5 + 4 * Math.min(place, 1 - place)));
    });
    return { labels: base64(labels), certainty: base64(certainty) };
  };
  return {
    positions: base64(positions),
    faces: base64(faces),
    data: base64(data),
    palette,
    // The last solver has no labels.
    view: { towards: [0.4, -1, 0.9], up: [0, 0, 1] },
    solutions: { s0: solution(0), s1: solution(0.02), s2: solution(0.3) },
  };
}
