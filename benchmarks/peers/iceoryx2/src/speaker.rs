//! What every program of `make bench-peers` says; ../../speaker.hpp is the same in C++ and has the words.

use std::io::{BufRead, Write};
use std::time::{Duration, Instant};

pub type Failure = Box<dyn std::error::Error>;

/// A client that is connected.
pub trait Client {
    /// Sends a call with this stamp and waits for its answer's.
    fn call(&mut self, stamp: f64) -> Result<f64, Failure>;
    /// Sends one without waiting.
    fn issue(&mut self, stamp: f64) -> Result<(), Failure>;
    /// The stamp of the oldest answer that is not yet taken.
    fn collect(&mut self) -> Result<f64, Failure>;
}

pub fn say_ready(address: &str) {
    println!("ready {address}");
}

/// Answers every line of standard input with a line.
pub fn answer_lines(client: &mut dyn Client) -> Result<(), Failure> {
    say_ready("");
    let mut stamp = 0.0;
    answer_each(|words| {
        Ok(Some(match words {
            ["trips", seconds] => trips(client, &mut stamp, seconds.parse()?)?,
            ["silent", seconds, count] => silent(client, &mut stamp, seconds.parse()?, count.parse()?)?,
            ["outstanding", number, seconds] => {
                outstanding(client, &mut stamp, number.parse()?, seconds.parse()?)?
            }
            _ => return Ok(None),
        }))
    })
}

/// Answers by what `answer` says to the words of a line; nothing to words that it does not know.
pub fn answer_each(mut answer: impl FnMut(&[&str]) -> Result<Option<String>, Failure>) -> Result<(), Failure> {
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let Some(said) = answer(&words)? else {
            return Err(format!("asked for {line:?}; speaker.hpp says what can be asked").into());
        };
        println!("{said}");
        std::io::stdout().flush()?;
    }
    Ok(())
}

pub fn quantile(times: &mut [f64], part: f64) -> f64 {
    let at = ((times.len() - 1) as f64 * part) as usize;
    *times.select_nth_unstable_by(at, f64::total_cmp).1
}

fn in_ns(time: Duration) -> f64 {
    time.as_nanos() as f64
}

/// What is between two looks at the clock when nothing else is.
pub fn of_the_clock() -> f64 {
    let mut times = Vec::new();
    let mut before = Instant::now();
    while times.len() < 10_000 {
        let after = Instant::now();
        times.push(in_ns(after - before));
        before = after;
    }
    quantile(&mut times, 0.5)
}

fn sum_up(times: &mut [f64]) -> String {
    let clock = of_the_clock();
    let (p50, p99) = (quantile(times, 0.5) - clock, quantile(times, 0.99) - clock);
    format!("{} {p50:.1} {p99:.1}", times.len())
}

fn exchange(client: &mut dyn Client, stamp: &mut f64) -> Result<(), Failure> {
    *stamp += 1.0;
    check(client.call(*stamp)?, *stamp)
}

fn check(got: f64, wanted: f64) -> Result<(), Failure> {
    if got == wanted {
        return Ok(());
    }
    Err("the answer belongs to another call".into())
}

fn trips(client: &mut dyn Client, stamp: &mut f64, seconds: f64) -> Result<String, Failure> {
    let mut times = Vec::with_capacity(1 << 22);
    let mut before = Instant::now();
    let end = before + Duration::from_secs_f64(seconds);
    while before < end {
        exchange(client, stamp)?;
        let after = Instant::now();
        times.push(in_ns(after - before));
        before = after;
    }
    Ok(sum_up(&mut times))
}

fn silent(client: &mut dyn Client, stamp: &mut f64, seconds: f64, count: usize) -> Result<String, Failure> {
    let mut times = Vec::new();
    for _ in 0..count {
        std::thread::sleep(Duration::from_secs_f64(seconds));
        let before = Instant::now();
        exchange(client, stamp)?;
        times.push(in_ns(before.elapsed()));
    }
    Ok(sum_up(&mut times))
}

fn outstanding(client: &mut dyn Client, stamp: &mut f64, number: u32, seconds: f64) -> Result<String, Failure> {
    let begin = Instant::now();
    let first = *stamp;
    let mut answered = first;
    let mut issue = |client: &mut dyn Client| {
        *stamp += 1.0;
        client.issue(*stamp)
    };
    for _ in 0..number {
        issue(client)?;
    }
    while begin.elapsed().as_secs_f64() < seconds {
        answered += 1.0;
        check(client.collect()?, answered)?;
        issue(client)?;
    }
    for _ in 0..number {
        answered += 1.0;
        check(client.collect()?, answered)?;
    }
    Ok(format!("{:.1}", (answered - first) / begin.elapsed().as_secs_f64()))
}
