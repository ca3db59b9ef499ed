//! Mesh files. One format a file; each keeps the file's vertex order.
