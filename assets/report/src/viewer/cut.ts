// Surfaces with sharp cuts: a face with corners of different classes is split at the midpoints of its edges, since
// colors blended across it would not be those of any region.

export interface Painted {
  positions: Float32Array;
  normals: Float32Array;
  /** Bytes, like the input. */
  colors: Uint8Array;
  index: Uint32Array;
  /** The cut: the ends of its segments. */
  lines: Float32Array;
}

export interface Smooth {
  positions: Float32Array;
  normals: Float32Array;
  faces: Uint32Array;
}

/** The numbers of new corners and of faces for a face with three classes, which needs the most. */
const MAX_NEW_CORNERS = 9;
const MAX_FACES = 6;

export function cut({ positions, normals, faces }: Smooth, colors: Uint8Array, classes: Uint8Array): Painted {
  const corner = (at: number) => faces[at] ?? 0;
  const classAt = (at: number) => classes[corner(at)] ?? 0;
  let mixed = 0;
  for (let f = 0; f < faces.length; f += 3) {
    if (classAt(f) !== classAt(f + 1) || classAt(f) !== classAt(f + 2)) mixed++;
  }
  const vertices = positions.length / 3;
  const room = 3 * (vertices + MAX_NEW_CORNERS * mixed);
  const out = {
    positions: new Float32Array(room),
    normals: new Float32Array(room),
    colors: new Uint8Array(room),
    index: new Uint32Array(faces.length + 3 * (MAX_FACES - 1) * mixed),
  };
  out.positions.set(positions);
  out.normals.set(normals);
  out.colors.set(colors);
  let corners = vertices;
  let used = 0;
  const lines: number[] = [];

  const face = (a: number, b: number, c: number) => {
    out.index[used++] = a;
    out.index[used++] = b;
    out.index[used++] = c;
  };
  /** A new corner at the centroid of the given vertices, with the color of vertex `colorOf`. */
  const middle = (of: number[], colorOf: number) => {
    for (let axis = 0; axis < 3; axis++) {
      const mean = (values: Float32Array) => of.reduce((sum, v) => sum + (values[3 * v + axis] ?? 0), 0) / of.length;
      out.positions[3 * corners + axis] = mean(positions);
      out.normals[3 * corners + axis] = mean(normals);
      out.colors[3 * corners + axis] = colors[3 * colorOf + axis] ?? 0;
    }
    return corners++;
  };

  const segment = (a: number, b: number) => {
    for (const end of [a, b]) for (let axis = 0; axis < 3; axis++) lines.push(out.positions[3 * end + axis] ?? 0);
  };

  for (let f = 0; f < faces.length; f += 3) {
    const labels = [classAt(f), classAt(f + 1), classAt(f + 2)];
    // The corner whose two neighbors have the same class, or -1.
    const odd = [0, 1, 2].find((c) => labels[(c + 1) % 3] === labels[(c + 2) % 3]) ?? -1;
    const [k, i, j] = [0, 1, 2].map((c) => corner(f + ((Math.max(0, odd) + c) % 3))) as [number, number, number];
    if (odd >= 0 && classes[k] === classes[i]) {
      face(corner(f), corner(f + 1), corner(f + 2));
    } else if (odd >= 0) {
      face(middle([k, i], k), middle([j, k], k), k);
      const near = middle([k, i], i);
      const far = middle([j, k], i);
      face(i, j, far);
      face(i, far, near);
      segment(near, far);
    } else {
      for (const [at, next, last] of [[k, i, j], [i, j, k], [j, k, i]] as const) {
        const center = middle([i, j, k], at);
        const side = middle([at, next], at);
        face(at, side, center);
        segment(side, center);
        face(at, center, middle([last, at], at));
      }
    }
  }
  return {
    positions: out.positions.subarray(0, 3 * corners),
    normals: out.normals.subarray(0, 3 * corners),
    colors: out.colors.subarray(0, 3 * corners),
    index: out.index.subarray(0, used),
    lines: Float32Array.from(lines),
  };
}
