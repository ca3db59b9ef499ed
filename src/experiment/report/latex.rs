//! `numbers.tex`: what a paper cites of an experiment, by name: the numbers of its tables, the captions of its figures, and
//! how its runs were made.

use super::page::PageFigure;
use super::pool::{self, Pool};
use super::table::Table;
use crate::figure::tex;

const RESULT_MACRO: &str = "\
% \\result{EXPERIMENT/TABLE/INSTANCE/SOLVER/COLUMN} is a number of a table: the names as they are, with \\%, \\&, \\#, \\$, \\{ and \\}.\n\
% \\result{EXPERIMENT/FIGURE/caption} is the caption of a figure; \\result{EXPERIMENT/made/...} says how the runs were made.\n\
\\providecommand{\\result}[1]{\\ifcsname meshseg@\\detokenize{#1}\\endcsname\n\
\x20 \\csname meshseg@\\detokenize{#1}\\endcsname\\else\\textbf{??}\\typeout{There is no result \\detokenize{#1}}\\fi}\n";

/// The text of the file.
pub fn numbers(pool: &Pool<'_>, tables: &[Table<'_>], figures: &[PageFigure]) -> String {
    let numbers = tables.iter().flat_map(Table::numbers).map(|(name, x)| (name, pool::latex(x)));
    let captions = figures
        .iter()
        .map(|figure| (format!("{}/caption", figure.stem()), tex::escaped(figure.caption())));
    let all = made(pool).into_iter().chain(captions).chain(numbers);
    let experiment = &pool.spec.name;
    let definitions = all.map(|(name, value)| definition(&format!("{experiment}/{name}"), &value));
    RESULT_MACRO.to_owned() + &definitions.collect::<String>()
}

/// How the runs were made: the machine of the times, the program, and how often.
fn made(pool: &Pool<'_>) -> Vec<(String, String)> {
    let Some(run) = pool.runs().find(|run| run.manifest.machine.host == pool.host) else {
        return Vec::new();
    };
    let (machine, program) = (&run.manifest.machine, &run.manifest.program);
    let short = program.commit.get(..7).unwrap_or(&program.commit);
    let entries = [
        ("processor", machine.cpu.clone()),
        ("cores", machine.cores.to_string()),
        ("memory", format!("{:.0}", machine.memory_gib)),
        ("version", program.version.clone()),
        ("commit", short.to_owned()),
        ("repetitions", pool.spec.repetitions.to_string()),
        ("runs", pool.runs().count().to_string()),
    ];
    entries.map(|(name, value)| (format!("made/{name}"), tex::escaped(&value))).into()
}

/// Defines a value by its name as typed in a document, and by its name with all LaTeX escapes.
fn definition(name: &str, value: &str) -> String {
    let define = |name: &str| {
        format!("\\expandafter\\def\\csname meshseg@\\detokenize{{{name}}}\\endcsname{{{value}}}\n")
    };
    let (typed, escaped) = (tex::typed(name), tex::escaped(name));
    define(&typed) + &if escaped == typed { String::new() } else { define(&escaped) }
}
