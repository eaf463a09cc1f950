//! What has come back from the engine: all that the window shows.

use crate::{
    curve::Curves,
    engine::{Boxes, Built, Fault, Picture, Probe, Report, SceneFacts, Trouble, Truth},
};
use std::{collections::HashMap, sync::Arc};

/// Truths that are kept: each is as large as a picture.
const KEPT_TRUTHS: usize = 8;
/// Messages that are kept.
const KEPT_MESSAGES: usize = 20;

/// Something told, newest last.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Message {
    /// By whose fault; `None` where nothing is wrong.
    pub(crate) fault: Option<Fault>,
    pub(crate) text: String,
}

/// What is shown.
#[derive(Default)]
pub(crate) struct Shown {
    pub(crate) scene: Option<Arc<SceneFacts>>,
    pub(crate) built: Built,
    pub(crate) picture: Option<Arc<Picture>>,
    /// Counts pictures and truths, so that what is painted is known to be old.
    pub(crate) version: u64,
    /// What is worked on, and which share of it is done.
    pub(crate) busy: Option<(String, Option<f32>)>,
    pub(crate) messages: Vec<Message>,
    /// True while the newest message was not put away.
    pub(crate) has_news: bool,
    pub(crate) truths: HashMap<String, Truth>,
    pub(crate) probe: Option<Box<Probe>>,
    pub(crate) boxes: Option<Boxes>,
    pub(crate) curves: Curves,
    /// RMSE of each side against the truth.
    pub(crate) measured: Vec<Option<f64>>,
    /// Seconds from a wish to its first picture, the newest last.
    pub(crate) first_pictures: Vec<f64>,
}

/// What a report asks of the window besides showing it.
pub(crate) enum Then {
    Nothing,
    /// A scene is open: its views are there to choose from.
    SceneOpened(Arc<SceneFacts>),
    /// The number of a scene that could not be opened.
    SceneRefused(u64),
    /// The engine begins anew.
    OpenAgain,
    /// A file for whoever has no discs.
    Download(String, Vec<u8>),
}

impl Shown {
    /// Tells something.
    pub(crate) fn say(&mut self, fault: Option<Fault>, text: impl Into<String>) {
        let message = Message { fault, text: text.into() };
        self.messages.retain(|earlier| *earlier != message);
        self.messages.push(message);
        let many = self.messages.len().saturating_sub(KEPT_MESSAGES);
        self.messages.drain(..many);
        self.has_news = true;
    }

    /// Takes a report in. `truth_key` says what the truth of the present wish is called.
    pub(crate) fn take(&mut self, report: Report, truth_key: &str) -> Then {
        match report {
            Report::Scene(facts) => {
                for warning in &facts.warnings {
                    self.say(None, format!("{}: {warning}", facts.name));
                }
                self.has_news = self.has_news && !facts.warnings.is_empty();
                let facts = Arc::new(facts);
                self.scene = Some(Arc::clone(&facts));
                (self.probe, self.boxes, self.busy) = (None, None, None);
                self.truths.clear();
                return Then::SceneOpened(facts);
            }
            Report::Built(built) => self.built = built,
            Report::Picture(picture) => self.take_picture(*picture, truth_key),
            Report::Busy(what, share) => self.busy = Some((what, share)),
            Report::Idle => self.busy = None,
            Report::Trouble(trouble) => return self.take_trouble(trouble),
            Report::Lost => return Then::OpenAgain,
            Report::Notice(text) => self.say(None, text),
            Report::Probe(probe) => self.probe = probe,
            Report::Boxes(boxes) => self.boxes = Some(boxes),
            Report::Truth(truth) => {
                if self.truths.len() >= KEPT_TRUTHS && !self.truths.contains_key(&truth.key) {
                    self.truths.clear();
                }
                self.truths.insert(truth.key.clone(), truth);
                self.version += 1;
                self.measure(truth_key);
            }
            Report::Written(path) => self.say(None, format!("wrote {}", path.display())),
            Report::Bytes(name, bytes) => return Then::Download(name, bytes),
        }
        Then::Nothing
    }

    fn take_trouble(&mut self, trouble: Trouble) -> Then {
        let Trouble { fault, message, scene } = trouble;
        self.busy = None;
        self.say(Some(fault), message);
        scene.map_or(Then::Nothing, Then::SceneRefused)
    }

    fn take_picture(&mut self, picture: Picture, truth_key: &str) {
        if picture.is_preview() || self.picture.as_ref().is_none_or(|last| last.look != picture.look) {
            self.first_pictures.push(picture.seconds);
            let many = self.first_pictures.len().saturating_sub(1000);
            self.first_pictures.drain(..many);
        }
        self.picture = Some(Arc::new(picture));
        self.version += 1;
        self.measure(truth_key);
        if let Some(picture) = &self.picture {
            self.curves.add(picture, &self.measured);
        }
    }

    /// The truth of what is shown, where there is one of the same size.
    pub(crate) fn truth(&self, key: &str) -> Option<&Truth> {
        let picture = self.picture.as_ref()?;
        self.truths.get(key).filter(|truth| truth.size == picture.size)
    }

    /// Compares each side with the truth.
    fn measure(&mut self, key: &str) {
        let Some(picture) = self.picture.clone() else { return };
        let truth = self.truth(key).map(|truth| Arc::clone(&truth.visibility));
        let rmse = |visibility: &[f32]| {
            let truth = truth.as_ref()?;
            let mask = vec![true; truth.len()];
            conray::target::compare(visibility, truth, &mask).ok().map(|found| found.rmse)
        };
        self.measured = picture.sides.iter().map(|side| rmse(&side.visibility)).collect();
    }
}
