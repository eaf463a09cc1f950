//! An engine on its thread, and waiting for what it tells.
#![allow(dead_code, reason = "each test file uses a part of this")]

use conray::{AoSettings, Method};
use conray_viewer::{
    engine::{Boxes, Order, Picture, Probe, Report, SceneFacts, Source, Trouble, Truth, Wish},
    host::{Host, ThreadHost},
};
use std::{
    collections::VecDeque,
    time::{Duration, Instant},
};

/// Nothing that is waited for takes longer, on any machine.
const PATIENCE: Duration = Duration::from_secs(120);

pub(crate) struct Runner {
    host: ThreadHost,
    waiting: VecDeque<Report>,
    pub(crate) scene: SceneFacts,
}

impl Runner {
    /// An engine that has opened a built-in scene.
    pub(crate) fn open(scene: &str) -> Self {
        let host = ThreadHost::start(|| {});
        let empty = SceneFacts {
            number: 0,
            name: String::new(),
            word: String::new(),
            triangles: 0,
            views: Vec::new(),
            diagonal: 0.0,
            warnings: Vec::new(),
        };
        let mut runner = Self { host, waiting: VecDeque::new(), scene: empty };
        runner.order(Order::Open(1, Source::Builtin(scene.into())));
        let Report::Scene(facts) = runner.answer(|r| matches!(r, Report::Scene(_))) else { unreachable!() };
        runner.scene = facts;
        runner
    }

    /// Gives an order; what was told before it is forgotten.
    pub(crate) fn order(&mut self, order: Order) {
        self.host.reports();
        self.waiting.clear();
        self.host.order(order);
    }

    fn next(&mut self) -> Report {
        let start = Instant::now();
        loop {
            if let Some(report) = self.waiting.pop_front() {
                return report;
            }
            self.waiting.extend(self.host.reports());
            assert!(start.elapsed() < PATIENCE, "nothing came");
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// The next report of a kind.
    pub(crate) fn until(&mut self, is_it: impl Fn(&Report) -> bool) -> Report {
        loop {
            let report = self.next();
            if is_it(&report) {
                return report;
            }
        }
    }

    /// The next report of a kind, with what follows it until nothing is left to do.
    pub(crate) fn answer(&mut self, is_it: impl Fn(&Report) -> bool) -> Report {
        let answer = self.until(is_it);
        self.until(|report| matches!(report, Report::Idle));
        answer
    }

    /// All reports until nothing is left to do; trouble is a failure.
    pub(crate) fn all_until_rest(&mut self) -> Vec<Report> {
        let mut all = Vec::new();
        loop {
            match self.next() {
                Report::Idle => return all,
                Report::Trouble(trouble) => panic!("{trouble:?}"),
                report => all.push(report),
            }
        }
    }

    /// The pictures until nothing is left to do.
    pub(crate) fn until_rest(&mut self) -> Vec<Picture> {
        let pictures = self.all_until_rest().into_iter().filter_map(|report| match report {
            Report::Picture(picture) => Some(*picture),
            _ => None,
        });
        pictures.collect()
    }

    pub(crate) fn until_picture(&mut self, is_it: impl Fn(&Picture) -> bool) -> Picture {
        match self.until(|report| matches!(report, Report::Picture(picture) if is_it(picture))) {
            Report::Picture(picture) => *picture,
            _ => unreachable!(),
        }
    }

    pub(crate) fn until_trouble(&mut self) -> Trouble {
        match self.answer(|report| matches!(report, Report::Trouble(_))) {
            Report::Trouble(trouble) => trouble,
            _ => unreachable!(),
        }
    }

    pub(crate) fn until_probe(&mut self) -> Option<Probe> {
        match self.answer(|report| matches!(report, Report::Probe(_))) {
            Report::Probe(probe) => probe.map(|probe| *probe),
            _ => unreachable!(),
        }
    }

    pub(crate) fn until_boxes(&mut self) -> Boxes {
        match self.answer(|report| matches!(report, Report::Boxes(_))) {
            Report::Boxes(boxes) => boxes,
            _ => unreachable!(),
        }
    }

    pub(crate) fn until_truth(&mut self, is_it: impl Fn(&Truth) -> bool) -> Truth {
        match self.answer(|report| matches!(report, Report::Truth(truth) if is_it(truth))) {
            Report::Truth(truth) => truth,
            _ => unreachable!(),
        }
    }
}

/// The first view of a scene by some methods, to an error that is soon reached.
pub(crate) fn wish(scene: &SceneFacts, size: [u32; 2], methods: &[Method]) -> Wish {
    let side = |&method: &Method| AoSettings {
        method,
        error: method.has_budget().then_some(0.02),
        voxels: 512,
        ..AoSettings::default()
    };
    Wish {
        scene: scene.number,
        look: scene.views[0].1,
        size,
        sides: methods.iter().map(side).collect(),
        device: conray::Device::Cpu,
        adapter: None,
        again: 0,
    }
}

/// The same from a little to the side.
pub(crate) fn orbit(wish: &Wish, yaw_rad: f32) -> Wish {
    Wish { look: wish.look.orbit(yaw_rad, 0.0), ..wish.clone() }
}
