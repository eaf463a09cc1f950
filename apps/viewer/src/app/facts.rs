//! What is shown, in numbers: for tests, measurements and runs without anybody before the window.

use super::Viewer;
use crate::engine::{Fault, SidePicture};

impl Viewer {
    /// What is shown, for tests and measurements.
    pub fn facts(&self) -> serde_json::Value {
        let picture = self.shown.picture.as_deref();
        let sides: Vec<serde_json::Value> = picture.iter().flat_map(|p| &p.sides).map(side_facts).collect();
        serde_json::json!({
            "scene": self.shown.scene.as_ref().map(|scene| scene.name.clone()),
            "triangles": self.shown.scene.as_ref().map(|scene| scene.triangles),
            "size": picture.map(|p| p.size),
            "wished": picture.map(|p| p.wished),
            "look": self.choices.look,
            "picture_look": picture.map(|p| p.look),
            "sides": sides,
            "version": self.shown.version,
            "busy": self.shown.busy.as_ref().map(|busy| busy.0.clone()),
            "messages": self.shown.messages.iter().map(|m| m.text.clone()).collect::<Vec<_>>(),
            "first_pictures": self.shown.first_pictures,
            "canvas": self.canvas.rect.map(|r| [r.min.x, r.min.y, r.max.x, r.max.y]),
            "places": self.shown.built.places,
            "measured": self.shown.measured,
            "truth": self.shown.truth(&self.truth_key()).map(|truth| (truth.done, &truth.origin)),
            "boxes": self.shown.boxes.as_ref().map(|boxes| boxes.nodes.len()),
            "probe": self.shown.probe.as_ref().map(|probe| (probe.pixel, probe.cones.len(), probe.rays.len())),
        })
    }

    /// True where there is a whole picture of the newest wish and nothing is left to do.
    pub fn is_at_rest(&self) -> bool {
        let waits = self.start.truth.is_some() || self.start.probe.is_some();
        self.shows_whole_picture() && self.shown.busy.is_none() && !waits
    }

    /// True where a picture of all pixels of the newest wish is shown.
    pub fn shows_whole_picture(&self) -> bool {
        let is_whole = self.shown.picture.as_ref().is_some_and(|picture| !picture.is_preview());
        is_whole && self.shows_present_view().is_some()
    }

    /// The size of what is shown, where it is seen from where the camera is.
    pub fn shows_present_view(&self) -> Option<[u32; 2]> {
        let picture = self.shown.picture.as_ref()?;
        (Some(picture.look) == self.choices.look).then_some(picture.size)
    }

    /// Carries the camera about what it looks at.
    pub fn orbit(&mut self, yaw_rad: f32, pitch_rad: f32) {
        self.choices.look = self.choices.look.map(|look| look.orbit(yaw_rad, pitch_rad));
    }

    /// Why the first scene could not be opened, if it could not.
    pub fn scene_trouble(&self) -> Option<String> {
        let failed = self.shown.messages.iter().find(|message| message.fault == Some(Fault::Input));
        failed
            .filter(|_| self.last_number > 1 || self.shown.scene.is_none())
            .map(|message| message.text.clone())
    }

    /// Scene, method, size and place, in a line.
    pub fn what_is_measured(&self) -> String {
        let scene = self.shown.scene.as_ref().map_or("none", |scene| &scene.name[..]);
        let size = self.last_wish.as_ref().map_or([0; 2], |wish| wish.size);
        let place = self.shown.built.places.first().map_or("nowhere", |place| &place[..]);
        format!(
            "{scene}, method {}, {} x {} pixels, on {place}",
            self.choices.settings.method, size[0], size[1]
        )
    }
}

fn side_facts(side: &SidePicture) -> serde_json::Value {
    let finite = || side.visibility.iter().filter(|v| v.is_finite());
    let mean = finite().map(|&v| f64::from(v)).sum::<f64>() / finite().count().max(1) as f64;
    serde_json::json!({
        "method": side.method,
        "mean_visibility": mean,
        "expected_rmse": Some(side.expected_rmse).filter(|rmse| rmse.is_finite()),
        "rays_per_pixel": side.rays_per_pixel,
        "seconds": side.seconds,
        "ended": side.ended,
    })
}
