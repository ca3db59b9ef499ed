//! The numbers of labeled classes: on the terminal and in `summary.json`.

use ndarray::{Array1, Array2};
use serde::Serialize;

use crate::classes::{ClassLabels, Cleaned, most_probable};
use crate::counted::counted;
use crate::domain::{Domain, Element};
use crate::names::Named;
use crate::relaxation::Relaxation;
use crate::run::Status;
use crate::solve::Summary;

use super::input::Input;
use super::list::Class;
use crate::cli::segment::arguments::Arguments;
use crate::cli::solving::summary_lines;
use crate::cli::table;

/// The classes with what they cover.
pub struct Classes {
    pub all: Vec<Shown>,
    /// The share of the known area whose label is not the most probable class.
    pub relabeled_share: f64,
}

/// A class in the summary and in the table.
#[derive(Serialize)]
pub struct Shown {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// As which it is drawn.
    pub palette: [f64; 3],
    /// The area of its vertices' cells or of its faces.
    pub area: f64,
    /// Its share of the total area.
    pub share: f64,
    /// The share of the known area where it is the most probable class.
    pub most_probable_share: f64,
}

impl Classes {
    /// For labels and costs on the same domain.
    pub fn of(
        classes: &[Class],
        labels: &Array1<i32>,
        s: &Array2<f64>,
        domain: Domain<'_>,
    ) -> Self {
        let m = classes.len();
        let (mut areas, mut probable) = (vec![0.0; m], vec![0.0; m]);
        let (mut known, mut relabeled) = (0.0, 0.0);
        let cells = domain.cell_areas();
        for (k, &area) in cells.iter().enumerate() {
            let label = labels[k] as usize;
            areas[label] += area;
            let costs = s.row(k);
            if !costs[0].is_nan() {
                known += area;
                probable[most_probable(costs)] += area;
                // Of several most probable classes, none counts as changed.
                relabeled += if costs[label] > costs[most_probable(costs)] { area } else { 0.0 };
            }
        }
        let total: f64 = cells.iter().sum();
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        let shown = |(p, class): (usize, &Class)| Shown {
            name: class.name.clone(),
            palette: class.color,
            area: areas[p],
            share: share(areas[p], total),
            most_probable_share: share(probable[p], known),
        };
        Classes {
            relabeled_share: share(relabeled, known),
            all: classes.iter().enumerate().map(shown).collect(),
        }
    }
}

/// The numbers of every solve, and what classes add.
#[derive(Serialize)]
pub struct ClassSummary<'a> {
    #[serde(flatten)]
    pub summary: &'a Summary,
    pub data: &'a str,
    pub data_on: &'static str,
    pub model: &'static str,
    pub floor: Option<f64>,
    pub confidence: Option<f64>,
    pub unknown_rows: usize,
    pub left_out_faces: usize,
    pub edge_aware: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cleaned: Option<&'a Cleaned>,
    pub welded_vertices: usize,
    pub lambda_chosen: bool,
    pub seeds: usize,
    pub normalize: &'static str,
    pub scale: f64,
    pub relabeled_share: f64,
    pub region_parameters: &'a [Shown],
}

/// The text that is printed at the end.
pub fn report(
    found: &ClassLabels,
    classes: &Classes,
    input: &Input,
    on: Element,
    of_cut: Vec<(&'static str, String)>,
    arguments: &Arguments,
) -> String {
    let summary = &found.solution.summary;
    let mut lines = summary_lines(summary);
    if arguments.lambda.is_none() && summary.status != Status::Interrupted {
        let lambda = lines.iter_mut().find(|(name, _)| *name == "lambda");
        lambda.expect("it has a line").1 += ", chosen for these probabilities";
    }
    let m = classes.all.len();
    if let Some(pairs) = &arguments.solving.pairs {
        let reason = format!("cuts weigh as {} says", pairs.display());
        lines.push(("relaxation", format!("metric, {reason}")));
    } else if arguments.solving.relaxation.is_none() {
        let reason = match (m, on) {
            (2, _) => "all relaxations are the same for two classes",
            (_, Element::Faces) => "which is exact across edges",
            _ => "which certifies labels of more than two classes best",
        };
        lines.push(("relaxation", format!("{}, {reason}", Relaxation::for_labels(m).name())));
    }
    let [_, of] = input.costs.of.nouns();
    let [_, labeled] = on.nouns();
    lines.push(("classes", format!("{m}, given on {of}, labels on {labeled}")));
    lines.push((
        "relabeled",
        format!(
            "{:.2} % of the known area is not in its most probable class",
            100.0 * classes.relabeled_share
        ),
    ));
    if let Some(choice) = arguments.classes.edge_aware() {
        lines.push(("edge-aware", format!("cuts weigh by {}", choice.name())));
    }
    lines.extend(found.cleaned.as_ref().map(|cleaned| ("cleaned", cleaning(cleaned, classes))));
    lines.extend(of_cut);
    lines.extend(arguments.solving.written_to());
    table::pairs(&lines)
        + "\n"
        + &class_table(classes)
        + "\n"
        + &next_step(summary.lambda, arguments)
}

/// What was done to the labels in the end.
fn cleaning(cleaned: &Cleaned, classes: &Classes) -> String {
    let Cleaned { parts, area, energy_before, energy_after } = cleaned;
    if *parts == 0 {
        return "nothing: there are no such parts, or they have seeds".into();
    }
    let total: f64 = classes.all.iter().map(|class| class.area).sum();
    format!(
        "{} of labels, {:.2} % of the area; their energy was {}, now {}",
        counted(*parts, "part", "parts"),
        100.0 * area / total,
        table::number(*energy_before),
        table::number(*energy_after)
    )
}

fn class_table(classes: &Classes) -> String {
    let named = classes.all.iter().any(|class| class.name.is_some());
    let mut heading = vec!["class", "drawn", "area", "share", "most probable"];
    if named {
        heading.insert(1, "name");
    }
    let area = table::common_format(table::largest(classes.all.iter().map(|class| &class.area)), 4);
    let mut rows = vec![heading.into_iter().map(String::from).collect::<Vec<_>>()];
    rows.extend(classes.all.iter().enumerate().map(|(p, class)| {
        let [r, g, b] = class.palette.map(|c| (255.0 * c).round() as u8);
        let mut row = vec![
            p.to_string(),
            format!("#{r:02x}{g:02x}{b:02x}"),
            area(class.area),
            format!("{:.1} %", 100.0 * class.share),
            format!("{:.1} %", 100.0 * class.most_probable_share),
        ];
        if named {
            row.insert(1, class.name.clone().unwrap_or_default());
        }
        row
    }));
    table::columns(&rows)
}

/// Suggests what to inspect and what to try next.
fn next_step(lambda: f64, arguments: &Arguments) -> String {
    let try_next = match lambda > 0.0 {
        true => {
            format!("--lambda {:.1e} for fewer cuts, {:.1e} for more", 2.0 * lambda, 0.5 * lambda)
        }
        false => "a --lambda above 0 for fewer cuts".into(),
    };
    format!("{}try {try_next}\n", arguments.solving.see())
}
