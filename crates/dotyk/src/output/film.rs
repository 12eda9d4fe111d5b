//! Figure "Course of the load steps": pictures of several steps in one place. On a screen one is chosen or all are played, on paper they
//! stand beside each other; styles alone do that, so that a page needs no script.

use crate::output::markup::{Markup, markup};
use crate::output::svg::short;

/// Most steps with a picture.
pub const MOST: usize = 12;

/// Seconds of each picture while they are played.
const EACH: f64 = 0.8;

/// A picture with its name.
pub struct Frame {
    pub name: String,
    pub drawing: Markup,
}

/// The figure; `id` must be unique in its page. Empty without frames.
pub fn film(id: &str, frames: &[Frame], title: &str, caption: &str) -> Markup {
    let count = frames.len();
    let button = |(k, frame): (usize, &Frame)| {
        let checked = match k + 1 == count {
            true => markup!(" checked"),
            false => Markup::default(),
        };
        markup!(
            "<label><input type=\"radio\" name=\"{}\"{}>{}</label>",
            id,
            checked,
            frame.name
        )
    };
    let picture = |frame: &Frame| markup!("<div><b>{}</b>{}</div>\n", frame.name, frame.drawing);
    markup!(
        "<figure class=\"film\">\n<style>\n{}{}</style>\n<div class=\"steps\">{}<label><input type=\"checkbox\">▶ all</label></div>\n\
         <div class=\"frames\">\n{}</div>\n<figcaption><b>{}.</b> {}</figcaption>\n</figure>\n",
        Markup::own(include_str!("film.css")),
        rules(count),
        frames.iter().enumerate().map(button).collect::<Markup>(),
        frames.iter().map(picture).collect::<Markup>(),
        title,
        caption
    )
    .titled(title)
}

/// Which picture is seen, by its button and by time.
fn rules(count: usize) -> Markup {
    let chosen = (1..=count).map(|k| {
        markup!(
            ".film:has(.steps label:nth-child({0}) > :checked) .frames > :nth-child({0}) {{ visibility: visible; }}\n",
            k
        )
    });
    let whole = EACH * count as f64;
    // a picture is ahead of the next one by its time
    let played = (1..=count).map(|k| {
        markup!(
            ".film:has([type=checkbox]:checked) .frames > :nth-child({}) {{ animation: film{} {}s step-end infinite; animation-delay: -{}s; }}\n",
            k,
            count,
            short(whole),
            short(whole - EACH * (k - 1) as f64)
        )
    });
    let frames = markup!(
        "@keyframes film{0} {{ 0% {{ visibility: visible; }} {1}% {{ visibility: hidden; }} 100% {{ visibility: hidden; }} }}\n",
        count,
        format!("{:.2}", 100.0 / count as f64)
    );
    chosen.chain(played).collect::<Markup>() + frames
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_frame_has_its_button_and_the_last_is_chosen() {
        let frame = |k: usize| Frame {
            name: format!("t < {k}"),
            drawing: markup!("<svg></svg>"),
        };
        let frames: Vec<Frame> = (0..3).map(frame).collect();
        let figure = film("film", &frames, "Course", "Words.");
        assert_eq!(figure.matches("type=\"radio\"").count(), 3);
        assert!(figure.contains("checked>t &lt; 2</label>") && figure.contains("33.33%"));
        assert_eq!(figure.matches("checked>").count(), 1);
        assert_eq!(figure.matches("<svg>").count(), 3);
        assert!(!figure.contains("<script"));
    }
}
