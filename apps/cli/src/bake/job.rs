//! Options as JSON: a list of them all, those that were given, and files of them.

use crate::{args::Cli, failure::Failure, report::print_lines};
use clap::{ArgAction, ArgMatches, CommandFactory, parser::ValueSource};
use serde_json::{Map, Value, json};
use std::{ffi::OsString, fs, path::Path, sync::OnceLock};

/// What was given to this run.
static GIVEN: OnceLock<Value> = OnceLock::new();

/// The options of this run, to be replayed by `--job`.
pub(super) fn given() -> Value {
    GIVEN.get().cloned().unwrap_or_default()
}

/// Keeps what was given to a bake, of all matches of the program.
pub(crate) fn keep(matches: &ArgMatches) {
    let Some(matches) = matches.subcommand_matches("bake") else { return };
    let mut job = Map::new();
    let program = Cli::command();
    let Some(command) = program.find_subcommand("bake") else { return };
    for argument in command.get_arguments() {
        let id = argument.get_id().as_str();
        let is_given = matches!(matches.try_contains_id(id), Ok(true))
            && matches.value_source(id) == Some(ValueSource::CommandLine);
        if !is_given || id == "job" {
            continue;
        }
        let raw = matches.get_raw(id).map(|values| values.map(|value| value.to_string_lossy().into_owned()));
        let values: Vec<String> = raw.map(Iterator::collect).unwrap_or_default();
        let value = match argument.get_action() {
            ArgAction::SetTrue => json!(true),
            ArgAction::Append => json!(values),
            _ => values.first().map_or(json!(true), |value| json!(value)),
        };
        job.insert(name(argument), value);
    }
    _ = GIVEN.set(Value::Object(job));
}

/// Name of an option in JSON: its long form, or that of a place among the words.
fn name(argument: &clap::Arg) -> String {
    argument.get_long().unwrap_or(argument.get_id().as_str()).to_string()
}

/// The words of the command line, with those of `conray bake`'s `--job` put before them.
///
/// # Errors
/// A file that cannot be read or is no object of options.
pub(crate) fn with_job(words: Vec<OsString>) -> Result<Vec<OsString>, Failure> {
    if words.get(1).is_none_or(|command| command != "bake") {
        return Ok(words);
    }
    let inline = |word: &OsString| word.to_string_lossy().strip_prefix("--job=").map(OsString::from);
    let at = words.iter().position(|word| word == "--job");
    let path = match at {
        Some(at) => words.get(at + 1).cloned(),
        None => words.iter().find_map(inline),
    };
    let Some(path) = path else { return Ok(words) };
    let mut all = words[..2].to_vec();
    all.extend(read(Path::new(&path))?);
    all.extend_from_slice(&words[2..]);
    Ok(all)
}

/// Options of a job file as words.
fn read(path: &Path) -> Result<Vec<OsString>, Failure> {
    let fault = |problem: String| Failure::Input(format!("--job {}: {problem}", path.display()));
    let text = fs::read_to_string(path).map_err(|e| fault(format!("cannot be read: {e}")))?;
    let job: Map<String, Value> =
        serde_json::from_str(&text).map_err(|e| fault(format!("it is no JSON object of options: {e}")))?;
    let program = Cli::command();
    let command = program.find_subcommand("bake");
    let mut words = Vec::new();
    for (option, value) in &job {
        let known = command.and_then(|c| c.get_arguments().find(|argument| name(argument) == *option));
        let Some(argument) = known else {
            return Err(fault(format!("there is no option {option}; see conray bake --options json")));
        };
        let values: Vec<&Value> = value.as_array().map_or(vec![value], |all| all.iter().collect());
        for value in values {
            let text = match value {
                Value::Bool(false) | Value::Null => continue,
                Value::Bool(true) => None,
                Value::String(text) => Some(text.clone()),
                Value::Number(number) => Some(number.to_string()),
                _ => {
                    return Err(fault(format!(
                        "{option}: expected a text, a number, true or false, or a list of these"
                    )));
                }
            };
            words.push(match (argument.get_long(), text) {
                (Some(long), Some(text)) => format!("--{long}={text}").into(),
                (Some(long), None) => format!("--{long}").into(),
                (None, text) => OsString::from(text.unwrap_or_default()),
            });
        }
    }
    Ok(words)
}

/// Prints every option of a bake: what it does, its values, its default.
pub(super) fn print_options() -> Result<(), Failure> {
    let program = Cli::command();
    let Some(command) = program.find_subcommand("bake") else { return Ok(()) };
    let of = |argument: &clap::Arg| {
        let takes = argument.get_action().takes_values();
        let values: Vec<String> =
            argument.get_possible_values().iter().map(|value| value.get_name().to_string()).collect();
        let default = argument.get_default_values().first().map(|value| value.to_string_lossy());
        let kind = match argument.get_action() {
            ArgAction::Append => "list",
            _ if !takes => "flag",
            _ if !values.is_empty() => "choice",
            _ => "value",
        };
        json!({
            "name": name(argument), "kind": kind,
            "value": argument.get_value_names().filter(|_| takes).and_then(|names| names.first()).map(ToString::to_string),
            "values": values, "default": default,
            "help": argument.get_long_help().or(argument.get_help()).map(ToString::to_string),
        })
    };
    let options: Vec<Value> = command.get_arguments().filter(|a| a.get_id() != "help").map(of).collect();
    print_lines(&[serde_json::to_string_pretty(&options).unwrap_or_default()]);
    Ok(())
}
