"""Reference solvers for convex multi-region segmentation on triangle meshes."""
