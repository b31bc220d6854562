//! Messages of DDS in their encoding, and the quality of service with which they are read and written.

use rustdds::bytes::Bytes;
use rustdds::no_key::{Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter};
use rustdds::policy::{Durability, History, Reliability, ResourceLimits};
use rustdds::{QosPolicies, QosPolicyBuilder, RepresentationIdentifier};

/// The most samples of a topic that rustdds keeps: of any size, and of a topic whose samples are known to be small.
pub(super) const KEPT: i32 = 16;
pub(super) const KEPT_SMALL: i32 = 1024;

/// The quality of service of a reader or writer.
pub(super) fn qos(is_reliable: bool, is_latched: bool, kept: i32) -> QosPolicies {
    let zero = rustdds::Duration::ZERO;
    let reliability =
        if is_reliable { Reliability::Reliable { max_blocking_time: zero } } else { Reliability::BestEffort };
    QosPolicyBuilder::new()
        .reliability(reliability)
        .durability(if is_latched { Durability::TransientLocal } else { Durability::Volatile })
        .history(History::KeepLast { depth: 1 })
        .resource_limits(ResourceLimits { max_samples: kept, max_instances: 1, max_samples_per_instance: kept })
        .build()
}

/// Reads and writes messages in their encoding.
pub(super) struct AsIs;

impl DeserializerAdapter<Vec<u8>> for AsIs {
    type Error = std::convert::Infallible;
    type Decoded = Vec<u8>;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        &[
            RepresentationIdentifier::CDR_LE,
            RepresentationIdentifier::CDR_BE,
            RepresentationIdentifier::XCDR2_LE,
            RepresentationIdentifier::XCDR2_BE,
            RepresentationIdentifier::D_CDR2_LE,
            RepresentationIdentifier::D_CDR2_BE,
        ]
    }

    fn transform_decoded(decoded: Vec<u8>) -> Vec<u8> {
        decoded
    }
}

impl DefaultDecoder<Vec<u8>> for AsIs {
    type Decoder = Whole;

    const DECODER: Whole = Whole;
}

impl SerializerAdapter<Vec<u8>> for AsIs {
    type Error = std::convert::Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(message: &Vec<u8>) -> Result<Bytes, Self::Error> {
        // rustdds writes the encapsulation header itself.
        Ok(Bytes::copy_from_slice(message.get(4..).unwrap_or_default()))
    }
}

/// Restores the encapsulation header of a message.
#[derive(Clone)]
pub(super) struct Whole;

impl Decode<'_, Vec<u8>> for Whole {
    type Error = std::convert::Infallible;

    fn decode_bytes(self, bytes: &[u8], encoding: RepresentationIdentifier) -> Result<Vec<u8>, Self::Error> {
        let mut message = Vec::with_capacity(bytes.len() + 4);
        message.extend_from_slice(&encoding.to_bytes());
        message.extend_from_slice(&[0, 0]);
        message.extend_from_slice(bytes);
        Ok(message)
    }
}
