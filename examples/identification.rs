//! How often the class of a pattern is found: five unseen patterns of every class, harmed in
//! fourteen ways, and pictures that no model made.
//!
//! cargo run --release --example identification -- [SEED] [PATTERNS]
#![allow(clippy::print_stdout, reason = "a table for people")]

use patterns::disocclusion::{
    Database, Identifier, built_in,
    degrade::HARMS,
    evaluate::{Case, cases},
    foreign, normalize,
};
use patterns::{NoInputs, Result};

fn main() -> Result<()> {
    let number = |n: usize, default: u64| {
        std::env::args().nth(n).and_then(|text| text.parse().ok()).unwrap_or(default)
    };
    let (seed, patterns) = (number(1, 4), number(2, 5));
    let identifier = Identifier::new(Database::built_in()?, &built_in()?)?;
    let classes = &identifier.database().classes;
    let mut all: Vec<Case> = Vec::new();
    for class in 0..classes.len() {
        let mut own = Vec::new();
        for index in 0..patterns {
            own.extend(cases(&identifier, class, seed, index)?);
        }
        println!("{:28} {}", classes[class].name, rates(own.iter()));
        all.extend(own);
    }
    for share in [0.25, 0.5] {
        for harm in HARMS {
            let of = all.iter().filter(|c| c.harm == harm && c.share == share);
            println!("{harm:?} {share}: {}", rates(of));
        }
        println!("all {share}: {}", rates(all.iter().filter(|c| c.share == share)));
    }
    let mut errors: Vec<f64> = all.iter().flat_map(|c| c.errors.clone()).collect();
    errors.sort_by(f64::total_cmp);
    if !errors.is_empty() {
        println!("median relative error of a parameter: {:.4}", errors[errors.len() / 2]);
    }
    let mut taken = 0;
    for (index, name) in foreign::NAMES.iter().enumerate() {
        let picture = foreign::picture(index, 128, seed)?;
        let normal = normalize(&picture, &vec![true; 128 * 128])?;
        let answer = identifier.identify(&normal, &NoInputs)?;
        if !answer.none {
            taken += 1;
            println!("{name} is taken for {}", classes[answer.ranking[0].class].name);
        }
    }
    println!("told as none: {} of {}", foreign::NAMES.len() - taken, foreign::NAMES.len());
    Ok(())
}

/// Share of the right class, of a false "none", and of both right.
fn rates<'a>(cases: impl Iterator<Item = &'a Case>) -> String {
    let (mut count, mut right, mut none, mut both) = (0.0, 0.0, 0.0, 0.0);
    for case in cases {
        let found = case.right;
        count += 1.0;
        right += f64::from(u8::from(found));
        none += f64::from(u8::from(case.none));
        both += f64::from(u8::from(found && !case.none));
    }
    let share = |n: f64| n / f64::max(count, 1.0);
    format!(
        "{count} pictures, class {:.3}, none {:.3}, both right {:.3}",
        share(right),
        share(none),
        share(both)
    )
}
