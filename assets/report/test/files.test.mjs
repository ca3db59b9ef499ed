// What the program writes for browsers, opened by the loaders of three.js: the values are those of the arrays.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { PLYLoader } from "three/examples/jsm/loaders/PLYLoader.js";

const LABELED = process.env.LABELED;

async function bytes(...names) {
  const read = await readFile(join(LABELED, ...names));
  return read.buffer.slice(read.byteOffset, read.byteOffset + read.length);
}

/** The int32 numbers of an .npy file. */
async function integers(...names) {
  const file = await bytes(...names);
  const header = new DataView(file).getUint16(8, true);
  assert.match(Buffer.from(file, 10, header).toString(), /'<i4'/);
  return new Int32Array(file.slice(10 + header));
}

async function gltf(...names) {
  const loaded = await new GLTFLoader().parseAsync(await bytes(...names), "");
  const meshes = [];
  loaded.scene.traverse((node) => node.isMesh && meshes.push(node));
  assert.equal(meshes.length, 1);
  return meshes[0].geometry;
}

/** The corners of all faces, one after the other, as text. */
function corners({ index, attributes: { position } }) {
  const order = index ? Array.from(index.array) : Array.from({ length: position.count }, (_, v) => v);
  return order.map((v) => [position.getX(v), position.getY(v), position.getZ(v)].map((x) => x.toFixed(5)).join());
}

for (const on of ["vertices", "faces"]) {
  test(`labels of ${on}: .glb and .ply are opened by three.js`, async () => {
    const [glb, ply] = await Promise.all([
      gltf(on, "segmented.glb"),
      bytes(on, "segmented.ply").then((file) => new PLYLoader().parse(file)),
    ]);
    const labels = await integers(on, on === "faces" ? "face_labels.npy" : "labels.npy");
    const { index, attributes } = glb;
    const found = Array.from(index.array, (v) => attributes._label.getX(v));
    if (on === "faces") {
      assert.deepEqual(found, found.map((_, corner) => labels[Math.floor(corner / 3)]));
    } else {
      assert.deepEqual(Array.from(attributes._label.array, Number), Array.from(labels));
    }
    assert.deepEqual(corners(glb), corners(ply));
    assert.equal(attributes.color.count, attributes.position.count);
    // One color per label, and another one for each.
    const colors = new Map();
    found.forEach((label, corner) => {
      const v = index.getX(corner);
      const color = [0, 1, 2].map((i) => attributes.color.getComponent(v, i)).join();
      colors.set(label, (colors.get(label) ?? new Set()).add(color));
    });
    const all = [...colors.values()].flatMap((of) => [...of]);
    assert.equal(all.length, colors.size);
    assert.equal(new Set(all).size, colors.size);
    assert.ok(colors.size > 1);
  });
}
