//! Publish/subscribe there and back, by polling: one service for each direction.

use crate::speaker::{self, Failure};
use crate::{asked_to_end, Sample};
use iceoryx2::port::{publisher::Publisher, subscriber::Subscriber};
use iceoryx2::prelude::*;

struct Topics {
    out: Publisher<ipc::Service, Sample, ()>,
    back: Subscriber<ipc::Service, Sample, ()>,
}

impl Topics {
    fn open(node: &Node<ipc::Service>, out: String, back: String) -> Result<Self, Failure> {
        let topic = |name: String| -> Result<_, Failure> {
            Ok(node.service_builder(&name.as_str().try_into()?).publish_subscribe::<Sample>().open_or_create()?)
        };
        Ok(Topics { out: topic(out)?.publisher_builder().create()?, back: topic(back)?.subscriber_builder().create()? })
    }
    fn send(&self, sample: Sample) -> Result<(), Failure> {
        self.out.loan_uninit()?.write_payload(sample).send()?;
        Ok(())
    }
}

pub fn serve() -> Result<(), Failure> {
    let node = NodeBuilder::new().create::<ipc::Service>()?;
    let name = format!("bench-peers/{}", std::process::id());
    let topics = Topics::open(&node, format!("{name}/back"), format!("{name}/there"))?;
    speaker::say_ready(&name);
    while !asked_to_end(&node) {
        for _ in 0..10_000 {
            while let Some(sample) = topics.back.receive()? {
                topics.send(*sample)?;
            }
        }
    }
    Ok(())
}

impl speaker::Client for Topics {
    fn call(&mut self, stamp: f64) -> Result<f64, Failure> {
        self.issue(stamp)?;
        self.collect()
    }
    fn issue(&mut self, stamp: f64) -> Result<(), Failure> {
        self.send(Sample { stamp, axis: [0.0; 7] })
    }
    fn collect(&mut self) -> Result<f64, Failure> {
        loop {
            if let Some(sample) = self.back.receive()? {
                return Ok(sample.stamp);
            }
        }
    }
}

pub fn call(name: &str) -> Result<(), Failure> {
    let node = NodeBuilder::new().create::<ipc::Service>()?;
    speaker::answer_lines(&mut Topics::open(&node, format!("{name}/there"), format!("{name}/back"))?)
}
