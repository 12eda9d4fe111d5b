//! `dotyk check`: look at a case without solving it.

use crate::Outcome;
use crate::failure::Failure;
use crate::given::{Given, Input, located};
use crate::run::output_folder;
use crate::text::{named, print};
use dotyk::model::Check;
use std::path::PathBuf;

/// Arguments of `dotyk check`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Case file
    case: PathBuf,
    #[command(flatten)]
    given: Given,
    /// Write the page of meshes and supports into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Checks, writes the page, prints.
pub fn check(arguments: &Arguments) -> Result<Outcome, Failure> {
    let Input { case, deck } = arguments.given.read(&arguments.case)?;
    of_any!(case, |case| {
        let folder = match &arguments.out {
            Some(folder) => Some(output_folder(Some(folder), &case.stem)?),
            None => None,
        };
        let check = case.check();
        // errors are reported below, with their place
        let shown = Check {
            errors: Vec::new(),
            ..check.clone()
        };
        let mut text = shown.to_string();
        if !text.ends_with('\n') {
            text.push('\n');
        }
        // The page shows where an error is: it is written with errors, too.
        if let Some(folder) = folder {
            let page = check.write_page(&case.model, &case.stem, &folder);
            let page = page.map_err(|e| Failure::Message(e.to_string()))?;
            text += &named(&[page]);
        }
        print(&text)?;
        match check.errors.as_slice() {
            [] => Ok(Outcome::Done),
            errors => {
                let error = case.error(check.subject.as_ref(), &errors.join("; "));
                Err(located(deck.as_deref(), error).into())
            }
        }
    })
}
