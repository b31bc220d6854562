//! ROS 2 bags, also while they are being written.

use std::path::Path;

use bags::{Bag, Following, Mapping, Received, Source, Survey, Through};
use campaigns::Error;
use replay::trajectory::trajectory;

use crate::growing::STILL_WRITTEN;
use crate::host::Host;
use crate::judge::{VerificationResult, name};
use crate::log_request::LogRequest;
use crate::mapped::{Mapped, await_topics, load_mapping};
use crate::wanted::Wanted;

/// Judges a bag, in constant memory.
pub(crate) fn verify(request: &LogRequest<'_>, wanted: Wanted<'_>) -> Result<VerificationResult, Error> {
    let LogRequest { path, robots, is_followed, .. } = *request;
    let Some(mapping) = request.mapping else {
        if !is_followed {
            open(path)?;
        }
        let message = format!("there is no mapping from the messages of {} to channels", path.display());
        let help =
            format!("add `--map-channels FILE`; `steward verify --list {}` proposes such a file", path.display());
        return Err(Error::refused(message, help));
    };
    let host = wanted.host;
    let (mapping, text) = load_mapping(mapping, robots)?;
    let mut damage: Vec<String> = Vec::new();
    let (survey, source, trajectory): (Survey, Box<dyn Source>, _) = if is_followed {
        let (survey, following) = follow(path, &mapping, host)?;
        (survey, Box::new(Through::new(following, receive_or_pause(host))), None)
    } else {
        let bag = open(path)?;
        let messages = bag.messages_on(mapping.topics());
        damage.extend(bag.damage().cloned());
        let is_shown = wanted.has_records() && robots.spaces.len() < 2;
        let trajectory = if is_shown { trajectory(&bag, mapping.robot()) } else { None };
        (bag.survey().clone(), Box::new(messages), trajectory)
    };
    let start = survey.span_ns.map_or_else(String::new, |(first, _)| format!(", since {}", bags::moment(first)));
    let mapped = Mapped {
        name: name(path),
        about: format!("A ROS 2 bag{start}"),
        mapping: &mapping,
        text,
        properties: request.properties,
        robots: robots.spaces,
        scenario: request.scenario,
        trajectory,
        is_robot: false,
    };
    let is_to_end = || is_followed && (host.is_interrupted)();
    // Damage may be the reason why the bag is refused.
    let result = mapped.judge(&survey, source, &is_to_end, wanted);
    let mut result = result.inspect_err(|_| damage.iter().for_each(|what| (host.note)(what)))?;
    result.notes.extend(is_to_end().then(|| STILL_WRITTEN.to_owned()));
    Ok(result)
}

/// Receives a message, or pauses if nothing more has been written.
fn receive_or_pause(host: Host) -> impl Fn(&mut Following, &mut Vec<u8>) -> Received {
    move |source, body| {
        let received = source.receive(body);
        if received == Received::Idle {
            host.pause();
        }
        received
    }
}

/// A recording that is still being written, from its beginning, and its survey. The survey contains every topic whose
/// type the channels depend on.
fn follow(path: &Path, mapping: &Mapping, host: Host) -> Result<(Survey, Following), Error> {
    let following = Following::open(path, mapping.topics()).map_err(refused)?;
    let mut ahead = Through::new(following, receive_or_pause(host));
    await_topics(&mut ahead, mapping, &host.is_interrupted, host.note);
    Ok((ahead.survey().clone(), ahead.source.restart().map_err(refused)?))
}

/// Opens a bag.
///
/// # Errors
/// If it cannot be read at all.
pub fn open(path: &Path) -> Result<Bag, Error> {
    Bag::open(path).map_err(refused)
}

fn refused(error: bags::Error) -> Error {
    Error::refused(error.to_string(), error.help())
}
