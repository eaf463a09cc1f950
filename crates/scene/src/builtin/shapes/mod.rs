//! The solids and sheets of which the built-in scenes are made.

mod arch;
mod blocks;
mod cards;
mod icosphere;
mod lathe;
mod loft;

pub(crate) use arch::{ArchBay, arcade_outline, extruded_wall, moulding_round_arch};
pub(crate) use blocks::{chamfered_block, cuboid};
pub(crate) use cards::{Card, frond};
pub(crate) use icosphere::icosphere;
pub(crate) use lathe::{Profile, lathe};
pub(crate) use loft::{Ends, loft, mitred_ring, sweep, tube};
