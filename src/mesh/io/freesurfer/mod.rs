//! FreeSurfer: surfaces (`lh.white`, `lh.pial`, `.asc`), numbers at their vertices (`lh.curv`, `lh.thickness`), and
//! labels (`.annot`).
//!
//! | file | begins with | module |
//! |---|---|---|
//! | surface of triangles | `ff ff fe` | `surface.rs` |
//! | the same as text | `#!ascii` | `surface.rs` |
//! | numbers at vertices | `ff ff ff` | `curvature.rs` |
//! | labels | the number of vertices | `annotation.rs` |
//!
//! Numbers are big-endian. Files have no extension of their own, so the first bytes tell surfaces and numbers apart.
//! Old surfaces of quadrangles (`ff ff ff`, `ff ff fd`) and old numbers of 16 bits are refused.
//!
//! Reference: the FreeSurfer wiki, pages *FileFormats* and *LabelsClutsAnnotationFiles*.

mod annotation;
mod bytes;
mod curvature;
mod surface;
mod write;

pub use self::annotation::{Annotation, read_annotation};
pub use self::curvature::{is_curvature, read_curvature};
pub use self::surface::{parse, recognizes};
pub use self::write::write_annotation;
