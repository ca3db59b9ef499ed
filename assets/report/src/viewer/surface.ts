// A scene as arrays, decoded when it is first shown.

import type { SceneData, ViewData } from "../data";

export interface Answer {
  /** The region of each vertex. */
  labels: Uint8Array;
  /** The largest entry of each row of U; 255 is 1. */
  certainty: Uint8Array;
}

export interface Surface {
  positions: Float32Array;
  faces: Uint32Array;
  /** Red, green, blue of each vertex. */
  data: Uint8Array;
  palette: [number, number, number][];
  vertices: number;
  view: ViewData;
  answer(solver: string): Answer | null;
}

/** From the front and a little above, for meshes with y up. */
const DEFAULT_VIEW: ViewData = { towards: [0.45, 0.5, 1], up: [0, 1, 0] };

export function bytes(text: string): Uint8Array<ArrayBuffer> {
  const binary = atob(text);
  const result = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) result[i] = binary.charCodeAt(i);
  return result;
}

export function surfaceOf(scene: SceneData, scenes: Record<string, SceneData>): Surface {
  const mesh = (scene.mesh !== undefined && scenes[scene.mesh]) || scene;
  const positions = new Float32Array(bytes(mesh.positions ?? "").buffer);
  const answers = new Map<string, Answer>();
  return {
    positions,
    faces: new Uint32Array(bytes(mesh.faces ?? "").buffer),
    data: bytes(scene.data),
    palette: scene.palette,
    vertices: positions.length / 3,
    view: scene.view ?? DEFAULT_VIEW,
    answer(solver) {
      const known = answers.get(solver);
      if (known) return known;
      const solution = scene.solutions[solver];
      if (!solution) return null;
      const answer = { labels: bytes(solution.labels), certainty: bytes(solution.certainty) };
      answers.set(solver, answer);
      return answer;
    },
  };
}
