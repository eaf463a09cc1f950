//! Settings, plan, backend and the AO methods.
