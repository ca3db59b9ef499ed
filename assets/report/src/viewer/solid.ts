// A surface in the unit ball, upright and seen from its front, with colors at its vertices.

import {
  BufferAttribute, BufferGeometry, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, Quaternion,
  Sphere, Vector3,
} from "three";
import type { ViewData } from "../data";
import { cut, type Smooth } from "./cut";

const UP = new Vector3(0, 1, 0);

/** From sRGB bytes to linear light, which the renderer uses. */
const LINEAR_FROM_SRGB = Float32Array.from({ length: 256 }, (_, byte) => {
  const value = byte / 255;
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
});

export interface Shape {
  positions: Float32Array;
  faces: Uint32Array;
  view: ViewData;
  /** Whether it keeps its place in the unit ball; otherwise it fills the ball. */
  placed?: boolean;
}

export interface Solid {
  object: Group;
  /** Shows a shape; returns the direction from which it is to be seen. */
  show(shape: Shape): Vector3;
  /** Paints vertex colors, blended over faces or, if classes are given, cut between vertices of different classes. */
  paint(colors: Uint8Array, classes: Uint8Array | null): void;
  /** Draws the cut between vertices of different classes in a color, bytes. */
  outline(classes: Uint8Array, color: readonly [number, number, number]): void;
}

export function solid(): Solid {
  const geometry = new BufferGeometry();
  // Both sides, since the inside of a scanned surface can be visible through holes. Behind its lines.
  const material = new MeshLambertMaterial({
    vertexColors: true, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
  });
  const object = new Group();
  object.add(new Mesh(geometry, material));

  let smooth: Smooth;
  const put = (positions: Float32Array, normals: Float32Array, index: Uint32Array, colors: Uint8Array) => {
    // The renderer keeps the buffers of a geometry until it is disposed.
    geometry.dispose();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("normal", new BufferAttribute(normals, 3));
    geometry.setAttribute("color", new BufferAttribute(Float32Array.from(colors, (byte) => LINEAR_FROM_SRGB[byte] ?? 0), 3));
    geometry.setIndex(new BufferAttribute(index, 1));
  };

  return {
    object,
    show({ positions, faces, view, placed }) {
      geometry.setAttribute("position", new BufferAttribute(positions, 3));
      geometry.setIndex(new BufferAttribute(faces, 1));
      geometry.deleteAttribute("normal");
      geometry.computeVertexNormals();
      geometry.computeBoundingSphere();
      smooth = { positions, faces, normals: geometry.getAttribute("normal").array as Float32Array };
      // Every surface is scaled to the unit ball, upright, and has its viewer in the plane of y and z, so that one
      // camera suits all.
      const sphere = placed ? new Sphere(new Vector3(), 1) : geometry.boundingSphere;
      const scale = sphere && sphere.radius > 0 ? 1 / sphere.radius : 1;
      const turn = new Quaternion().setFromUnitVectors(new Vector3(...view.up).normalize(), UP);
      const towards = new Vector3(...view.towards).applyQuaternion(turn);
      const ahead = new Quaternion().setFromAxisAngle(UP, -Math.atan2(towards.x, towards.z));
      turn.premultiply(ahead);
      object.scale.setScalar(scale);
      object.quaternion.copy(turn);
      object.position.copy(sphere?.center ?? new Vector3()).applyQuaternion(turn).multiplyScalar(-scale);
      return towards.applyQuaternion(ahead);
    },
    paint(colors, classes) {
      if (!classes) return put(smooth.positions, smooth.normals, smooth.faces, colors);
      const pieces = cut(smooth, colors, classes);
      put(pieces.positions, pieces.normals, pieces.index, pieces.colors);
    },
    outline(classes, [red, green, blue]) {
      const { lines } = cut(smooth, new Uint8Array(smooth.positions.length), classes);
      const segments = new BufferGeometry().setAttribute("position", new BufferAttribute(lines, 3));
      const line = new LineBasicMaterial();
      line.color.setRGB(red / 255, green / 255, blue / 255, "srgb");
      object.add(new LineSegments(segments, line));
    },
  };
}
