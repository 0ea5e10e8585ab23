//! What was found, in words and for `run.json`.

use super::Report;
use patterns::disocclusion::{Occluder, Values};
use serde_json::{Value, json};

/// Classes that are named besides the one that was found.
const RUNNERS_UP: usize = 3;

/// The stages' results, a line each.
pub(super) fn notes(report: &Report) -> Vec<String> {
    let mut notes = vec![hidden(report)];
    let ranking = &report.answer.ranking;
    let name = |n: usize| &report.identifier.class(&ranking[n]).name;
    let list: Vec<String> = (0..ranking.len().min(1 + RUNNERS_UP))
        .map(|n| format!("{} {:.3}", name(n), ranking[n].confidence))
        .collect();
    if report.answer.none {
        notes.push(format!("model: none of these; nearest {}", list.join(", ")));
    } else {
        notes.push(format!("model: {}; then {}", list[0], list[1..].join(", ")));
    }
    if let Some(search) = &report.refined {
        notes.push(format!(
            "parameters ({} generations, {} candidates): {}",
            search.generations,
            search.tried,
            parameters(report).iter().map(Parameter::text).collect::<Vec<_>>().join(", ")
        ));
    }
    notes.push(format!("filled by: {}", report.filled.method));
    notes
}

fn hidden(report: &Report) -> String {
    let source = &report.source;
    let share = 100.0 * source.hidden();
    let how = match &source.detected {
        None => "as the mask tells".into(),
        Some(found) => found
            .iter()
            .map(|(kind, count)| format!("{} ({count} pixels)", occluder(*kind)))
            .collect::<Vec<_>>()
            .join(" and "),
    };
    let seen = if source.detected.is_some() { "found by itself: " } else { "" };
    format!("hidden: {share:.1} % of the picture, {seen}{how}; see mask.png")
}

fn occluder(kind: Occluder) -> &'static str {
    match kind {
        Occluder::Flat => "flat regions",
        Occluder::Dots => "random dots",
        Occluder::Noise => "single pixels of noise",
    }
}

/// A parameter of the class that was found.
pub(super) struct Parameter {
    key: String,
    value: Value,
    deviation: Option<f64>,
    range: Option<[f64; 2]>,
}

impl Parameter {
    fn text(&self) -> String {
        match self.deviation {
            Some(deviation) => {
                let value = self.value.as_f64().unwrap_or(f64::NAN);
                // Two digits of the deviation.
                let digits = (1.0 - deviation.max(1e-12).log10().floor()).clamp(0.0, 9.0) as usize;
                format!("{} = {value:.digits$} +- {deviation:.digits$}", self.key)
            }
            None => format!("{} = {}", self.key, self.value),
        }
    }

    fn json(&self) -> Value {
        json!({ "key": self.key, "value": self.value, "deviation": self.deviation, "range": self.range })
    }
}

/// Values and standard deviations of the parameters.
pub(super) fn parameters(report: &Report) -> Vec<Parameter> {
    let Some((first, refined)) = report.answer.ranking.first().zip(report.refined.as_ref()) else {
        return Vec::new();
    };
    let class = report.identifier.class(first);
    let shares = refined.found.point.iter().zip(&refined.found.deviations);
    let entry = |(range, (&share, &deviation)): (&patterns::disocclusion::Range, (&f64, &f64))| {
        let value = range.values.at(share);
        let (deviation, ends) = match &range.values {
            Values::Between { low, high, log, .. } => {
                // A share is a part of the logarithm's range.
                let width = if *log {
                    value.as_float().unwrap_or(*low) * (high / low).ln()
                } else {
                    high - low
                };
                (Some(deviation * width), Some([*low, *high]))
            }
            Values::Choices(_) => (None, None),
        };
        let value = serde_json::to_value(&value).unwrap_or(Value::Null);
        Parameter { key: range.key.clone(), value, deviation, range: ends }
    };
    class.ranges.iter().zip(shares).map(entry).collect()
}

/// For `run.json`.
pub(super) fn json(report: &Report) -> Value {
    let ranking = &report.answer.ranking;
    let candidates: Vec<Value> = (0..ranking.len())
        .map(|n| {
            let (found, class) = (&ranking[n], report.identifier.class(&ranking[n]));
            let score = report.candidates.get(n);
            json!({
                "class": class.name,
                "model": class.model.name,
                "confidence": found.confidence,
                "distance": found.distance,
                "inverted": found.inverted,
                "sum_of_products": score.map(|s| s.sum_of_products),
                "correlation": score.map(|s| s.correlation),
                "mean_squared_error": score.map(|s| s.mean_squared_error),
            })
        })
        .collect();
    let first = ranking.first().filter(|_| !report.answer.none);
    json!({
        "none": report.answer.none,
        "class": first.map(|f| &report.identifier.class(f).name),
        "model": first.map(|f| report.identifier.class(f).model.name),
        "confidence": ranking.first().map(|f| f.confidence),
        "parameters": parameters(report).iter().map(Parameter::json).collect::<Vec<_>>(),
        "wavelength": report.answer.wavelength,
        "inverted": first.map(|f| f.inverted),
        "angle": first.and_then(|f| f.angle),
        "filled_by": report.filled.method,
        "hidden": hidden(report),
        "candidates": candidates,
    })
}

/// The candidates as CSV.
pub(super) fn csv(report: &Report) -> String {
    let mut text =
        "rank,class,model,confidence,distance,sum_of_products,correlation,mean_squared_error,parameters\n"
            .to_owned();
    for (n, found) in report.answer.ranking.iter().enumerate() {
        let class = report.identifier.class(found);
        let scores = report.candidates.get(n).map_or_else(
            || ",,".into(),
            |s| format!("{},{},{}", s.sum_of_products, s.correlation, s.mean_squared_error),
        );
        let values: Vec<String> = class
            .ranges
            .iter()
            .zip(class.values(&found.point))
            .map(|(range, value)| format!("{}={value}", range.key))
            .collect();
        text += &format!(
            "{},{},{},{},{},{scores},{}\n",
            n + 1,
            class.name,
            class.model.name,
            found.confidence,
            found.distance,
            values.join(" ")
        );
    }
    text
}
