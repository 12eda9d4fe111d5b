//! Spoilt case files.

use dotyk::case::Case;
use dotyk_fuzz::{Edit, seeds, spoilt};

/// Models with at most this many nodes are checked as well.
const SMALL: usize = 600;

#[test]
fn is_an_error_or_a_model() {
    let seeds = seeds("cases", "toml");
    bolero::check!()
        .with_type::<(u16, Vec<Edit>)>()
        .for_each(|(seed, edits)| {
            let seed = usize::from(*seed) % seeds.len();
            let bytes = spoilt(&seeds, seed, edits);
            let text = String::from_utf8_lossy(&bytes);
            let folder = seeds[seed].0.parent().expect("a file lies in a folder");
            match Case::<2>::from_str(&text, "spoilt.toml", folder) {
                Err(error) => assert!(!error.to_string().is_empty()),
                Ok(case) => {
                    let sizes = case.model.bodies.iter().map(|b| b.mesh.points().len());
                    if sizes.sum::<usize>() <= SMALL {
                        // loads, supports and contacts are looked at, not only read
                        let _ = case.model.check();
                    }
                }
            }
        });
}
