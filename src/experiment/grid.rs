//! From lists to cells: every list is swept, zipped lists in parallel, and excluded cells are dropped.

use std::ops::Range;

use super::document::{KeyValues, Scalar, Section, SpanError, SpanResult, Spanned};
use super::nearest::did_you_mean;

/// Larger experiments are mistakes, and would take forever.
pub const MAX_RUNS: u64 = 100_000;

/// The values of one cell by key, in the order of the file.
pub type Keys = Vec<(String, Scalar)>;

/// Like [`Keys`], each value with its span.
type CellKeys = Vec<(String, Spanned<Scalar>)>;

/// One `[[instance]]` or `[[solver]]`: keys with one value or several.
pub struct Group {
    pub keys: Vec<(String, Vec<Spanned<Scalar>>)>,
    /// Groups of keys whose lists are swept in parallel.
    pub zip: Vec<Vec<String>>,
}

impl Group {
    /// Reads `zip = ["a", "b"]`, or a list of such lists written as `"a, b"`, after the keys have been read.
    pub fn zipped(&mut self, section: &mut Section<'_>) -> SpanResult<()> {
        let texts = section.texts("zip")?;
        let Some(first) = texts.first() else { return Ok(()) };
        let lists: Vec<Vec<Spanned<String>>> = if texts.iter().any(|text| text.value.contains(','))
        {
            let names = |text: &Spanned<String>| {
                let parts = text.value.split(',').map(|name| name.trim().to_owned());
                parts.map(|value| Spanned { value, span: text.span.clone() }).collect()
            };
            texts.iter().map(names).collect()
        } else {
            vec![texts.clone()]
        };
        for list in lists {
            let mut lengths = Vec::new();
            for name in &list {
                let found = self.keys.iter().find(|(key, _)| *key == name.value);
                let Some((_, values)) = found else {
                    let keys: Vec<&str> = self.keys.iter().map(|(key, _)| key.as_str()).collect();
                    let meant = did_you_mean(&name.value, keys.iter().copied());
                    let message = format!(
                        "zip: {:?} is not among the keys {}{meant}",
                        name.value,
                        keys.join(", ")
                    );
                    return Err(SpanError::at(&name.span, message));
                };
                lengths.push(values.len());
            }
            if lengths.windows(2).any(|pair| pair[0] != pair[1]) {
                let lengths: Vec<String> = lengths.iter().map(usize::to_string).collect();
                let message =
                    format!("zip: the lists have different lengths: {}", lengths.join(" and "));
                return Err(SpanError::at(&first.span, message));
            }
            self.zip.push(list.into_iter().map(|name| name.value).collect());
        }
        Ok(())
    }

    /// For each key the index of the first key that is zipped with it.
    fn leaders(&self) -> Vec<usize> {
        let leader = |key: &str| {
            let zip = self.zip.iter().find(|zip| zip.iter().any(|name| name == key));
            self.keys.iter().position(|(name, _)| match zip {
                Some(zip) => zip.contains(name),
                None => name == key,
            })
        };
        self.keys.iter().map(|(key, _)| leader(key).expect("the key is there")).collect()
    }

    /// The cells, the last key changing fastest. Too many cells are an error at the table.
    pub fn cells(&self, table: &Range<usize>) -> SpanResult<Vec<CellKeys>> {
        let leaders = self.leaders();
        let lengths = self.keys.iter().enumerate().filter(|(i, _)| leaders[*i] == *i);
        let lengths = lengths.map(|(_, (_, values))| values.len() as u64);
        let count = lengths.fold(1, u64::saturating_mul);
        if count > MAX_RUNS {
            let message = format!("its lists make {count} cells; at most {MAX_RUNS} are allowed");
            return Err(SpanError::at(table, message));
        }
        let mut choices: Vec<Vec<usize>> = vec![Vec::new()];
        for (i, (_, values)) in self.keys.iter().enumerate() {
            choices = choices
                .into_iter()
                .flat_map(|choice| {
                    let range = if leaders[i] == i {
                        0..values.len()
                    } else {
                        choice[leaders[i]]..choice[leaders[i]] + 1
                    };
                    range.map(move |at| choice.iter().copied().chain([at]).collect())
                })
                .collect();
        }
        let cell = |choice: Vec<usize>| {
            let at = |((key, values), i): (&(String, Vec<Spanned<Scalar>>), usize)| {
                (key.clone(), values[i].clone())
            };
            self.keys.iter().zip(choice).map(at).collect()
        };
        Ok(choices.into_iter().map(cell).collect())
    }

    /// Whether a key has several values.
    pub fn varies(&self, key: &str) -> bool {
        self.keys.iter().any(|(name, values)| name == key && values.len() > 1)
    }
}

/// One `[[exclude]]`: a cell is dropped if each of these keys has one of its values there.
pub struct Exclusion(pub Vec<KeyValues>);

impl Exclusion {
    pub fn covers(&self, value: impl Fn(&str) -> Option<Scalar>) -> bool {
        self.0.iter().all(|(key, values)| {
            value(&key.value).is_some_and(|is| values.iter().any(|one| one.value.is(&is)))
        })
    }
}
