//! Cases come from strangers: whatever they call things is seen on the pages, and nothing of it is obeyed.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use dotyk::case::Case;
use dotyk::geometry::{Field, Point};
use dotyk::model::{
    Column, Comparison, ComparisonRow, Dimension, Law, Load, Model, Pair, Solution, Study,
    StudyMember, Units, Varied,
};
use dotyk::output::{FailedStep, Folder, Record, write_comparison, write_study};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::path::Path;

/// Ends whatever it may stand in, and asks to be obeyed.
const OBEY: &str = "\"'></title></style></script>]]>--><script>document.title='taken'</script>\
                    <img src=x onerror=taken()><svg onload=taken()><a href=javascript:taken()>&lt;b&gt;";

/// As long, and harmless.
const PLAIN: &str = "abcdefghi jklmnopqr stuvwxyz abcdefghi jklmnopqr stuvwxyz abcdefghi jklmnopqr stuvwxyz abcdefghi jklmnopqr \
                     stuvwxyz abcdefghi jklmnopqr stuvwxyz abcdefghi jklmnopqr";

/// A block on another, pushed aside in two steps, with a bar, a section and probes.
const PLANE: &str = r#"
analysis = "plane-strain"
[parameters]
q = 2
[[body]]
name = "base"
mesh = { rectangle = { from = [0, 0], to = [2, 1], cells = [8, 4] } }
material = { young = 1000, poisson = 0.3, strength = { friction_angle = 30, cohesion = 4 } }
fix = [{ side = "bottom", x = 0, y = 0 }]
[[body]]
name = "block"
mesh = { rectangle = { from = [0, 1], to = [2, 2], cells = [8, 4] } }
material = { young = 1000, poisson = 0.3 }
load = [{ side = "top", traction = ["0.1 * t", -1] }]
[[contact]]
name = "sole"
nonmortar = "block.bottom"
mortar = "base.top"
friction = 0.3
[[bar]]
name = "bar"
from = [0, 0.5]
to = [2, 0.5]
bodies = ["base"]
bond = "grouted"
young = 1e5
area = 1e-3
[[section]]
name = "cut"
body = "block"
sides = ["top", "bottom"]
stations = 5
[[probe]]
name = "pressure"
quantity = "sole.pressure"
reduce = "max"
[[probe]]
name = "line"
quantity = "base.stress.yy"
along = { from = [0, 0.5], to = [2, 0.5], points = 5 }
[[step]]
time = 0.5
[[step]]
time = 1
"#;

/// The same in space.
const SPACE: &str = r#"
analysis = "3d"
[parameters]
q = 2
[[body]]
name = "base"
mesh = { box = { from = [0, 0, 0], to = [2, 2, 1], cells = [4, 4, 2] } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "bottom", x = 0, y = 0, z = 0 }]
[[body]]
name = "block"
mesh = { box = { from = [0.5, 0.5, 1], to = [1.5, 1.5, 2], cells = [2, 2, 2] } }
material = { young = 1000, poisson = 0.3 }
load = [{ side = "top", traction = ["0.1 * t", 0, -1] }]
[[contact]]
name = "sole"
nonmortar = "block.bottom"
mortar = "base.top"
friction = 0.3
[[probe]]
name = "pressure"
quantity = "sole.pressure"
reduce = "max"
[[step]]
time = 0.5
[[step]]
time = 1
"#;

/// A model in which all that may be a text is this word.
fn called<const D: usize>(mut model: Model<D>, word: &str) -> Model<D> {
    let own = |kind: &str| format!("{kind}{word}");
    (model.title, model.source) = (own("title"), own("source"));
    model.units = Units {
        length: Some(own("length")),
        force: Some(own("force")),
    };
    model.parameters = vec![(own("parameter"), 2.0)];
    model.step_names = vec![own("first"), own("second")];
    let top = |p: Point<D>| p[D - 1] == 1.0;
    model.bodies[0].mesh = dotyk::mesh::Mesh::clone(&model.bodies[0].mesh)
        .with_side(word, top)
        .into();
    let pressure = Field::function(word, |_, _| 2.0);
    let side = "top".to_string();
    model.bodies[1]
        .loads
        .push(Load::Pressure { side, pressure });
    let contact = &mut model.contacts[0];
    contact.name = own("contact");
    contact.law = Law::Coulomb(Field::function(word, |_, _| 0.3));
    if let Pair::Given { mortar, .. } = &mut contact.pair {
        mortar.side = word.to_string();
    }
    let members = model.members.iter_mut();
    members.for_each(|member| member.name = own("bar"));
    let sections = model.sections.iter_mut();
    sections.for_each(|section| section.name = own("section"));
    for (k, probe) in model.probes.iter_mut().enumerate() {
        probe.name = own(&format!("probe {k}"));
    }
    model
}

/// Steps, the last of which has this warning.
fn warned<const D: usize>(mut steps: Vec<Solution<D>>, word: &str) -> Vec<Solution<D>> {
    assert!(steps.iter().all(|step| step.converged) && steps.len() == 2);
    steps[1].warnings.push(word.to_string());
    steps
}

/// The pages and figures of a run, one that ended early among them, and of a check of its model.
macro_rules! pages {
    ($D:literal, $text:expr, $word:expr) => {{
        let case = Case::<$D>::from_str($text, "case.toml", Path::new(".")).unwrap();
        let mut model = called(case.model, $word);
        let steps = warned(model.solve_steps().unwrap(), $word);
        let mut record = Record::of(&model, &steps, $word);
        let figures = record.figures();
        let mut pages = vec![record.report().unwrap()];
        record.failed = Some(FailedStep {
            step: 3,
            time: 2.0,
            reason: $word.to_string(),
            carried: None,
        });
        pages.push(record.report().unwrap());
        // what is only looked at may be called anything
        model.bodies.iter_mut().for_each(|body| body.name += $word);
        let folder = folder(concat!("check", $D));
        let check = model.check().write_page(&model, $word, &folder).unwrap();
        pages.push(std::fs::read_to_string(check).unwrap());
        (
            pages,
            figures.into_iter().map(|(_, figure)| figure).collect(),
        )
    }};
}

fn folder(name: &str) -> Folder {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("strangers-{name}"));
    Folder::hold(&folder).unwrap()
}

/// Name and names of the attributes of every element of a page, each once.
fn elements(page: &str) -> BTreeSet<String> {
    let mut rest = page;
    let mut found = BTreeSet::new();
    while let Some(begin) = rest.find('<') {
        rest = &rest[begin + 1..];
        let (mut quote, mut head) = (None, String::new());
        for c in rest.chars() {
            match (quote, c) {
                (None, '>') => break,
                (None, '"' | '\'') => quote = Some(c),
                (Some(open), c) if open == c => quote = None,
                (None, c) => head.push(c),
                (Some(_), _) => {}
            }
        }
        found.insert(head);
        // what a script or a style says has no elements
        if let Some(raw) = ["script", "style"]
            .iter()
            .find(|own| rest.starts_with(**own))
        {
            let end = rest.find(&format!("</{raw}>")).unwrap();
            rest = &rest[end..];
        }
    }
    found
}

fn assert_unobeyed(strange: &[String], plain: &[String]) {
    assert_eq!(strange.len(), plain.len());
    for (strange, plain) in strange.iter().zip(plain) {
        let known = elements(plain);
        let new: Vec<_> = elements(strange).difference(&known).cloned().collect();
        assert!(new.is_empty(), "{new:?}");
        for obeyed in [
            "<script>document",
            "<img",
            "<svg onload",
            "]]>",
            "<a ",
            "-->",
        ] {
            assert!(!strange.contains(obeyed), "{obeyed}");
        }
        let handler = |element: &String| element.split(' ').any(|part| part.starts_with("on"));
        assert!(!known.iter().any(handler), "{known:?}");
    }
}

/// A page lets no script run but those that it has, and asks nobody for anything.
fn assert_closed(page: &str) {
    let (_, policy) = page
        .split_once("<meta http-equiv=\"Content-Security-Policy\" content=\"")
        .unwrap();
    let (policy, _) = policy.split_once('"').unwrap();
    assert!(policy.starts_with("default-src 'none'; "), "{policy}");
    assert!(!policy.contains("script-src 'unsafe"), "{policy}");
    for script in page.split("<script>").skip(1) {
        let (script, _) = script.split_once("</script>").unwrap();
        let hash = STANDARD.encode(Sha256::digest(script));
        assert!(policy.contains(&format!("'sha256-{hash}'")), "{policy}");
    }
}

fn assert_all((pages, figures): (Vec<String>, Vec<String>), plain: (Vec<String>, Vec<String>)) {
    assert_unobeyed(&pages, &plain.0);
    assert_unobeyed(&figures, &plain.1);
    for page in &pages {
        assert_closed(page);
        assert!(page.contains("&lt;script&gt;document.title=&#39;taken&#39;"));
    }
    for kind in [
        "title",
        "source",
        "force",
        "parameter",
        "contact",
        "probe 0",
    ] {
        assert!(
            pages[0].contains(&format!("{kind}&quot;&#39;&gt;&lt;/title")),
            "{kind}"
        );
    }
}

#[test]
fn nothing_of_a_plane_case_is_obeyed() {
    let strange = pages!(2, PLANE, OBEY);
    for kind in ["section", "bar", "second", "length"] {
        assert!(strange.0[0].contains(&format!("{kind}&quot;")), "{kind}");
    }
    assert_all(strange, pages!(2, PLANE, PLAIN));
}

#[test]
fn nothing_of_a_case_of_space_is_obeyed() {
    let strange = pages!(3, SPACE, OBEY);
    // the view that turns, and its data
    assert_eq!(strange.0[0].matches("<script").count(), 2);
    assert_all(strange, pages!(3, SPACE, PLAIN));
}

/// A study whose texts are this word, and a comparison.
fn tables(word: &str) -> (Study, Comparison) {
    let members = [1.0, 2.0].map(|value| StudyMember {
        values: vec![value],
        probes: vec![value],
        times: vec![0.5, 1.0],
        steps: vec![vec![value]; 2],
        converged: value < 2.0,
        reason: word.to_string(),
        warnings: vec![word.to_string()],
    });
    let study = Study {
        title: word.to_string(),
        units: Units {
            length: Some(word.to_string()),
            force: Some(word.to_string()),
        },
        varied: vec![Varied {
            name: word.to_string(),
            values: vec![1.0, 2.0],
            log: false,
        }],
        probes: vec![Column {
            name: format!("@{word}"),
            dimension: Dimension::Force,
        }],
        members: members.to_vec(),
        all_steps: true,
    };
    let row = ComparisonRow {
        method: word.to_string(),
        rho: None,
        rho_lambda_max: None,
        converged: true,
        iterations: 1,
        products: 1,
        seconds: 1.0,
        difference: 0.0,
    };
    let comparison = Comparison {
        title: word.to_string(),
        rows: vec![row],
    };
    (study, comparison)
}

/// What is written of them: pictures and the page, then the tables.
fn written(word: &str, name: &str) -> (Vec<String>, Vec<String>) {
    let (study, comparison) = tables(word);
    let folder = folder(name);
    let pairs = [[word.to_string(), format!("@{word}")]];
    write_study(&study, &pairs, word, &folder).unwrap();
    write_comparison(&comparison, &folder).unwrap();
    let read = |name: &&str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let pages = ["study.html", "study.svg", "compare.svg"];
    (
        pages.iter().map(read).collect(),
        ["study.csv", "compare.csv"].iter().map(read).collect(),
    )
}

#[test]
fn nothing_of_a_study_or_a_comparison_is_obeyed() {
    let (strange, _) = written(OBEY, "study");
    assert_unobeyed(&strange, &written(PLAIN, "study-plain").0);
    assert_closed(&strange[0]);
    let (_, tables) = written("=1+2", "study-sheet");
    let head = "'=1+2,step,time,'@=1+2,converged,reason\n1.0,1,0.5,1.0,true,\n";
    assert!(tables[0].starts_with(head), "{}", tables[0]);
    assert!(
        tables[0].ends_with("2.0,3,NaN,NaN,false,'=1+2\n"),
        "{}",
        tables[0]
    );
    assert!(tables[1].contains("\n'=1+2,"), "{}", tables[1]);
}

/// A VTU file of one quadrilateral, with its coordinates compressed, and so many further zeros behind them.
fn compressed(zeros: usize) -> Vec<u8> {
    use base64::Engine;
    use std::io::Write;
    let packed = |bytes: &[u8]| {
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
        encoder.write_all(bytes).unwrap();
        let packed = encoder.finish().unwrap();
        let counts = [1, bytes.len(), 0, packed.len()];
        let head: Vec<u8> = counts
            .iter()
            .flat_map(|&n| (n as u64).to_le_bytes())
            .collect();
        let code = |bytes: &[u8]| base64::engine::general_purpose::STANDARD.encode(bytes);
        code(&head) + &code(&packed)
    };
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let numbers = corners.iter().flat_map(|&[x, y]| [x, y, 0.0]);
    let mut points: Vec<u8> = numbers.flat_map(f64::to_le_bytes).collect();
    points.resize(points.len() + zeros, 0);
    let integers = |all: &[i64]| all.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<_>>();
    let array = |name: &str, kind: &str, bytes: &[u8]| {
        let data = packed(bytes);
        format!("<DataArray Name=\"{name}\" type=\"{kind}\" format=\"binary\">{data}</DataArray>")
    };
    format!(
        "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
         compressor=\"vtkZLibDataCompressor\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">\
         <Points>{}</Points><Cells>{}{}{}</Cells></Piece></UnstructuredGrid></VTKFile>",
        array("Points", "Float64", &points),
        array("connectivity", "Int64", &integers(&[0, 1, 2, 3])),
        array("offsets", "Int64", &integers(&[4])),
        array("types", "Int64", &integers(&[9])),
    )
    .into_bytes()
}

#[test]
fn what_a_compressed_mesh_unpacks_to_is_bounded() {
    use dotyk::mesh::MeshFile;
    assert!(MeshFile::from_bytes("a.vtu", &compressed(0)).is_ok());
    // 200 MB in 200 kB
    let bomb = compressed(200_000_000);
    assert!(bomb.len() < 400_000, "{}", bomb.len());
    let error = MeshFile::from_bytes("a.vtu", &bomb).unwrap_err();
    let told = error.to_string();
    assert!(told.contains("more than 100 times the file"), "{told}");
}
