//! What people's reports describe: small inputs and the right value for each.

mod experiments;
