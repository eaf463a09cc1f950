//! Targets: where surface points come from and where estimates go.
