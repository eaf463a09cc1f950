//! Contenders by name.

use super::all;
use crate::{Contender, StudyError};

/// All of them.
pub(crate) fn default_names() -> Vec<String> {
    all().iter().map(|c| c.name().to_owned()).collect()
}

/// Checks that every name is known and none is said twice.
pub(crate) fn check_names(names: &[String]) -> Result<(), StudyError> {
    if names.is_empty() {
        return Err(StudyError::Request("--methods: name at least one".into()));
    }
    let known: Vec<&str> = all().iter().map(|c| c.name()).collect();
    for (index, name) in names.iter().enumerate() {
        if !known.contains(&&name[..]) {
            let known = known.join(", ");
            return Err(StudyError::Request(format!(
                "--methods {name}: there is no such method; there are {known}"
            )));
        }
        if names[..index].contains(name) {
            return Err(StudyError::Request(format!("--methods {name}: named twice")));
        }
    }
    Ok(())
}

/// Fresh contenders of these names, in that order.
pub(crate) fn chosen(names: &[String]) -> Result<Vec<Box<dyn Contender>>, StudyError> {
    check_names(names)?;
    let mut contenders = all();
    contenders.retain(|c| names.iter().any(|name| name == c.name()));
    contenders.sort_by_key(|c| names.iter().position(|name| name == c.name()));
    Ok(contenders)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_lead_back() {
        let names: Vec<String> = all().iter().map(|c| c.name().to_owned()).collect();
        check_names(&names).unwrap();
        let found: Vec<String> = chosen(&names).unwrap().iter().map(|c| c.name().to_owned()).collect();
        assert_eq!(found, names);
        let some = ["cones".to_owned(), "rays".to_owned()];
        assert_eq!(chosen(&some).unwrap()[0].name(), "cones", "in the order asked for");
    }

    #[test]
    fn unknown_and_repeated_names_are_refused() {
        for names in [vec!["rays", "magic"], vec!["rays", "rays"], vec![]] {
            let names: Vec<String> = names.into_iter().map(str::to_owned).collect();
            assert!(matches!(check_names(&names), Err(StudyError::Request(_))), "{names:?}");
        }
    }

    #[test]
    fn every_curve_ascends_and_says_what_it_is() {
        for contender in all() {
            let efforts = contender.efforts(&[1, 2, 4, 8, 16, 64]);
            assert!(!efforts.is_empty() && efforts.windows(2).all(|w| w[0].value < w[1].value));
            assert!(contender.about().ends_with('.') && efforts.iter().all(|e| !e.label.is_empty()));
        }
    }
}
