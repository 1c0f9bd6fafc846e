//! Images by publish/subscribe; ../../images.hpp is the same in C++ and says what is measured.

use crate::speaker::{self, Failure};
use crate::Events;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;

const PIXELS: usize = 1920 * 1080 * 3;
const PACE_NS: i64 = 5_000_000;

/// The first octets of an image.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, ZeroCopySend)]
struct Stamps {
    number: u64,
    begun: i64,
    sent: i64,
    sending: i64,
}

const STAMPS: usize = std::mem::size_of::<Stamps>();

#[repr(C)]
#[derive(Debug, ZeroCopySend)]
#[type_name("Image")]
pub struct Image {
    stamps: Stamps,
    octets: [u8; PIXELS - STAMPS],
}

/// CLOCK_MONOTONIC, which both ends share. `Instant` does not tell its number.
fn now() -> i64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `time` is there to be written.
    unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &mut time) };
    time.tv_sec * 1_000_000_000 + time.tv_nsec
}

fn sleep_until(due: i64) {
    let time = libc::timespec { tv_sec: due / 1_000_000_000, tv_nsec: due % 1_000_000_000 };
    // SAFETY: `time` is there to be read; nothing is written.
    unsafe { libc::clock_nanosleep(libc::CLOCK_MONOTONIC, libc::TIMER_ABSTIME, &time, std::ptr::null_mut()) };
}

pub fn serve(how: &str) -> Result<(), Failure> {
    let node = NodeBuilder::new().create::<ipc::Service>()?;
    let name = format!("bench-peers/{}", std::process::id());
    let service = node
        .service_builder(&name.as_str().try_into()?)
        .publish_subscribe::<Image>()
        .history_size(1) // the newest image stays for late readers, as in our stream
        .subscriber_max_buffer_size(1)
        .create()?;
    let publisher = service.publisher_builder().create()?;
    let events = Events::open(&node, how, format!("{name}/read"), format!("{name}/sent"))?;
    speaker::say_ready(&name);
    let mut due = now();
    let mut stamps = Stamps::default();
    while !crate::asked_to_end(&node) {
        due = now().max(due + PACE_NS);
        sleep_until(due);
        stamps.begun = now();
        stamps.number += 1;
        let mut sample = publisher.loan_uninit()?;
        let image = sample.payload_mut().as_mut_ptr();
        // SAFETY: `image` is lent memory of that size. Every octet of it is written.
        let sample = unsafe {
            std::ptr::write_bytes(std::ptr::addr_of_mut!((*image).octets).cast::<u8>(), stamps.number as u8, PIXELS - STAMPS);
            stamps.sent = now();
            (*image).stamps = stamps;
            sample.assume_init()
        };
        let before = now();
        sample.send()?;
        crate::notify(&events)?;
        stamps.sending = now() - before;
    }
    Ok(())
}

pub struct Reader {
    images: Subscriber<ipc::Service, Image, ()>,
    events: Option<Events>,
}

impl Reader {
    fn next(&self) -> Result<Sample<ipc::Service, Image, ()>, Failure> {
        loop {
            if let Some(image) = self.images.receive()? {
                return Ok(image);
            }
            crate::wait(&self.events)?;
        }
    }

    fn images(&self, seconds: f64) -> Result<String, Failure> {
        let (mut readable, mut whole, mut sending) = (Vec::new(), Vec::new(), Vec::new());
        let mut number = 0;
        let asked = now();
        let end = asked + (seconds * 1e9) as i64;
        while readable.is_empty() || now() < end {
            let image = self.next()?;
            let arrived = now();
            let stamps = image.stamps;
            read(&image)?;
            let read = now();
            if stamps.number <= number {
                return Err("an image came twice".into());
            }
            number = stamps.number;
            if stamps.begun < asked {
                continue; // it may have waited here for the question
            }
            readable.push((arrived - stamps.sent) as f64);
            whole.push((read - stamps.begun) as f64);
            if stamps.sending != 0 {
                sending.push(stamps.sending as f64);
            }
        }
        if sending.is_empty() {
            sending.push(0.0);
        }
        let clock = speaker::of_the_clock();
        let figure = |times: &mut [f64], part| speaker::quantile(times, part) - clock;
        Ok(format!(
            "{} {:.1} {:.1} {:.1} {:.1} {:.1}",
            readable.len(),
            figure(&mut readable, 0.5),
            figure(&mut readable, 0.99),
            figure(&mut whole, 0.5),
            figure(&mut whole, 0.99),
            figure(&mut sending, 0.5)
        ))
    }
}

/// Reads every octet: each equals the one before. Slices are compared by memcmp, as in C++.
fn read(image: &Image) -> Result<(), Failure> {
    let octets = &image.octets;
    if octets[0] != image.stamps.number as u8 || octets[..octets.len() - 1] != octets[1..] {
        return Err("the octets are not those of one image".into());
    }
    Ok(())
}

pub fn call(how: &str, name: &str) -> Result<(), Failure> {
    let node = NodeBuilder::new().create::<ipc::Service>()?;
    let service = node
        .service_builder(&name.try_into()?)
        .publish_subscribe::<Image>()
        .subscriber_max_buffer_size(1)
        .open()?;
    let events = Events::open(&node, how, format!("{name}/sent"), format!("{name}/read"))?;
    let reader = Reader { images: service.subscriber_builder().create()?, events };
    speaker::say_ready("");
    speaker::answer_each(|words| match words {
        ["images", seconds] => Ok(Some(reader.images(seconds.parse()?)?)),
        _ => Ok(None),
    })
}
