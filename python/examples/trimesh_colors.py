"""Segments the colors of a mesh of trimesh, and shows the regions in their mean colors."""

import sys
from pathlib import Path

import numpy as np
import trimesh

import meshseg

PERSON = Path(__file__).parents[2] / "assets" / "human" / "human.ply"

mesh = trimesh.load(sys.argv[1] if len(sys.argv) > 1 else PERSON, process=False)
result = meshseg.segment(mesh, regions=4)
print(result)

means = np.array([region["color"] for region in result.regions])
mesh.visual.vertex_colors = (255 * means[result.labels]).round().astype(np.uint8)
mesh.export("regions.ply")
print("regions.ply shows them")
