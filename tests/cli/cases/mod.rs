//! Small inputs of the kinds that go wrong in practice, and the right value for each.

mod images;
