//! The whole of a texture bake: portion by portion estimated, then filled, made to agree at seams, extended.

use crate::{
    Apart, BentSpace, Buried, Places,
    answers::{Answers, Asked, mark_stopped},
    bent::TexelPlaces,
    shares::Shares,
};
use conray::{Budget, Control, Error, Session, Work};
use conray_target::{AtlasMap, Portion, SeamReport, Target, fill, level};
use std::path::PathBuf;

/// How maps are made of estimates.
#[derive(Clone, Debug, PartialEq)]
pub struct MapOptions {
    /// Texels by which islands are extended; until they meet where it is `None`.
    pub padding: Option<u32>,
    /// Places that are asked about together at most: what is known of them takes some 400 bytes each.
    pub portion: u64,
    /// A folder in which the work on each portion is kept, to go on with; only for method `hybrid`.
    pub state: Option<PathBuf>,
    /// In which space bent directions are told.
    pub bent: BentSpace,
    /// Only this portion, to try; the maps then have no other values.
    pub only: Option<Portion>,
    /// Differences at a seam up to this count as agreement.
    pub seam_bound: f32,
}

/// Places that are asked about together unless memory is short: a map of 2048 x 2048.
pub const PORTION: u64 = 1 << 22;

impl Default for MapOptions {
    fn default() -> Self {
        Self {
            padding: None,
            portion: PORTION,
            state: None,
            bent: BentSpace::World,
            only: None,
            seam_bound: 0.02,
        }
    }
}

/// Finished maps, and how they came about.
#[derive(Clone, Debug)]
pub struct Baked {
    /// A map for each sheet.
    pub maps: Vec<AtlasMap>,
    /// Area of each map, in texels, that surfaces cover more than once: what is baked there is right for one of them only.
    pub overlaps: Vec<f64>,
    /// Points inside other geometry.
    pub buried: u64,
    /// How far the two sides of seams are apart.
    pub seams: SeamReport,
    /// What each portion took.
    pub parts: Vec<Work>,
    /// Portions in all; those that were not begun when the work was stopped have no part, and no values but those beside them.
    pub portions: usize,
}

/// Bakes maps within a budget: the error holds for each portion, the time is shared out by what is left to do. The result does not depend on
/// threads, and on the clock only where time is the budget. Where objects stand `apart`, points of other instances get no value.
///
/// Progress is told in thousandths of the whole, [`conray::PROGRESS_UNITS`] in all; `told` hears of the maps after each portion but the last, when texels of those to
/// come have no value yet.
///
/// # Errors
/// Maps that are too large, or what the backend lacks for the plan.
pub fn bake_maps(
    session: &Session,
    apart: &[Apart],
    places: &Places,
    budget: Budget,
    options: &MapOptions,
    control: Control<'_>,
    told: &mut dyn FnMut(&[AtlasMap]),
) -> Result<Baked, Error> {
    let portions = match &options.only {
        Some(only) => vec![only.clone()],
        None => places.atlas.portions(options.portion)?,
    };
    let asked = Asked { session, apart, looks_inside: places.facing.inside };
    let mut maps = places.atlas.maps();
    let mut turn = (options.bent == BentSpace::Tangent).then(|| TexelPlaces::new(&maps));
    let mut overlaps = vec![0.0; maps.len()];
    let mut buried = Buried::new(session.geometry());
    let mut parts: Vec<Work> = Vec::new();
    // One texel at least, so that a portion of lines alone has a share.
    let reads = portions.iter().map(|portion| places.atlas.reads(portion).max(1.0)).collect();
    let mut shares = Shares::new(reads, budget);
    for (k, portion) in portions.iter().enumerate() {
        if control.is_cancelled() {
            break;
        }
        let target = places.texels(session, portion);
        for (part, overlap) in portion.parts.iter().zip(target.overlaps()) {
            overlaps[part.map] += overlap;
        }
        if let Some(turn) = &mut turn {
            turn.note(&target);
        }
        let of = |&surface: &u32| places.instances[surface as usize];
        let instances: Vec<u32> = target.surfaces().iter().map(of).collect();
        let kept = options.state.as_ref().map(|folder| folder.join(format!("portion-{k}.state")));
        let answers = shares.next(control, |budget, control| {
            let answers = asked.answers(&target, &instances, budget, control, kept.as_deref())?;
            Ok::<_, Error>((answers.seconds(), answers))
        })?;
        let Answers { estimates, inside, works } = answers;
        parts.extend(works);
        buried.add(&target, &estimates, &inside, &places.instances)?;
        for texel in target.resolve(&estimates)? {
            maps[texel.map as usize].put(&texel);
        }
        if k + 1 < portions.len() {
            told(&maps);
        }
    }
    mark_stopped(&mut parts, control);
    let (buried, taken) = buried.take_from(&mut maps);
    let seams = session.install(|| {
        let seams = places.seams(session);
        fill(&seams, &mut maps);
        // What lies inside as a whole, with all that it hangs together with, keeps what it sees there.
        for texel in taken {
            let map = &mut maps[texel.map as usize];
            if map.visibility[texel.at as usize].is_nan() {
                map.put(&texel);
            }
        }
        level(&seams, &mut maps);
        // Before islands are extended: what is beside them takes the directions of texels as they are told.
        if let Some(turn) = turn {
            turn.turn(session, places, &mut maps);
        }
        maps.iter_mut().for_each(|map| map.extend(options.padding));
        SeamReport::of(&seams, &maps, options.seam_bound)
    });
    Ok(Baked { maps, overlaps, buried, seams, parts, portions: portions.len() })
}
