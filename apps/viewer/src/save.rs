//! What is kept of what is shown: files, and the command that makes the same picture.

use crate::{camera::Look, engine::SceneFacts};
use conray::{AoSettings, Device, changed_settings};

/// The words of `conray render` that make the picture of a side.
pub fn command(
    scene: &SceneFacts,
    look: &Look,
    size: [u32; 2],
    settings: &AoSettings,
    device: Device,
    adapter: Option<&str>,
) -> Vec<String> {
    let mut words: Vec<String> = vec!["conray".into(), "render".into(), scene.word.clone()];
    match scene.views.iter().find(|(_, view)| view == look) {
        Some((name, _)) => words.extend(["--view".into(), name.clone()]),
        None => {
            let point = |[x, y, z]: [f32; 3]| format!("{x},{y},{z}");
            words.push(format!("--eye={}", point(look.eye)));
            words.push(format!("--look-at={}", point(look.look_at)));
            words.push(format!("--up={}", point(look.up)));
            words.push(format!("--fov={}", look.vertical_fov_deg));
        }
    }
    words.extend(["--size".into(), format!("{}x{}", size[0], size[1])]);
    words.extend(changed_settings(settings).into_iter().map(|(name, value)| format!("--{name}={value}")));
    let device = match device {
        Device::Auto => None,
        Device::Cpu => Some("cpu"),
        Device::Gpu => Some("gpu"),
    };
    words.extend(device.map(|device| format!("--device={device}")));
    words.extend(adapter.map(|adapter| format!("--adapter={adapter}")));
    words.extend(["-o".into(), "view.png".into(), "-o".into(), "view.exr".into()]);
    words
}

/// Words as a shell takes them.
pub fn shell_line(words: &[String]) -> String {
    let plain = |word: &str| {
        !word.is_empty() && word.chars().all(|c| c.is_ascii_alphanumeric() || "-_=+./,:@%".contains(c))
    };
    let quoted = |word: &String| match plain(word) {
        true => word.clone(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    };
    words.iter().map(quoted).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::choices::default_settings;
    use conray::Method;

    fn scene() -> SceneFacts {
        let look = Look {
            eye: [0.0, 1.0, 4.0],
            look_at: [0.0, 1.0, 0.0],
            up: [0.0, 1.0, 0.0],
            vertical_fov_deg: 38.0,
        };
        SceneFacts {
            number: 1,
            name: "room".into(),
            word: "my rooms/it's.glb".into(),
            triangles: 2,
            views: vec![("front".into(), look)],
            diagonal: 3.0,
            warnings: Vec::new(),
        }
    }

    #[test]
    fn a_named_view_is_named_and_another_given_by_its_numbers() {
        let (scene, settings) = (scene(), default_settings());
        let named = command(&scene, &scene.views[0].1, [640, 480], &settings, Device::Auto, None);
        assert_eq!(named[3..7], ["--view", "front", "--size", "640x480"]);
        assert_eq!(named[7..], ["--error=0.005", "-o", "view.png", "-o", "view.exr"]);
        let look = Look { eye: [-1.5, 2.0, 3.0], ..scene.views[0].1 };
        let given = command(&scene, &look, [9, 9], &settings, Device::Cpu, Some("llvm"));
        assert_eq!(given[3..7], ["--eye=-1.5,2,3", "--look-at=0,1,0", "--up=0,1,0", "--fov=38"]);
        assert!(given.contains(&"--device=cpu".into()) && given.contains(&"--adapter=llvm".into()));
    }

    #[test]
    fn changed_settings_become_options() {
        let settings = AoSettings {
            method: Method::Paper,
            error: None,
            distance: 2.5.into(),
            gamma: 0.05,
            max_memory: Some(1 << 30),
            ..default_settings()
        };
        let words = command(&scene(), &scene().views[0].1, [9, 9], &settings, Device::Auto, None);
        for word in ["--method=paper", "--distance=2.5", "--gamma=0.05", "--max-memory=1073741824"] {
            assert!(words.contains(&word.into()), "{word}: {words:?}");
        }
        assert!(!words.iter().any(|word| word.starts_with("--error")));
    }

    #[test]
    fn odd_names_are_quoted() {
        let line = shell_line(&["conray".into(), "it's.glb".into(), "--eye=-1,2".into(), String::new()]);
        assert_eq!(line, r"conray 'it'\''s.glb' --eye=-1,2 ''");
    }
}
