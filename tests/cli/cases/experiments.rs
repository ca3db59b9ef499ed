//! Names with unusual characters, results of another machine, results without labels, errors with lines, and previews.

use std::fs;
use std::path::Path;
use std::process::Command;

use ndarray::Array2;

use crate::support::{Folder, names, stderr};

/// A name with special characters of every target: a shell, Slurm, Snakemake, TeX, CSV, HTML, a terminal.
const ODD: &str =
    r#"part_50%_v2 & co #1 \\alpha {x} ~ ^ $y$ [z] | λ \u001b[2J </script><!-- \u0001"#;

fn odd() -> Folder {
    let folder = Folder::new();
    folder.write(
        "odd.toml",
        format!(
            r#"# Do 100 % of names with _, &, #, $, ~, ^, \ and <i>tags</i> survive?
repetitions = 1
stop = {{ gap = 1e-3, max-iterations = 200 }}
[[instance]]
label = "{ODD}"
mesh = "torus:12x8"
data = "waves"
noise = 0.3
regions = 3
lambda = [0.001, 0.01]
[[solver]]
label = "C_P, 100% [a]"
name = "chambolle-pock"
[[solver]]
label = "naïve $x$ λ"
name = "fista"
[[figure]]
name = "decay"
title = "A_b % of \\ & # everything \u0007"
kind = "decay"
[[table]]
name = "time_to_gap"
title = "100 % of_x & y <b>"
kind = "time-to-gap"
gaps = [1e-2, 1e-3, 1e-12]
"#
        ),
    );
    folder.done("experiment run odd.toml");
    folder.done("experiment report results/odd");
    folder
}

/// Whether LaTeX compiles a document; true if LaTeX is missing, with a note that the check is skipped.
fn typeset(folder: &Path, body: &str, packages: &str) -> bool {
    let document = format!(
        "\\documentclass{{article}}\n{packages}\\begin{{document}}\n{body}\n\\end{{document}}\n"
    );
    fs::write(folder.join("document.tex"), document).unwrap();
    let run = Command::new("pdflatex")
        .args(["-interaction=nonstopmode", "-halt-on-error", "document.tex"])
        .current_dir(folder)
        .output();
    let Ok(output) = run else {
        eprintln!("skipped: there is no pdflatex");
        return true;
    };
    let log = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{log}");
    !log.contains("There is no result")
}

#[test]
fn tables_numbers_and_pages_take_any_name() {
    let folder = odd();
    let results = folder.path("results/odd");
    let text = |name: &str| fs::read_to_string(results.join(name)).unwrap();

    let numbers = text("numbers.tex");
    // As typed between braces, and with all escapes.
    let name = |part: &str| numbers.lines().any(|line| line.contains(part));
    assert!(name(
        "\\detokenize{odd/time_to_gap/part_50\\%_v2 \\& co \\#1 \\textbackslash{}alpha \\{x\\} ~ ^"
    ));
    assert!(name("/C_P, 100\\% [a]/"), "{numbers}");
    assert!(name("/C\\_P, 100\\% {[}a{]}/"), "{numbers}");
    let mut defined = numbers.lines().filter(|line| line.starts_with("\\expandafter"));
    assert!(defined.all(|line| line.matches('{').count() == line.matches('}').count()));

    let table = text("tables/time_to_gap.tex");
    assert!(table.contains("$\\lambda$") && !table.contains('\u{1b}'), "{table}");
    assert!(table.contains("C\\_P, 100\\% {[}a{]} & "), "{table}");
    let markdown = text("tables/time_to_gap.md");
    assert!(markdown.contains("\\| λ") && !markdown.contains("</script>"), "{markdown}");
    let columns = |line: &str| line.replace("\\|", "").matches('|').count();
    let rows: Vec<&str> = markdown.lines().skip(2).collect();
    assert!(rows.iter().all(|row| columns(row) == columns(rows[0])), "{markdown}");
    let csv = text("tables/time_to_gap.csv");
    let rows: Vec<csv::StringRecord> =
        csv::Reader::from_reader(csv.as_bytes()).records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 4);
    assert!(rows[0][0].starts_with("part_50%_v2 & co #1 \\alpha {x} ~ ^ $y$ [z] | λ \u{1b}[2J"));

    let page = text("report.html");
    assert_eq!(page.matches("</script>").count(), page.matches("<script").count());
    let (_, rest) = page.split_once("id=\"report-data\"").unwrap();
    let data = rest.split_once('>').unwrap().1.split_once("</script>").unwrap().0;
    assert!(!data.contains('<'));
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    assert!(data["instances"][0]["label"].as_str().unwrap().contains("</script><!-- \u{1}"));

    for verb in ["experiment list odd.toml", "experiment why results/odd/figures/decay.svg"] {
        let listed = folder.done(verb);
        assert!(listed.contains("C_P, 100% [a]") && listed.contains("\\u{1b}[2J"), "{listed}");
        assert!(!listed.chars().any(|c| c.is_control() && c != '\n'), "{listed:?}");
    }
}

#[test]
fn latex_compiles_tables_numbers_and_figures() {
    let folder = odd();
    let results = folder.path("results/odd");
    assert!(typeset(&results, "\\input{tables/time_to_gap.tex}", "\\usepackage{booktabs}\n"));
    let plain = "part_50\\%_v2 \\& co \\#1 \\textbackslash{}alpha \\{x\\} ~ ^ \\$y\\$ [z] | λ  [2J \
                 </script><!--  , lambda 0.001";
    let used = format!(
        "\\input{{numbers.tex}}\n\
         FISTA: \\result{{odd/time_to_gap/{plain}/naïve \\$x\\$ λ/iterations to 1e-2}},\n\
         ours: \\result{{odd/time_to_gap/{plain}/C_P, 100\\% [a]/iterations to 1e-2}}\n"
    );
    assert!(typeset(&results, &used, ""));
    let missing = "\\input{numbers.tex}\\result{odd/time_to_gap/nothing/of_that/kind}";
    if Command::new("pdflatex").arg("--version").output().is_ok() {
        assert!(!typeset(&results, missing, ""));
    }
    let packages = "\\usepackage{tikz,pgfplots}\\usepgfplotslibrary{groupplots,fillbetween}\
                    \\pgfplotsset{compat=1.16}\n";
    let has = |package: &str| {
        Command::new("kpsewhich").arg(package).output().is_ok_and(|out| !out.stdout.is_empty())
    };
    if has("pgfplots.sty") && has("pgfplotstable.sty") {
        let packages = packages.to_owned() + "\\usepackage{pgfplotstable}\n";
        assert!(typeset(&results.join("figures"), "\\input{decay.tex}", &packages));
    }
}

/// The `sbatch` of this test takes the first word that is not an option for the script, like the real one.
#[test]
fn the_batch_script_takes_any_name() {
    let folder = Folder::new();
    let text = "stop = { gap = 1e-2, max-iterations = 50 }\n[[instance]]\nmesh = \"torus:12x8\"\n\
                data = \"waves\"\nregions = 2\nlambda = [0.001, 0.002]\n[[solver]]\nname = \"fista\"\n";
    fs::create_dir(folder.path("bin")).unwrap();
    folder.write(
        "bin/sbatch",
        "#!/bin/sh\nfor a in \"$@\"; do case \"$a\" in -*) ;; *) [ -f \"$a\" ] || exit 1;; esac; done\n\
         for a in \"$@\"; do case \"$a\" in --wrap=*) printf '%s' \"${a#--wrap=}\" > wrapped;; esac; done\n",
    );
    let chmod = Command::new("chmod").arg("+x").arg(folder.path("bin/sbatch")).status();
    assert!(chmod.unwrap().success());
    let path = format!("{}:{}", folder.path("bin").display(), std::env::var("PATH").unwrap());
    for name in
        ["noise sweep", "it's {x} 50% $HOME `id` \"q\" #1 & λ \u{1f42e} \\", "two\nlines", "-dash"]
    {
        let file = format!("{name}.toml");
        fs::write(folder.path(&file), text).unwrap();
        let file = if name.starts_with('-') { format!("./{file}") } else { file };
        let emitted = Command::new(crate::support::PROGRAM)
            .args(["experiment", "run", &file, "--emit", "slurm", "--jobs", "1"])
            .current_dir(folder.path(""))
            .output()
            .unwrap();
        assert!(emitted.status.success(), "{}", stderr(&emitted));
        let script = String::from_utf8(emitted.stdout).unwrap();
        let directives = script.lines().filter(|line| line.starts_with("#SBATCH"));
        assert!(directives.clone().count() >= 3);
        assert!(directives.clone().all(|line| line.split_whitespace().count() == 2), "{script}");
        folder.write("batch.sh", &script);
        let bash = |script: &str| {
            let output = Command::new("bash")
                .arg(script)
                .current_dir(folder.path(""))
                .env("PATH", &path)
                .env("SLURM_ARRAY_TASK_ID", "1")
                .env("SLURM_ARRAY_JOB_ID", "77")
                .output()
                .unwrap();
            assert!(output.status.success(), "{name}: {}", stderr(&output));
        };
        bash("batch.sh");
        bash("wrapped");
        assert_eq!(names(&folder.path(&format!("results/{name}/runs"))).len(), 2, "{name}");
        assert!(folder.path(&format!("results/{name}/report.html")).is_file(), "{name}");
    }
}

/// The Python strings have unescaped braces only where Snakemake inserts something.
#[test]
fn names_do_not_add_wildcards_to_the_snakefile() {
    let folder = Folder::new();
    for name in ["a {i} b", "{{wildcards}}", "it's {"] {
        let file = format!("{name}.toml");
        fs::write(folder.path(&file), crate::experiment::SMALL).unwrap();
        let emitted = folder.done(&format!(
            "experiment run {} --emit snakemake --jobs 2",
            file.replace(' ', "%20")
        ));
        for line in emitted.lines().filter(|line| !line.starts_with('#')) {
            let texts = line.split('"').skip(1).step_by(2);
            for text in texts {
                let own = text.replace("{wildcards.i}", "").replace("{i}-of-2", "");
                let shell = line.trim_start().starts_with("shell:");
                let left = if shell { own.replace("{{", "").replace("}}", "") } else { own };
                assert!(!left.contains(['{', '}']), "{emitted}");
            }
        }
    }
}

#[test]
fn runs_of_another_machine_are_announced() {
    let folder = crate::experiment::small();
    folder.done("experiment run small.toml");
    let quiet = folder.run("experiment run small.toml");
    assert!(!stderr(&quiet).contains("another machine"), "{}", stderr(&quiet));
    let runs = folder.path("results/small/runs");
    for (i, id) in names(&runs).iter().enumerate() {
        let path = runs.join(id).join("manifest.json");
        let text = fs::read_to_string(&path).unwrap();
        let host = text.split("\"host\": \"").nth(1).unwrap()[..8].to_owned();
        let text = match i {
            0 => text.replace("\"commit\": \"", "\"commit\": \"0123456789abcdef"),
            _ => text.replace(&host, "feedbeef"),
        };
        fs::write(path, text).unwrap();
    }
    let output = folder.run("experiment run small.toml");
    let messages = stderr(&output);
    assert!(messages.contains("9 runs were made on another machine (feedbeef, "), "{messages}");
    assert!(messages.contains("1 run was made on this machine"), "{messages}");
    assert!(
        messages.contains("at commit 0123456789ab") && messages.contains("--force"),
        "{messages}"
    );
    folder.done("experiment run small.toml --force");
    let output = folder.run("experiment run small.toml");
    assert!(!stderr(&output).contains("runs were made"), "{}", stderr(&output));
}

/// As in a clone, which lacks large files.
#[test]
fn a_report_without_labels_keeps_the_files_that_need_them() {
    let folder = Folder::new();
    let more = "\n[[figure]]\nname = \"changed\"\nkind = \"relation\"\nx = \"lambda\"\n\
                y = \"labels-changed\"\nlog-y = false\n\n[[table]]\nname = \"labels\"\nkind = \"cells\"\n\
                columns = [\"labels-changed\", \"energy\"]\n";
    let text = crate::experiment::SMALL.replace("lambda = 0.01", "lambda = [0.01, 0.1]") + more;
    folder.write("small.toml", &text);
    folder.done("experiment run small.toml");
    folder.done("experiment report results/small");
    let results = folder.path("results/small");
    let read = || -> Vec<(String, Vec<u8>)> {
        ["figures", "tables"]
            .iter()
            .flat_map(|part| {
                names(&results.join(part)).into_iter().map(move |name| format!("{part}/{name}"))
            })
            .chain(["numbers.tex".to_owned()])
            .map(|name| (name.clone(), fs::read(results.join(&name)).unwrap()))
            .collect()
    };
    let before = read();
    fs::remove_dir_all(results.join("instances")).unwrap();
    for id in names(&results.join("runs")) {
        for array in ["labels.npy", "certainty.npy"] {
            let path = results.join("runs").join(&id).join(array);
            if path.exists() {
                fs::remove_file(path).unwrap();
            }
        }
    }
    let output = folder.run("experiment report results/small");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let messages = stderr(&output);
    assert!(messages.contains("figures/changed.svg is unchanged"), "{messages}");
    assert!(messages.contains("tables/labels.csv is unchanged"), "{messages}");
    for (old, new) in before.iter().zip(read()) {
        assert!(*old == new, "{}", old.0);
    }
    // If there is no file to keep, the rest is written nevertheless.
    fs::remove_dir_all(results.join("figures")).unwrap();
    let output = folder.run("experiment report results/small");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("figures/changed.svg is left out"), "{}", stderr(&output));
    assert!(names(&results.join("figures")).contains("decay.svg"));
}

/// Checks that a command fails with an error that contains these parts.
fn refused(folder: &Folder, line: &str, parts: &[&str]) {
    let output = folder.run(line);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{line}: {message}");
    let error = message.lines().find(|line| line.starts_with("error: ")).unwrap();
    for part in parts {
        assert!(error.contains(part), "{part:?} is not in {error}");
    }
}

#[test]
fn missing_files_and_data_are_named_with_their_lines() {
    use crate::experiment::SMALL;
    let folder = Folder::new();
    let change = |from: &str, to: &str| {
        assert!(SMALL.contains(from), "{from}");
        folder.write("e.toml", SMALL.replacen(from, to, 1));
    };
    change("\"torus:20x12\", \"torus:24x16\"", "\"torus:24x16\", \"no/such.ply\"");
    refused(&folder, "experiment run e.toml", &["e.toml, line 8, column 24", "no/such.ply"]);
    folder.write("bare.obj", crate::support::SQUARE_OBJ);
    change(
        "[\"torus:20x12\", \"torus:24x16\"]\ndata = \"waves\"",
        "\"bare.obj\"\ndata = \"colors\"",
    );
    let text = fs::read_to_string(folder.path("e.toml")).unwrap();
    folder.write("e.toml", text.replace("mesh = \"torus:24x16\"\n", ""));
    refused(
        &folder,
        "experiment run e.toml",
        &["e.toml, line 9, column 8", "no colors of vertices"],
    );
    folder.write("broken.obj", "v 0 0\n");
    change("\"torus:20x12\", \"torus:24x16\"", "\"torus:24x16\", \"broken.obj\"");
    refused(&folder, "experiment run e.toml", &["e.toml, line 8, column 24", "broken.obj, line 1"]);
    change("data = \"waves\"", "data = \"values.npy\"");
    refused(&folder, "experiment run e.toml", &["e.toml, line 9, column 8", "values.npy"]);

    // The bias needs a smoothed energy, which no run has here.
    change("y = \"iterations\"\ngap = 1e-2", "y = \"bias\"");
    let text = fs::read_to_string(folder.path("e.toml")).unwrap();
    let (kept, _) = text.split_once("[[solver]]\nlabel = \"FISTA\"").unwrap();
    let (_, rest) = text.split_once("solver = \"fista\"\n").unwrap();
    folder.write("e.toml", kept.to_owned() + rest);
    folder.done("experiment run e.toml");
    let line = 1 + kept.lines().count() + rest.lines().position(|l| l.contains("bias")).unwrap();
    let place = format!("line {line}, column 5: the figure \"relation\" has nothing to show");
    refused(&folder, "experiment report results/e", &["results/e/experiment.toml", &place, "bias"]);
    assert!(folder.path("results/e/figures/decay.svg").is_file());
    assert!(folder.path("results/e/report.html").is_file());
}

#[test]
fn misspelled_names_are_guessed() {
    use crate::experiment::SMALL;
    let folder = Folder::new();
    for (from, to, meant) in [
        ("repetitions = 2", "repetition = 2", "repetitions"),
        ("max-iterations", "max_iterations", "max-iterations"),
        ("noise = 0.3", "nose = 0.3", "noise"),
        ("data = \"waves\"", "data = \"wave\"", "waves"),
        ("name = \"fista\"", "name = \"fitsa\"", "fista"),
        ("name = \"chambolle-pock\"", "name = \"chambolle_pock\"", "chambolle-pock"),
        ("rho = [1.9, 1.5]", "roh = 1.9", "rho"),
        ("kind = \"decay\"", "kind = \"decays\"", "decay"),
        ("kind = \"relation\"", "kind = \"relations\"", "relation"),
        ("y = \"iterations\"", "y = \"iteration\"", "iterations"),
        ("\"excess\"", "\"exces\"", "excess"),
        (
            "title = \"A figure\"",
            "only = \"tors:20x12\"",
            "torus:20x12, waves, 4 regions, lambda 0.01",
        ),
        ("title = \"A figure\"", "solvers = \"Fist\"", "FISTA"),
        ("mesh = \"torus:24x16\"", "mehs = \"torus:24x16\"", "mesh"),
        ("lambda = 0.01", "lambda = 0.01\nmass = \"voronoy\"", "voronoi"),
    ] {
        assert!(SMALL.contains(from), "{from}");
        folder.write("e.toml", SMALL.replacen(from, to, 1));
        let meant = format!("did you mean {meant:?}?");
        refused(&folder, "experiment list e.toml", &["e.toml, line ", &meant]);
    }
    folder.write("e.toml", SMALL);
    let line = "problem export e.toml --instance torus:20x13 --out p.npz";
    refused(&folder, line, &["did you mean \"torus:20x12, "]);
}

/// Number of distinct colors in the left half of a picture, rounded so that shading does not count.
fn hues(folder: &Folder, path: &str) -> usize {
    let image = image::open(folder.path(path)).unwrap().to_rgb8();
    let mut hues: Vec<[i32; 3]> = Vec::new();
    for x in 0..image.width() / 2 {
        let pixel = image.get_pixel(x, image.height() / 2).0.map(i32::from);
        let near = |other: &[i32; 3]| (0..3).all(|c| (other[c] - pixel[c]).abs() < 40);
        if pixel != [255; 3] && !hues.iter().any(near) {
            hues.push(pixel);
        }
    }
    hues.len()
}

/// Data that differ only in a later column, or outside the range of colors, are visible.
#[test]
fn the_picture_shows_every_column() {
    let folder = Folder::new();
    for (d, low, high) in
        [(1, -3.0, 900.0), (2, 0.0, 1.0), (3, -1.0, 1.0), (3, 0.0, 255.0), (5, 0.0, 1.0)]
    {
        // The last column: the left half of the grid low, the right half high.
        let values =
            Array2::from_shape_fn((21 * 11, d), |(k, i)| match (i + 1 == d, k % 21 < 10) {
                (true, true) => low,
                (true, false) => high,
                (false, _) => 0.3,
            });
        folder.array("values.npy", &values);
        folder.done("segment grid:20x10 --data values.npy --regions 2 --out out");
        assert!(hues(&folder, "out/preview.png") >= 2, "{d} columns from {low} to {high}");
    }
    // A flat mesh is viewed from the front, with its aspect ratio.
    let image = image::open(folder.path("out/preview.png")).unwrap();
    assert!(image.width() == 1200 && image.height() < 450, "{}", image.height());
}

#[test]
fn the_table_lists_drawn_colors_and_views_can_be_chosen() {
    let folder = Folder::new();
    let table = folder.done("segment builtin:spot --regions 2 --gap 1e-2 --view 30,10 --out out");
    assert!(
        table.contains("drawn") && table.contains("#56b4e9") && table.contains("#e69f00"),
        "{table}"
    );
    let one = image::open(folder.path("out/preview.png")).unwrap();
    for view in ["front", "back", "x", "-x", "y", "-y", "z", "-z", "-200,-30"] {
        folder.done(&format!(
            "segment sphere:2 --data curvature --regions 2 --view {view} --out view"
        ));
    }
    folder.done("segment builtin:spot --regions 2 --gap 1e-2 --view -x --out side");
    assert_ne!(one, image::open(folder.path("side/preview.png")).unwrap());
    let output = folder.run("segment builtin:spot --regions 2 --view left --out none");
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("AZIMUTH,ELEVATION"), "{}", stderr(&output));
}
