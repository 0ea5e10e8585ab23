//! Labelled folders of hidden pictures: made by a seed, and identified as a table.

use super::{Options, sources::harm_name};
use crate::{database, folder::Folder, input};
use anyhow::{Context as _, Result, bail, ensure};
use image::{GrayImage, ImageFormat};
use indicatif::{ProgressBar, ProgressStyle};
use patterns::{
    NoInputs,
    disocclusion::{
        Class, Identifier,
        degrade::{HARMS, Harmed, harm},
        foreign, normalize, simulate,
    },
};
use rayon::prelude::*;
use solvers::Field;
use std::{fs, io::Cursor, path::Path};

/// Parts that are hidden.
const SHARES: [f64; 2] = [0.25, 0.5];

/// Pixels to an element of classes without chance.
const MAGNIFIED: usize = 3;

/// Width of the pictures that no class made.
const FOREIGN: usize = 128;

/// The first line of `labels.csv`.
const HEAD: &str = "picture,mask,truth,class,harm,share,parameters";

/// The class of pictures that no class made.
const NONE: &str = "none";

/// What goes into a folder of cases.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Classes by name; empty: all.
    pub classes: Vec<String>,
    /// Patterns of each class.
    pub patterns: u64,
    /// Seed of the parameters, patterns and harms; the calibration's is 1.
    pub seed: u64,
}

/// Makes pictures of every class, hides a quarter and a half of each in seven ways, and adds
/// twenty pictures that no class made; `labels.csv` has the truth. Returns how many there are.
///
/// # Errors
/// If a class is unknown, a model fails, or the folder cannot be written to.
pub fn make(plan: &Plan, database: Option<&Path>, out: &Path, force: bool) -> Result<usize> {
    let (classes, _) = database::load(database)?;
    let chosen: Vec<&Class> = match plan.classes.as_slice() {
        [] => classes.classes.iter().collect(),
        names => {
            let find = |name: &String| {
                classes.find(name).with_context(|| {
                    format!("no class `{name}`; `patterns database list` has them")
                })
            };
            names.iter().map(find).collect::<Result<_>>()?
        }
    };
    let mut folder = Folder::create(Some(out), "evaluation", force)?;
    match fill(plan, &chosen, &mut folder) {
        Ok(count) => Ok(count),
        Err(error) => {
            folder.discard();
            Err(error)
        }
    }
}

fn fill(plan: &Plan, classes: &[&Class], folder: &mut Folder) -> Result<usize> {
    let jobs: Vec<(&Class, u64)> =
        classes.iter().flat_map(|c| (0..plan.patterns).map(|index| (*c, index))).collect();
    let bar = progress(jobs.len());
    let made: Vec<Vec<Case>> = jobs
        .par_iter()
        .with_max_len(1)
        .map(|&(class, index)| {
            let made = cases(class, plan.seed, index);
            bar.inc(1);
            made
        })
        .collect::<Result<_>>()?;
    bar.finish_and_clear();
    let mut labels = format!("{HEAD}\n");
    let mut count = 0;
    for case in made.iter().flatten() {
        let Case { name, label, harmed } = case;
        let files =
            [format!("{name}.png"), format!("{name}-mask.png"), format!("{name}-truth.png")];
        let hidden: Vec<f64> =
            harmed.visible.iter().map(|&seen| if seen { 0.0 } else { 1.0 }).collect();
        let truth: Vec<f64> = harmed.truth.iter().map(|&ink| if ink { 0.0 } else { 1.0 }).collect();
        let shape = harmed.picture.grid().axes().to_vec();
        folder.write(&files[0], &png(harmed.picture.as_slice(), &shape)?)?;
        folder.write(&files[1], &png(&hidden, &shape)?)?;
        folder.write(&files[2], &png(&truth, &shape)?)?;
        labels += &format!("{},{label}\n", files.join(","));
        count += 1;
    }
    for (index, title) in foreign::NAMES.iter().enumerate() {
        let picture = foreign::picture(index, FOREIGN, plan.seed)?;
        let file = format!("none-{}.png", title.replace(' ', "-"));
        folder.write(&file, &png(picture.as_slice(), picture.grid().axes())?)?;
        labels += &format!("{file},,,{NONE},,0,\n");
        count += 1;
    }
    folder.write("labels.csv", labels.as_bytes())?;
    Ok(count)
}

struct Case {
    name: String,
    label: String,
    harmed: Harmed,
}

/// A pattern of a class, harmed in every way.
fn cases(class: &Class, seed: u64, index: u64) -> Result<Vec<Case>> {
    let point = class.point(seed, index);
    let mut pattern = simulate(class, &point, seed * 1000 + index, &NoInputs)
        .with_context(|| format!("class `{}`, pattern {index}", class.name))?;
    if !class.free_seeds {
        pattern = pattern.magnify(MAGNIFIED);
    }
    let values: Vec<String> = class
        .ranges
        .iter()
        .zip(class.values(&point))
        .map(|(range, value)| format!("{}={value}", range.key))
        .collect();
    let ways = HARMS.iter().flat_map(|&kind| SHARES.map(|share| (kind, share)));
    ways.map(|(kind, share)| {
        let way = harm_name(kind);
        let percent = 100.0 * share;
        Ok(Case {
            name: format!("{}-{index}-{way}-{percent}", class.name),
            label: format!("{},{way},{share},{}", class.name, values.join(" ")),
            harmed: harm(&pattern, kind, share, seed * 1000 + index)?,
        })
    })
    .collect()
}

fn png(values: &[f64], shape: &[usize]) -> Result<Vec<u8>> {
    let grey = values.iter().map(|v| (255.0 * v.clamp(0.0, 1.0)).round() as u8).collect();
    let picture = GrayImage::from_raw(shape[1] as u32, shape[0] as u32, grey)
        .with_context(|| format!("{} values for {shape:?} pixels", values.len()))?;
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

/// A line of `labels.csv`.
#[derive(Clone, Debug, PartialEq)]
struct Label {
    picture: String,
    mask: Option<String>,
    class: String,
    harm: String,
    share: f64,
    parameters: Vec<(String, f64)>,
}

fn labels(text: &str) -> Result<Vec<Label>> {
    let mut lines = text.lines();
    let head = lines.next().unwrap_or("");
    ensure!(head == HEAD, "line 1 is `{head}`, wanted is `{HEAD}`");
    let parse = |(n, line): (usize, &str)| -> Result<Label> {
        let parts: Vec<&str> = line.split(',').collect();
        let [picture, mask, _, class, harm, share, parameters] = parts[..] else {
            bail!("line {}: {} columns, 7 are wanted", n + 2, parts.len());
        };
        let number = |text: &str| text.parse::<f64>().ok();
        let share = number(share).with_context(|| format!("line {}: share `{share}`", n + 2))?;
        let parameters = parameters.split_whitespace().filter_map(|pair| {
            let (key, value) = pair.split_once('=')?;
            Some((key.to_owned(), number(value)?))
        });
        Ok(Label {
            picture: picture.into(),
            mask: (!mask.is_empty()).then(|| mask.into()),
            class: class.into(),
            harm: harm.into(),
            share,
            parameters: parameters.collect(),
        })
    };
    lines.enumerate().filter(|(_, line)| !line.is_empty()).map(parse).collect()
}

/// What was found for a [`Label`].
#[derive(Clone, Debug, Default)]
struct Row {
    found: String,
    /// Whether the class or one of its family was found.
    right: bool,
    none: bool,
    confidence: f64,
    /// Relative error of each parameter of the right class.
    errors: Vec<f64>,
}

/// Identifies every picture of a labelled folder, writes `evaluation.csv` to the output folder,
/// and returns a table of rates for people.
///
/// # Errors
/// If the folder has no `labels.csv`, or a file of it cannot be used.
pub fn run(cases: &Path, database: Option<&Path>, options: &Options) -> Result<String> {
    let path = cases.join("labels.csv");
    let text = fs::read_to_string(&path)
        .with_context(|| format!("--evaluate {}: cannot read labels.csv", cases.display()))?;
    let labels = labels(&text).with_context(|| format!("`{}`", path.display()))?;
    ensure!(!labels.is_empty(), "`{}` lists no picture", path.display());
    let (classes, calibration) = database::load(database)?;
    let identifier = Identifier::new(classes, &calibration)?;
    for label in labels.iter().filter(|l| l.class != NONE) {
        ensure!(
            identifier.database().find(&label.class).is_some(),
            "`{}`: no class `{}` in the database",
            path.display(),
            label.class
        );
    }
    let mut folder = Folder::create(options.out.as_deref(), "evaluation", options.force)?;
    let result = identify_all(&identifier, &labels, cases, options.quiet)
        .map(|rows| (table(&labels, &rows), csv(&labels, &rows)))
        .and_then(|(table, csv)| {
            folder.write("evaluation.csv", csv.as_bytes())?;
            folder.write("evaluation.txt", table.as_bytes())?;
            Ok(table)
        });
    if result.is_err() {
        folder.discard();
    }
    result
}

fn identify_all(
    identifier: &Identifier,
    labels: &[Label],
    cases: &Path,
    quiet: bool,
) -> Result<Vec<Row>> {
    let bar = if quiet { ProgressBar::hidden() } else { progress(labels.len()) };
    let rows = labels
        .par_iter()
        .map(|label| {
            let row = identify(identifier, label, cases);
            bar.inc(1);
            row.with_context(|| format!("`{}`", label.picture))
        })
        .collect();
    bar.finish_and_clear();
    rows
}

/// A bar on standard error for `count` things of like effort, and only on a terminal.
pub(crate) fn progress(count: usize) -> ProgressBar {
    let bar = ProgressBar::new(count as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len}, {per_sec}, {eta} left") {
        bar.set_style(style);
    }
    bar
}

fn identify(identifier: &Identifier, label: &Label, folder: &Path) -> Result<Row> {
    let load = |name: &str| -> Result<Field> {
        Ok(Field::from_array(input::load_field(&folder.join(name))?, 1.0)?)
    };
    let picture = load(&label.picture)?;
    let visible: Vec<bool> = match &label.mask {
        Some(name) => load(name)?.as_slice().iter().map(|&v| v <= 0.5).collect(),
        None => vec![true; picture.as_slice().len()],
    };
    // A picture of one colour is of no class.
    if normalize(&picture, &visible).is_err() {
        return Ok(Row { none: true, right: label.class == NONE, ..Row::default() });
    }
    let answer = identifier.identify_at_scales(&picture, &visible, &NoInputs)?.answer;
    let Some(first) = answer.ranking.first() else {
        return Ok(Row { none: true, right: label.class == NONE, ..Row::default() });
    };
    let class = identifier.class(first);
    let family = identifier.database().find(&label.class).map(|c| &c.family);
    let mut row = Row {
        found: class.name.clone(),
        right: if label.class == NONE { answer.none } else { family == Some(&class.family) },
        none: answer.none,
        confidence: first.confidence,
        errors: Vec::new(),
    };
    if class.name == label.class {
        for (range, value) in class.ranges.iter().zip(class.values(&first.point)) {
            let found = value.as_float().or(value.as_integer().map(|v| v as f64));
            let truth = label.parameters.iter().find(|(key, _)| *key == range.key);
            if let (Some(found), Some((_, truth))) = (found, truth) {
                row.errors.push(((found - truth) / truth).abs());
            }
        }
    }
    Ok(row)
}

fn csv(labels: &[Label], rows: &[Row]) -> String {
    let mut text = "picture,class,harm,share,found,right,none,confidence,errors\n".to_owned();
    for (label, row) in labels.iter().zip(rows) {
        let errors: Vec<String> = row.errors.iter().map(|e| format!("{e:.5}")).collect();
        text += &format!(
            "{},{},{},{},{},{},{},{:.4},{}\n",
            label.picture,
            label.class,
            label.harm,
            label.share,
            row.found,
            row.right,
            row.none,
            row.confidence,
            errors.join(" ")
        );
    }
    text
}

/// Rates by share and harm, by class, of the parameters and of pictures of no class.
fn table(labels: &[Label], rows: &[Row]) -> String {
    let pairs: Vec<(&Label, &Row)> = labels.iter().zip(rows).collect();
    let line = |title: &str, wanted: &dyn Fn(&Label) -> bool| {
        let of: Vec<_> = pairs.iter().filter(|(l, _)| l.class != NONE && wanted(l)).collect();
        if of.is_empty() {
            return String::new();
        }
        let share = |good: &dyn Fn(&Row) -> bool| {
            of.iter().filter(|(_, row)| good(row)).count() as f64 / of.len() as f64
        };
        let (right, none) = (share(&|r| r.right), share(&|r| r.none));
        format!("{title:32} {:6} {right:8.3} {none:8.3}\n", of.len())
    };
    let mut text = format!("{:32} {:>6} {:>8} {:>8}\n", "cases", "count", "class", "none");
    for share in SHARES {
        for kind in HARMS.map(harm_name) {
            let wanted = |l: &Label| l.share == share && l.harm == kind;
            text += &line(&format!("{} % {kind}", 100.0 * share), &wanted);
        }
        text += &line(&format!("{} % hidden", 100.0 * share), &|l| l.share == share);
    }
    let mut classes: Vec<&str> = labels.iter().map(|l| l.class.as_str()).collect();
    classes.sort_unstable();
    classes.dedup();
    for class in classes {
        text += &line(class, &|l| l.class == class);
    }
    text += &line("all", &|_| true);
    let mut errors: Vec<f64> = rows.iter().flat_map(|r| r.errors.clone()).collect();
    errors.sort_by(f64::total_cmp);
    if let Some(median) = errors.get(errors.len() / 2) {
        text += &format!("median relative error of a parameter: {median:.4}\n");
    }
    let foreign: Vec<_> = pairs.iter().filter(|(l, _)| l.class == NONE).collect();
    if !foreign.is_empty() {
        let told = foreign.iter().filter(|(_, row)| row.none).count();
        text += &format!("pictures of no class told so: {told} of {}\n", foreign.len());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_read_and_their_faults_told_by_line() {
        let good = format!("{HEAD}\na.png,m.png,t.png,turing-spots,box,0.25,x=1.5 y.z=2\n");
        let read = labels(&good).unwrap();
        assert_eq!(read[0].parameters, [("x".into(), 1.5), ("y.z".into(), 2.0)]);
        assert_eq!((read[0].share, read[0].mask.as_deref()), (0.25, Some("m.png")));
        let short = labels(&format!("{HEAD}\na.png,m.png\n")).unwrap_err().to_string();
        assert!(short.contains("line 2: 2 columns"), "{short}");
        assert!(labels("picture\n").unwrap_err().to_string().contains("line 1"));
    }

    #[test]
    fn rates_count_families_and_none() {
        let head = format!("{HEAD}\na,,,c,box,0.25,\nb,,,c,box,0.25,\nn,,,none,,0,\n");
        let labels = labels(&head).unwrap();
        let row =
            |right, none, error: f64| Row { right, none, errors: vec![error], ..Row::default() };
        let rows = [row(true, false, 0.1), row(false, true, 0.3), row(true, true, 0.2)];
        let text = table(&labels, &rows);
        assert!(text.contains("25 % box"), "{text}");
        assert!(text.contains("2    0.500    0.500"), "{text}");
        assert!(text.contains("told so: 1 of 1") && text.contains("0.2000"), "{text}");
    }
}
