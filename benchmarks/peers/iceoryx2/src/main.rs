//! iceoryx2, request/response. HOW: poll (asks again and again) or wait (sleeps on its events, one service of
//! them for each direction); or publish/subscribe: topics, polled, there and back; images-poll, images-wait. The address
//! is the name of the service.

mod images;
mod speaker;
mod topics;

use iceoryx2::port::{client::Client as Requests, listener::{Listener, ListenerWaitError}, notifier::Notifier};
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::prelude::*;
use speaker::Failure;
use std::collections::VecDeque;
use std::time::Duration;

/// The same 64 bytes as everywhere; iceoryx2_client.py uses this type by its name.
#[repr(C)]
#[derive(Debug, Clone, Copy, ZeroCopySend)]
#[type_name("Sample")]
struct Sample {
    stamp: f64,
    axis: [f64; 7],
}

type Pending = PendingResponse<ipc::Service, Sample, (), Sample, ()>;

/// Ours to end on: a look for SIGTERM once in a while, so that what is shared is taken down in order.
fn asked_to_end(node: &Node<ipc::Service>) -> bool {
    node.wait(Duration::ZERO).is_err()
}

/// How one side learns that the other has sent something, when it does not poll.
struct Events {
    mine: Listener<ipc::Service>,
    theirs: Notifier<ipc::Service>,
}

impl Events {
    fn open(node: &Node<ipc::Service>, how: &str, mine: String, theirs: String) -> Result<Option<Self>, Failure> {
        match how {
            "poll" => Ok(None),
            "wait" => {
                let mine = node.service_builder(&mine.as_str().try_into()?).event().open_or_create()?;
                let theirs = node.service_builder(&theirs.as_str().try_into()?).event().open_or_create()?;
                Ok(Some(Events { mine: mine.listener_builder().create()?, theirs: theirs.notifier_builder().create()? }))
            }
            _ => Err(format!("{how:?} is neither poll nor wait").into()),
        }
    }
}

fn wait(events: &Option<Events>) -> Result<(), Failure> {
    if let Some(events) = events {
        match events.mine.timed_wait(|_| {}, Duration::from_millis(100)) {
            Ok(_) | Err(ListenerWaitError::InterruptSignal) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}

fn notify(events: &Option<Events>) -> Result<(), Failure> {
    if let Some(events) = events {
        events.theirs.notify()?;
    }
    Ok(())
}

fn serve(how: &str) -> Result<(), Failure> {
    let node = NodeBuilder::new().create::<ipc::Service>()?;
    let name = format!("bench-peers/{}", std::process::id());
    let service = node
        .service_builder(&name.as_str().try_into()?)
        .request_response::<Sample, Sample>()
        .max_active_requests_per_client(64)
        .max_loaned_requests(64)
        .create()?;
    let server = service.server_builder().create()?;
    let events = Events::open(&node, how, format!("{name}/asked"), format!("{name}/answered"))?;
    speaker::say_ready(&name);
    while !asked_to_end(&node) {
        let looks = if events.is_some() { 1 } else { 10_000 };
        for _ in 0..looks {
            while let Some(request) = server.receive()? {
                request.loan_uninit()?.write_payload(*request).send()?;
                notify(&events)?;
            }
            wait(&events)?;
        }
    }
    Ok(())
}

struct Client {
    requests: Requests<ipc::Service, Sample, (), Sample, ()>,
    events: Option<Events>,
    pending: VecDeque<Pending>,
}

impl speaker::Client for Client {
    fn call(&mut self, stamp: f64) -> Result<f64, Failure> {
        self.issue(stamp)?;
        self.collect()
    }
    fn issue(&mut self, stamp: f64) -> Result<(), Failure> {
        let request = self.requests.loan_uninit()?;
        self.pending.push_back(request.write_payload(Sample { stamp, axis: [0.0; 7] }).send()?);
        notify(&self.events)
    }
    fn collect(&mut self) -> Result<f64, Failure> {
        let pending = self.pending.pop_front().ok_or("nothing is outstanding")?;
        loop {
            if let Some(response) = pending.receive()? {
                return Ok(response.stamp);
            }
            wait(&self.events)?;
        }
    }
}

fn call(how: &str, name: &str) -> Result<(), Failure> {
    let node = NodeBuilder::new().create::<ipc::Service>()?;
    let service = node
        .service_builder(&name.try_into()?)
        .request_response::<Sample, Sample>()
        .max_active_requests_per_client(64)
        .open()?;
    let events = Events::open(&node, how, format!("{name}/answered"), format!("{name}/asked"))?;
    let requests = service.client_builder().create()?;
    speaker::answer_lines(&mut Client { requests, events, pending: VecDeque::new() })
}

fn main() -> Result<(), Failure> {
    set_log_level(LogLevel::Error);
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["serve", "topics"] => topics::serve(),
        ["call", "topics", name] => topics::call(name),
        ["serve", how] => match how.strip_prefix("images-") {
            Some(how) => images::serve(how),
            None => serve(how),
        },
        ["call", how, name] => match how.strip_prefix("images-") {
            Some(how) => images::call(how, name),
            None => call(how, name),
        },
        _ => Err("usage: serve HOW | call HOW ADDRESS".into()),
    }
}
