//! The viewer: ambient occlusion looked at while it converges, in a window and in a page.
//!
//! ```text
//! panels, picture ---> choices.rs ---> Wish ---> engine ---> Session (crate conray)
//!        ^                             host: a thread, or a worker      |
//!        +------------- app/ <-------------- Report <-------------------+
//! ```
//!
//! The window never waits: it tells the engine ([`engine::Order`]) what is to be shown and shows what has come back
//! ([`engine::Report`]). All estimates are made by [`conray::Session`]; here are none.
//!
//! | where | what |
//! |---|---|
//! | `engine/` | what is worked on, in which order; answers about what is shown |
//! | `host/` | runs the engine beside the window or the page |
//! | `camera.rs`, `choices.rs`, `layers.rs`, `colour.rs`, `save.rs` | pure functions, without a window |
//! | `app/`, `panels/`, `picture/` | the window, drawn by egui |
//! | `native/`, `web.rs` | the program and the page |

mod app;
pub mod camera;
pub mod choices;
pub mod colour;
mod curve;
pub mod engine;
pub mod host;
pub mod layers;
mod panels;
mod picture;
pub mod save;
mod shown;
mod text;

#[cfg(not(target_arch = "wasm32"))]
pub mod native;
#[cfg(target_arch = "wasm32")]
pub mod web;

pub use app::{Start, Viewer};
