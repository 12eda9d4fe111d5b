//! Spoilt `.msh` files.

use dotyk::mesh::MeshFile;
use dotyk_fuzz::{Edit, seeds, spoilt};

#[test]
fn is_an_error_or_a_mesh() {
    let seeds = seeds("crates/dotyk/tests/data", "msh");
    bolero::check!()
        .with_type::<(u16, Vec<Edit>)>()
        .for_each(|(seed, edits)| {
            let bytes = spoilt(&seeds, usize::from(*seed) % seeds.len(), edits);
            if let Err(error) = MeshFile::from_bytes("spoilt.msh", &bytes) {
                assert!(!error.to_string().is_empty());
            }
        });
}
