//! Tests of the numbers of a report.

mod numbers;

use super::pool::{Spread, given, latex, number};
use super::relation::power;
use super::table::{Table, TableEntry};

#[test]
fn quartiles_are_those_of_the_sorted_values() {
    let spread = |values: &[f64]| {
        let Spread { low, median, high } = Spread::of(values.to_vec());
        (low, median, high)
    };
    assert_eq!(spread(&[3.0]), (3.0, 3.0, 3.0));
    assert_eq!(spread(&[5.0, 1.0, 3.0, 2.0, 4.0]), (2.0, 3.0, 4.0));
    assert_eq!(spread(&[4.0, 1.0]), (1.75, 2.5, 3.25));
    // Runs that do not reach the gap raise the median, and give no NaN.
    assert_eq!(
        spread(&[f64::INFINITY, 1.0, f64::INFINITY]),
        (f64::INFINITY, f64::INFINITY, f64::INFINITY)
    );
    assert_eq!(spread(&[f64::INFINITY, 1.0, 2.0]).1, 2.0);
}

#[test]
fn a_power_law_is_fitted_exactly() {
    let points: Vec<[f64; 2]> =
        [1.0, 10.0, 100.0, 7.0].map(|x: f64| [x, 3.0 * x.powf(1.25)]).to_vec();
    let (exponent, factor) = power(&points).unwrap();
    assert!((exponent - 1.25).abs() < 1e-12 && (factor - 3.0).abs() < 1e-11);
    assert!(power(&points[..1]).is_none());
    assert!(power(&[[2.0, 1.0], [2.0, 3.0]]).is_none());
    assert!(power(&[[1.0, f64::INFINITY], [2.0, 0.0], [3.0, 1.0]]).is_none());
}

#[test]
fn numbers_are_short_and_keep_three_digits() {
    for (x, text) in [
        (0.0, "0"),
        (36.0, "36"),
        (0.0123456, "0.0123"),
        (12.3456, "12.3"),
        (1234.56, "1235"),
        (4.2e-5, "4.20e-5"),
        (-0.5, "-0.500"),
        (f64::INFINITY, "inf"),
    ] {
        assert_eq!(number(x), text);
    }
    for (x, text) in [(1e-3, "1e-3"), (0.02, "2e-2"), (0.25, "0.25"), (40.0, "40"), (2e6, "2e6")] {
        assert_eq!(given(x), text);
    }
}

fn table() -> Table<'static> {
    let entry = |text: &str| TableEntry::Text(text.into());
    Table {
        name: "t".into(),
        title: "Title".into(),
        columns: ["instance", "solver", "x", "y"].map(String::from).to_vec(),
        rows: vec![
            vec![
                entry("a|b"),
                entry("s_1"),
                TableEntry::Number(0.5),
                TableEntry::Censored("> 3".into()),
            ],
            vec![entry("c"), entry("s_2"), TableEntry::Number(1.0 / 3.0), TableEntry::Nothing],
        ],
        without: Vec::new(),
        sources: Vec::new(),
    }
}

#[test]
fn tables_are_written_as_markdown_csv_and_latex() {
    let table = table();
    assert!(table.is_numeric(2) && !table.is_numeric(0) && !table.is_numeric(3));
    let markdown = table.markdown();
    assert!(markdown.contains("| a\\|b | s_1 | 0.500 | > 3 |\n"), "{markdown}");
    assert!(markdown.contains("| --- | --- | ---: | --- |\n"), "{markdown}");
    let folder = tempfile::tempdir().unwrap();
    table.write(folder.path()).unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(read("t.csv").contains("c,s_2,0.3333333333333333,\n"));
    assert!(read("t.tex").contains("a$|$b & s\\_1 & 0.500 & \\textgreater{} 3 \\\\\n"));
    let numbers: Vec<(String, f64)> = table.numbers().collect();
    assert_eq!(numbers, [("t/a|b/s_1/x".to_owned(), 0.5), ("t/c/s_2/x".to_owned(), 1.0 / 3.0)]);
}

/// A spreadsheet computes no label, and what is read again is what was written.
#[test]
fn labels_are_no_formulas() {
    let mut table = table();
    let labels = ["=1+1", "'=1", "-x", "@a", "+1+1", "'quoted'", "\tx", "-1,cmd", "-1,0.2,0.3"];
    table.rows = (labels.iter())
        .map(|label| {
            vec![
                TableEntry::Text((*label).into()),
                TableEntry::Text("=s".into()),
                TableEntry::Number(-1.5),
                TableEntry::Nothing,
            ]
        })
        .collect();
    table.columns[3] = "=y".into();
    let folder = tempfile::tempdir().unwrap();
    table.write(folder.path()).unwrap();
    let path = folder.path().join("t.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("'=1+1,'=s,-1.5,\n") && text.contains("\"-1,0.2,0.3\",'=s"), "{text}");
    let cells = text.lines().flat_map(|line| line.split(','));
    assert!(
        cells
            .filter(|cell| *cell != "-1.5")
            .all(|cell| !cell.starts_with(['=', '+', '-', '@', '\t']))
    );
    let (columns, first) = (table.columns.clone(), table.markdown());
    table.read(&path).unwrap();
    assert_eq!((table.columns.clone(), table.markdown()), (columns, first));
}

#[test]
fn latex_has_powers_of_ten() {
    for (x, text) in [
        (12.0, "12"),
        (0.0213, "0.0213"),
        (-0.5, "\\ensuremath{-0.500}"),
        (3.654e-4, "\\ensuremath{3.65\\cdot10^{-4}}"),
        (f64::INFINITY, "\\ensuremath{\\infty}"),
    ] {
        assert_eq!(latex(x), text);
    }
}
