//! The page that shows results in a browser: one file that needs no network, see `assets/report/README.md`.

use serde_json::Value;

/// The page without data.
const TEMPLATE: &str = include_str!("../../assets/report/dist/template.html");
/// The placeholder of the data in the template.
const DATA_MARK: &str = "/*REPORT_DATA*/";

/// The page with its data, as HTML.
pub fn page(data: &Value) -> String {
    TEMPLATE.replacen(DATA_MARK, &within_script(data), 1)
}

/// JSON in which no string can end the script or open a comment in it.
fn within_script(data: &Value) -> String {
    data.to_string()
        .replace('<', "\\u003c")
        .replace('\u{2028}', "\\u2028")
        .replace('\u{2029}', "\\u2029")
}
