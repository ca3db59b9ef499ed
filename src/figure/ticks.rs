//! The ticks of an axis and their labels.

use super::Scale;
use super::range::Range;

/// Minimum distance between labels of a linear axis, and minimum length of a decade that is divided, in points.
const MIN_LABEL_DISTANCE: f64 = 20.0;
/// Decades that are shorter, in points, have no minor ticks.
const MIN_TICKED_DECADE: f64 = 3.0;
/// An axis with fewer decades has other labels in addition to powers of ten.
const MIN_POWERS_ONLY_DECADES: f64 = 1.5;

/// digits * 10^exponent, exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decimal {
    pub digits: i64,
    pub exponent: i32,
}

impl Decimal {
    fn value(self) -> f64 {
        format!("{}e{}", self.digits, self.exponent).parse().expect("digits and an exponent")
    }

    pub fn position(self, scale: Scale) -> f64 {
        match scale {
            Scale::Linear => self.value(),
            Scale::Log => (self.digits as f64).log10() + f64::from(self.exponent),
        }
    }

    /// The exponent of its first digit; zero has none.
    fn magnitude(self) -> Option<i32> {
        let log = self.digits.unsigned_abs().checked_ilog10()?;
        Some(log as i32 + self.exponent)
    }

    /// The number in decimal notation without redundant digits.
    fn plain(self) -> String {
        let mut digits = self.digits.unsigned_abs().to_string();
        if self.digits != 0 {
            if self.exponent >= 0 {
                digits.push_str(&"0".repeat(self.exponent as usize));
            } else {
                let decimals = self.exponent.unsigned_abs() as usize;
                let digits_before = format!("{digits:0>width$}", width = decimals + 1);
                let (whole, part) = digits_before.split_at(digits_before.len() - decimals);
                let part = part.trim_end_matches('0');
                let point = if part.is_empty() { "" } else { "." };
                digits = format!("{whole}{point}{part}");
            }
        }
        if self.digits < 0 { format!("{MINUS}{digits}") } else { digits }
    }
}

/// The minus sign, which unlike a hyphen is as wide as a digit.
pub const MINUS: char = '\u{2212}';

/// A number, or a number that ends in a power of ten.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    pub text: String,
    pub exponent: Option<String>,
}

impl Label {
    fn plain(number: Decimal) -> Self {
        Label { text: number.plain(), exponent: None }
    }

    /// The label of a number as a factor times 10^exponent.
    fn scaled(number: Decimal, exponent: i32) -> Self {
        if number.digits == 0 {
            return Label::plain(number);
        }
        let factor = Decimal { exponent: number.exponent - exponent, ..number };
        Label { text: format!("{}\u{d7}10", factor.plain()), exponent: Some(signed(exponent)) }
    }

    fn power(exponent: i32) -> Self {
        Label { text: "10".to_owned(), exponent: Some(signed(exponent)) }
    }
}

fn signed(exponent: i32) -> String {
    exponent.to_string().replace('-', &MINUS.to_string())
}

#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    pub number: Decimal,
    pub label: Label,
}

#[derive(Clone, Debug, Default)]
pub struct Ticks {
    pub major: Vec<Tick>,
    /// Without a label.
    pub minor: Vec<Decimal>,
}

/// The ticks of an axis that is `length` points long; `room` gives the extent of a label along it.
pub fn ticks(range: &Range, length: f64, room: &dyn Fn(&Label) -> f64) -> Ticks {
    let axis = Spaced { range, length, room };
    match range.scale {
        Scale::Linear => Ticks { major: axis.linear([range.low, range.high]), minor: Vec::new() },
        Scale::Log => axis.log(),
    }
}

struct Spaced<'a> {
    range: &'a Range,
    length: f64,
    room: &'a dyn Fn(&Label) -> f64,
}

impl Spaced<'_> {
    fn shows(&self, number: Decimal) -> bool {
        // A tick at the end of an axis must not be lost by rounding.
        (-1e-9..=1.0 + 1e-9).contains(&self.range.share(number.position(self.range.scale)))
    }

    fn fit(&self, ticks: &[Tick]) -> bool {
        let position =
            |tick: &Tick| self.range.share(tick.number.position(self.range.scale)) * self.length;
        ticks.windows(2).all(|pair| {
            let room = ((self.room)(&pair[0].label) + (self.room)(&pair[1].label)) / 2.0;
            position(&pair[1]) - position(&pair[0]) >= room
        })
    }

    /// Multiples of 1, 2 or 5 times a power of ten between two numbers; the densest ones whose labels fit.
    fn linear(&self, [low, high]: [f64; 2]) -> Vec<Tick> {
        let span = high - low;
        let smallest = span.log10().floor() as i32 - 2;
        let mut widest = Vec::new();
        for (exponent, factor) in
            (smallest..=smallest + 3).flat_map(|e| [1, 2, 5].map(|factor| (e, factor)))
        {
            let step = Decimal { digits: factor, exponent }.value();
            if step / span * self.length < MIN_LABEL_DISTANCE {
                continue;
            }
            let numbers = ((low / step).floor() as i64..=(high / step).ceil() as i64)
                .map(|k| Decimal { digits: k * factor, exponent })
                .filter(|&number| self.shows(number));
            let ticks = labeled(numbers.collect());
            if ticks.len() >= 2 && self.fit(&ticks) {
                return ticks;
            }
            if !ticks.is_empty() {
                widest = ticks;
            }
        }
        // One label always fits.
        widest.truncate(1);
        widest
    }

    fn log(&self) -> Ticks {
        let Range { low, high, .. } = *self.range;
        let span = high - low;
        let decade = self.length / span;
        let exponents = low.floor() as i32..=high.ceil() as i32;
        let within = |factors: &[i64]| -> Vec<Decimal> {
            let numbers = exponents.clone().flat_map(|exponent| {
                factors.iter().map(move |&digits| Decimal { digits, exponent })
            });
            numbers.filter(|&number| self.shows(number)).collect()
        };
        let decades = within(&[1]);
        let all = within(&[1, 2, 3, 4, 5, 6, 7, 8, 9]);
        let minor = |major: &[Tick], candidates: &[Decimal]| -> Vec<Decimal> {
            let is_major = |number: &Decimal| major.iter().any(|tick| tick.number == *number);
            candidates.iter().filter(|number| !is_major(number)).copied().collect()
        };
        let few = span < MIN_POWERS_ONLY_DECADES || decades.len() < 2;
        if few {
            let plain = low >= -3.0 && high <= 5.0;
            // Long labels leave room for fewer.
            for factors in [&[1, 2, 5][..], &[1, 3], &[1, 5], &[1, 2], &[3], &[5], &[2]] {
                let label = |number: Decimal| match number {
                    _ if plain => Label::plain(number),
                    Decimal { digits: 1, exponent } => Label::power(exponent),
                    _ => Label::scaled(number, number.exponent),
                };
                let major: Vec<Tick> = within(factors)
                    .into_iter()
                    .map(|number| Tick { number, label: label(number) })
                    .collect();
                if major.len() >= 2 && self.fit(&major) {
                    return Ticks { minor: minor(&major, &all), major };
                }
            }
        }
        if few && span < 1.0 {
            let major = self.linear([10f64.powf(low), 10f64.powf(high)]);
            return Ticks { major, minor: Vec::new() };
        }
        let every = |step: i32| -> Vec<Tick> {
            let numbers = decades.iter().filter(|number| number.exponent % step == 0);
            numbers.map(|&number| Tick { number, label: Label::power(number.exponent) }).collect()
        };
        let steps = [1, 2, 3, 5, 10, 20, 50, 100, 200, 500];
        let major = steps.into_iter().map(every).find(|major| self.fit(major)).unwrap_or_default();
        let candidates = match decade {
            MIN_LABEL_DISTANCE.. => &all[..],
            MIN_TICKED_DECADE.. => &decades,
            _ => &[],
        };
        Ticks { minor: minor(&major, candidates), major }
    }
}

/// Labels the numbers either all in plain notation or all with the same power of ten.
fn labeled(numbers: Vec<Decimal>) -> Vec<Tick> {
    let magnitude = numbers.iter().filter_map(|number| number.magnitude()).max().unwrap_or(0);
    let label = |number| match magnitude {
        -3..=4 => Label::plain(number),
        _ => Label::scaled(number, magnitude),
    };
    numbers.into_iter().map(|number| Tick { number, label: label(number) }).collect()
}
