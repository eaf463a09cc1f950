//! Two programs that do the same job, `conray render` and `embree_render`, run in turn.

use crate::{builds::Seconds, race::median};
use conray::target::read_png;
use std::{
    env, fs,
    path::{Path, PathBuf},
    process::Command,
    time::Instant,
};

/// Largest RMSE between the two images. Both draw the same rays; what differs is the rounding of where they start, which
/// decides for the rays that graze an edge or a corner. Seen: 0.0002 on `cornell`, 0.001 on Sponza.
pub const MOST_RMSE: f64 = 0.005;

/// The job.
#[derive(Clone, Debug)]
pub struct Job {
    /// A built-in scene or a file.
    pub scene: String,
    /// Pixels.
    pub size: (u32, u32),
    /// Rays per pixel.
    pub rays: u32,
}

/// Whole-process times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WholeProgram {
    /// Ours.
    pub conray: Seconds,
    /// Embree's.
    pub embree: Seconds,
    /// Median of the rounds' ratios, Embree's time by ours: above 1 where ours is faster.
    pub ratio: f64,
    /// RMSE between the images.
    pub rmse: f64,
}

/// Builds both programs where cargo started this one, and says where they are.
///
/// # Errors
/// A build that failed, or programs that are not there.
pub fn programs() -> Result<(PathBuf, PathBuf), String> {
    let here = env::current_exe().map_err(|e| e.to_string())?;
    let folder = here.parent().ok_or("no folder")?;
    if let Some(cargo) = env::var_os("CARGO") {
        let profile = if folder.ends_with("release") { &["--release"][..] } else { &[] };
        let packages =
            ["-p", "conray-cli", "-p", "conray-bench", "--bin", "conray", "--bin", "embree_render"];
        let status = Command::new(cargo).arg("build").args(profile).args(packages).status();
        status.map_err(|e| e.to_string())?.success().then_some(()).ok_or("the programs did not build")?;
    }
    let program = |name: &str| {
        let path = folder.join(format!("{name}{}", env::consts::EXE_SUFFIX));
        path.exists().then_some(path).ok_or(format!("{name} is not built"))
    };
    Ok((program("conray")?, program("embree_render")?))
}

impl Job {
    /// Runs both programs `rounds` times in turn.
    ///
    /// # Errors
    /// A program that failed, or images that are not of the same scene ([`MOST_RMSE`]).
    pub fn run(&self, rounds: usize) -> Result<WholeProgram, String> {
        let (conray, embree) = programs()?;
        let folder = env::temp_dir().join(format!("conray-whole-program-{}", std::process::id()));
        fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
        let result = self.run_in(&folder, &conray, &embree, rounds.max(1));
        // Two images in the system's own temporary folder: no harm if they stay.
        let _ = fs::remove_dir_all(&folder);
        result
    }

    fn run_in(
        &self,
        folder: &Path,
        conray: &Path,
        embree: &Path,
        rounds: usize,
    ) -> Result<WholeProgram, String> {
        let (ours, theirs) = (folder.join("conray.png"), folder.join("embree.png"));
        let (mut conray_seconds, mut embree_seconds) = (Vec::new(), Vec::new());
        for _ in 0..rounds {
            let options = ["render", "--method", "rays", "--alpha", "opaque", "--quiet"];
            conray_seconds.push(self.seconds(Command::new(conray).args(options), &ours)?);
            embree_seconds.push(self.seconds(&mut Command::new(embree), &theirs)?);
        }
        let rmse = rmse(&ours, &theirs)?;
        if rmse > MOST_RMSE {
            return Err(format!("the images differ by an RMSE of {rmse:.4}, {MOST_RMSE} is allowed"));
        }
        let pairs = conray_seconds.iter().zip(&embree_seconds);
        let ratio = median(&mut pairs.map(|(ours, theirs)| theirs / ours).collect::<Vec<_>>());
        let (conray, embree) = (Seconds::of(conray_seconds), Seconds::of(embree_seconds));
        Ok(WholeProgram { conray, embree, ratio, rmse })
    }

    /// From starting a program to its end.
    fn seconds(&self, command: &mut Command, output: &Path) -> Result<f64, String> {
        let size = format!("{}x{}", self.size.0, self.size.1);
        command.args(["--size", &size, "--rays", &self.rays.to_string(), "-o"]).arg(output).arg(&self.scene);
        let start = Instant::now();
        let done = command.output().map_err(|e| e.to_string())?;
        let seconds = start.elapsed().as_secs_f64();
        if done.status.success() {
            Ok(seconds)
        } else {
            Err(format!("{command:?}: {}", String::from_utf8_lossy(&done.stderr).trim()))
        }
    }
}

fn rmse(a: &Path, b: &Path) -> Result<f64, String> {
    let read = |path| read_png(path).map_err(|e| e.to_string());
    let (a, b) = (read(a)?, read(b)?);
    let squares = a.values.iter().zip(&b.values).map(|(a, b)| f64::from(a - b).powi(2));
    Ok((squares.sum::<f64>() / a.values.len().max(1) as f64).sqrt())
}
