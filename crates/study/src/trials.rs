//! Carrying out trials: every contender at every effort, timed in turns.
//!
//! The first round gives the answers; later rounds only time. Within a round every trial runs once, each round starting
//! elsewhere in the list, so that what slows the machine for a while does not fall on one contender. Every contender runs
//! once untimed before the first round. One trial is timed a second time as its own twin: what the two differ by is the
//! machine's noise.

mod order;
mod store;

use crate::{
    Answer, Case, Contender, Effort, Preparation, StudyError, StudyOptions, meter::Meter, pilot::Pilot,
    study::stop_if,
};
use conray::Control;
use std::time::Instant;
pub(crate) use store::Store;

/// One contender at one effort.
#[derive(Clone, Debug)]
pub(crate) struct Trial {
    /// Index into the contenders.
    pub(crate) contender: usize,
    /// Its effort.
    pub(crate) effort: Effort,
    /// What it said.
    pub(crate) answer: Answer,
    /// Wall-clock seconds of each timed run.
    pub(crate) seconds: Vec<f64>,
}

/// All trials of a case.
pub(crate) struct Trials {
    /// Contender by contender, efforts ascending.
    pub(crate) list: Vec<Trial>,
    /// Times of the twin: which trial, and its seconds.
    pub(crate) twin: Option<(usize, Vec<f64>)>,
}

impl Trials {
    /// The trial of a contender at an effort.
    pub(crate) fn find(&self, contenders: &[Box<dyn Contender>], name: &str, effort: u32) -> Option<&Trial> {
        self.list.iter().find(|t| contenders[t.contender].name() == name && t.effort.value == effort)
    }

    /// The trials of a contender, efforts ascending.
    pub(crate) fn of<'a>(
        &'a self,
        contenders: &'a [Box<dyn Contender>],
        name: &'a str,
    ) -> impl Iterator<Item = &'a Trial> {
        self.list.iter().filter(move |t| contenders[t.contender].name() == name)
    }

    /// How much the machine's times differ by themselves: the larger median of the twins over the smaller, less 1.
    pub(crate) fn noise(&self) -> Option<f64> {
        let (index, seconds) = self.twin.as_ref()?;
        let (a, b) = (median(&self.list[*index].seconds), median(seconds));
        (a > 0.0 && b > 0.0).then(|| a.max(b) / a.min(b) - 1.0)
    }
}

/// Runs every trial; those kept from an interrupted study are not run again.
#[allow(clippy::too_many_arguments, reason = "one caller; each is one part of the study")]
pub(crate) fn run(
    case: &Case,
    contenders: &mut [Box<dyn Contender>],
    truth: &[f32],
    pilot: &Pilot,
    options: &StudyOptions,
    store: &Store,
    meter: &Meter<'_>,
    control: Control<'_>,
) -> Result<Trials, StudyError> {
    for contender in contenders.iter_mut() {
        meter.say(format!("{}: {}: finding its best settings", case.id, contender.name()));
        let (budgets, settings) = (&options.budgets[..], &options.settings);
        contender.prepare(&Preparation { case, truth, pilot, budgets, settings, control })?;
        stop_if(control.cancelled)?;
    }
    let planned: Vec<(usize, Effort)> = contenders
        .iter()
        .enumerate()
        .flat_map(|(index, c)| c.efforts(&options.budgets).into_iter().map(move |effort| (index, effort)))
        .collect();
    let twin_of = order::twin(&planned, contenders);
    let mut kept: Vec<Option<Trial>> = planned
        .iter()
        .map(|(contender, effort)| store.load(*contender, &*contenders[*contender], effort, meter))
        .collect();
    let mut twin_seconds = Vec::new();

    let weights: Vec<f64> = planned.iter().map(|(index, e)| order::weight(&*contenders[*index], e)).collect();
    let all_rounds: f64 = weights.iter().sum::<f64>() * f64::from(options.repeats);
    let mut done = 0.0;
    if kept.iter().any(Option::is_none) {
        for contender in contenders.iter() {
            if let Some(least) = contender.efforts(&options.budgets).first() {
                meter.say(format!("{}: {}: warming up", case.id, contender.name()));
                contender.run(case, least.value, control)?;
                stop_if(control.cancelled)?;
            }
        }
    }
    for round in 0..options.repeats {
        for step in order::round(planned.len(), round) {
            let (index, effort) = &planned[step];
            let contender = &*contenders[*index];
            done += weights[step];
            let due = match &kept[step] {
                None => true,
                Some(trial) => {
                    trial.seconds.len() <= round as usize
                        && trial.seconds.iter().sum::<f64>() < options.repeat_seconds
                }
            };
            if !due {
                continue;
            }
            meter.say(format!("{}: {}, {}", case.id, contender.name(), effort.label));
            let (answer, seconds) = timed(case, contender, effort, control)?;
            let trial = kept[step].get_or_insert_with(|| Trial {
                contender: *index,
                effort: effort.clone(),
                answer,
                seconds: Vec::new(),
            });
            trial.seconds.push(seconds);
            store.keep(contender, trial)?;
            if Some(step) == twin_of {
                twin_seconds.push(timed(case, contender, effort, control)?.1);
            }
            meter.trials(done / all_rounds);
        }
    }
    let list = kept.into_iter().flatten().collect();
    Ok(Trials { list, twin: twin_of.filter(|_| !twin_seconds.is_empty()).map(|step| (step, twin_seconds)) })
}

fn timed(
    case: &Case,
    contender: &dyn Contender,
    effort: &Effort,
    control: Control<'_>,
) -> Result<(Answer, f64), StudyError> {
    let start = Instant::now();
    let answer = contender.run(case, effort.value, control)?;
    let seconds = start.elapsed().as_secs_f64();
    stop_if(control.cancelled)?;
    Ok((answer, seconds))
}

/// The middle value, or the mean of the two in the middle; 0 of none.
pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => 0.0,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    use super::median;

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(&[]), 0.0);
        assert_eq!(median(&[3.0]), 3.0);
        assert_eq!(median(&[9.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 9.0]), 3.0);
    }
}
