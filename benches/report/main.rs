//! Turns criterion's output into a page: results/bench/README.md and steps.svg. Run by `make bench-report`.

mod chart;
mod machine;
mod measured;

use std::fmt::Write as _;
use std::path::Path;

use measured::{Measured, Name, read};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let all = read(Path::new("target/criterion"))?;
    let folder = Path::new("results/bench");
    std::fs::create_dir_all(folder)?;
    chart::draw(&all, &folder.join("steps.svg"))?;
    std::fs::write(folder.join("README.md"), page(&all)?)?;
    println!("wrote {}", folder.join("README.md").display());
    Ok(())
}

/// The median of the benchmark with that group and id, in seconds.
fn median(all: &[Measured], group: &str, id: &str) -> Option<f64> {
    all.iter().find(|m| m.group == group && m.id == id).map(|m| m.median)
}

/// The seconds that a triad takes for the same bytes with the same number of threads.
pub fn limit(all: &[Measured], step: &Measured) -> Option<f64> {
    let Name { precision, threads, .. } = step.name();
    let m = step.group.strip_prefix("step, m = ")?;
    median(all, "triad", &format!("m = {m}, {precision}, {threads} thread(s)"))
}

fn page(all: &[Measured]) -> Result<String, std::fmt::Error> {
    let mut page = String::new();
    writeln!(page, "# Measured times, compared with their limits\n")?;
    writeln!(page, "Written by `make bench-report`; do not edit. {}\n", machine::sentence())?;
    writeln!(
        page,
        "torus:400x250, 200,000 faces, noisy palette, lambda = 0.005. Medians, with \
         95 % intervals of criterion's bootstrap. All ratios are between times of this run.\n"
    )?;
    writeln!(page, "## Memory\n")?;
    writeln!(page, "A triad, a <- b + 3 c, on as many bytes as one step must move at least.\n")?;
    writeln!(page, "| working set | ms | GB/s |\n|---|---|---|")?;
    for m in all.iter().filter(|m| m.group == "triad") {
        writeln!(page, "| {} | {:.3} | {:.1} |", m.id, 1e3 * m.median, m.rate().unwrap_or(0.0))?;
    }
    writeln!(page, "\n## One step\n\n![Time of a step](steps.svg)\n")?;
    writeln!(
        page,
        "The limit is the triad's time for the bytes of a step: u and q read and written, f, step sizes, weights and \
         corners read, each once. The fused engine makes several steps in one pass and can be faster than that. \
         Solver steps are measured in groups of eight, the number between early evaluations of the gap in the \
         program. The ratios say how many times slower a step is than the limit, and how many times faster than the \
         loops fused by hand (double precision, baseline instructions, one thread) or than sparse products of the \
         same precision and number of threads, both on the torus in its original numbering.\n"
    )?;
    writeln!(
        page,
        "| regions | what | threads | ms | 95 % | GB/s | over the limit | faster than by hand | faster than sparse products |\n\
         |---|---|---|---|---|---|---|---|---|"
    )?;
    for step in all.iter().filter(|m| m.group.starts_with("step, ")) {
        let Name { what, precision, threads } = step.name();
        let by_hand = median(all, &step.group, "fused by hand f64, 1 thread(s)");
        let sparse =
            median(all, &step.group, &format!("sparse products {precision}, {threads} thread(s)"));
        let times = |other: Option<f64>| {
            other.map_or("".into(), |other| format!("{:.2}", other / step.median))
        };
        writeln!(
            page,
            "| {} | {what} | {threads} | {:.3} | {:.3} to {:.3} | {:.1} | {} | {} | {} |",
            step.group.trim_start_matches("step, m = "),
            1e3 * step.median,
            1e3 * step.low,
            1e3 * step.high,
            step.rate().unwrap_or(0.0),
            limit(all, step).map_or("".into(), |limit| format!("{:.2}", step.median / limit)),
            times(by_hand.filter(|_| threads == "1")),
            times(sparse),
        )?;
    }
    writeln!(page, "\n## To a certified gap\n")?;
    writeln!(
        page,
        "The time in the steps, with two threads, also in units of a step of sparse products of the same precision; \
         the gap is evaluated at the program's iterations, off the clock. Times from coarser meshes include building \
         these meshes and the runs on them.\n"
    )?;
    solves(&mut page, all)?;
    writeln!(page, "\n## Before the first step\n")?;
    table(&mut page, all, |group| group == "set-up" || group.starts_with("readers"))?;
    writeln!(page, "\n## Projection\n")?;
    table(&mut page, all, |group| group.starts_with("simplex"))?;
    Ok(page)
}

fn solves(page: &mut String, all: &[Measured]) -> Result<(), std::fmt::Error> {
    writeln!(
        page,
        "| lambda | what | ms | 95 % | steps of sparse products |\n|---|---|---|---|---|"
    )?;
    for m in all {
        let Some(lambda) = m.group.strip_prefix("solve, lambda = ") else { continue };
        let Measured { id, median: time, low, high, .. } = m;
        let precision = if id.contains("precision=f32") { "f32" } else { "f64" };
        let step = median(all, "step, m = 4", &format!("sparse products {precision}, 2 thread(s)"));
        let steps = step.map_or("".into(), |step| format!("{:.1}", time / step));
        let (ms, low, high) = (1e3 * time, 1e3 * low, 1e3 * high);
        writeln!(page, "| {lambda} | {id} | {ms:.2} | {low:.2} to {high:.2} | {steps} |")?;
    }
    Ok(())
}

fn table(
    page: &mut String,
    all: &[Measured],
    wanted: impl Fn(&str) -> bool,
) -> Result<(), std::fmt::Error> {
    writeln!(page, "| group | what | ms | 95 % |\n|---|---|---|---|")?;
    for m in all.iter().filter(|m| wanted(&m.group)) {
        let Measured { group, id, median, low, high, .. } = m;
        writeln!(
            page,
            "| {group} | {id} | {:.2} | {:.2} to {:.2} |",
            1e3 * median,
            1e3 * low,
            1e3 * high
        )?;
    }
    Ok(())
}
