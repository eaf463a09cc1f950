//! The kinds of trees that stand in the grove.

use super::growth::Order;
use std::f32::consts::PI;

/// What distinguishes one kind of tree from another; lengths in metres.
pub(crate) struct Species {
    pub(crate) name: &'static str,
    pub(crate) is_conifer: bool,
    pub(crate) height: f32,
    pub(crate) trunk_radius: f32,
    pub(crate) orders: [Order; 3],
    /// Length factor of a bough by its place in the crown, 0 at the foot and 1 at the top.
    pub(crate) crown: fn(f32) -> f32,
    pub(crate) leaves: Foliage,
}

/// Leaf cards on the outermost limbs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foliage {
    /// Cards on each limb.
    pub(crate) per_limb: usize,
    /// Least and greatest length of a card; it is about as wide as the mask says.
    pub(crate) length: [f32; 2],
    /// Width over length.
    pub(crate) width: f32,
    /// How far a card turns from its limb to the side, from 0 (along) to 1 (mostly sideways).
    pub(crate) spread: f32,
    /// How far it hangs.
    pub(crate) droop: f32,
}

const TRUNK: Order = Order {
    count: 1,
    length: 1.0,
    radius: 1.0,
    angle_rad: [0.0; 2],
    first: 0.0,
    rise: 0.25,
    waver: 0.05,
    steps: 11,
};

impl Species {
    /// The kinds of the grove.
    pub(crate) fn all() -> [Self; 5] {
        let round = |s: f32| (PI * (0.12 + 0.8 * s)).sin().powf(0.6);
        let oval = |s: f32| (PI * (0.2 + 0.76 * s)).sin().powf(0.8) * (1.0 - 0.25 * s);
        let cone = |s: f32| 1.04 - s;
        let broad = Foliage { per_limb: 34, length: [0.3, 0.46], width: 0.9, spread: 0.8, droop: 0.25 };
        [
            Self {
                name: "oak",
                is_conifer: false,
                height: 9.5,
                trunk_radius: 0.34,
                orders: [
                    Order { waver: 0.09, ..TRUNK },
                    Order {
                        count: 19,
                        length: 0.46,
                        radius: 0.5,
                        angle_rad: [1.35, 0.45],
                        first: 0.3,
                        rise: 0.35,
                        waver: 0.16,
                        steps: 6,
                    },
                    Order {
                        count: 10,
                        length: 0.44,
                        radius: 0.5,
                        angle_rad: [0.95, 0.6],
                        first: 0.3,
                        rise: 0.2,
                        waver: 0.16,
                        steps: 4,
                    },
                ],
                crown: round,
                leaves: broad,
            },
            Self {
                name: "ash",
                is_conifer: false,
                height: 13.0,
                trunk_radius: 0.28,
                orders: [
                    TRUNK,
                    Order {
                        count: 24,
                        length: 0.3,
                        radius: 0.42,
                        angle_rad: [1.1, 0.35],
                        first: 0.32,
                        rise: 0.55,
                        waver: 0.1,
                        steps: 6,
                    },
                    Order {
                        count: 9,
                        length: 0.46,
                        radius: 0.5,
                        angle_rad: [0.8, 0.5],
                        first: 0.25,
                        rise: 0.3,
                        waver: 0.14,
                        steps: 4,
                    },
                ],
                crown: oval,
                leaves: broad,
            },
            Self {
                name: "birch",
                is_conifer: false,
                height: 11.0,
                trunk_radius: 0.15,
                orders: [
                    Order { waver: 0.04, ..TRUNK },
                    Order {
                        count: 26,
                        length: 0.24,
                        radius: 0.4,
                        angle_rad: [0.9, 0.4],
                        first: 0.26,
                        rise: 0.1,
                        waver: 0.1,
                        steps: 6,
                    },
                    Order {
                        count: 8,
                        length: 0.6,
                        radius: 0.5,
                        angle_rad: [0.9, 0.6],
                        first: 0.2,
                        rise: -0.9,
                        waver: 0.12,
                        steps: 4,
                    },
                ],
                crown: oval,
                leaves: Foliage { per_limb: 30, length: [0.24, 0.36], droop: 0.6, ..broad },
            },
            Self {
                name: "pine",
                is_conifer: true,
                height: 14.0,
                trunk_radius: 0.26,
                orders: [
                    Order { waver: 0.015, ..TRUNK },
                    Order {
                        count: 64,
                        length: 0.27,
                        radius: 0.3,
                        angle_rad: [1.75, 1.05],
                        first: 0.14,
                        rise: 0.25,
                        waver: 0.05,
                        steps: 5,
                    },
                    Order {
                        count: 7,
                        length: 0.4,
                        radius: 0.5,
                        angle_rad: [0.95, 0.75],
                        first: 0.15,
                        rise: 0.05,
                        waver: 0.06,
                        steps: 2,
                    },
                ],
                crown: cone,
                leaves: Foliage { per_limb: 22, length: [0.3, 0.42], width: 0.5, spread: 0.55, droop: 0.1 },
            },
            Self {
                name: "sapling",
                is_conifer: false,
                height: 4.6,
                trunk_radius: 0.07,
                orders: [
                    Order { waver: 0.1, ..TRUNK },
                    Order {
                        count: 16,
                        length: 0.36,
                        radius: 0.5,
                        angle_rad: [1.0, 0.45],
                        first: 0.22,
                        rise: 0.3,
                        waver: 0.12,
                        steps: 5,
                    },
                    Order {
                        count: 6,
                        length: 0.5,
                        radius: 0.6,
                        angle_rad: [0.9, 0.5],
                        first: 0.3,
                        rise: 0.1,
                        waver: 0.15,
                        steps: 3,
                    },
                ],
                crown: oval,
                leaves: Foliage { per_limb: 26, length: [0.2, 0.3], ..broad },
            },
        ]
    }
}
