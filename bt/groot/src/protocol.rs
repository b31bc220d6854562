//! Requests and replies: the first part of each has a fixed size, and integers are little-endian.

/// The default port of programs.
pub const PORT: u16 = 1667;

/// The version of the protocol: the same since BehaviorTree.CPP 4.4.
const VERSION: u8 = 2;

/// The identifier of a tree, which a program draws at random when it begins to show a tree.
pub type TreeId = [u8; 16];

/// In the number of a status: the node is idle, and the rest is the number of its status before.
pub(crate) const IDLE_AFTER: u8 = 10;

/// The kind of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RequestKind {
    /// The tree, as XML.
    FullTree,
    /// The status of all nodes.
    Status,
    /// The entries of the blackboards that are named in the second part.
    Blackboard,
    /// Starts or stops the recording of transitions, according to the second part.
    Recording,
    /// The transitions since the last request of this kind.
    Transitions,
}

impl RequestKind {
    const ALL: [Self; 5] = [Self::FullTree, Self::Status, Self::Blackboard, Self::Recording, Self::Transitions];

    fn code(self) -> u8 {
        match self {
            Self::FullTree => b'T',
            Self::Status => b'S',
            Self::Blackboard => b'B',
            Self::Recording => b'r',
            Self::Transitions => b't',
        }
    }
}

/// The first part of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequestHeader {
    code: u8,
    id: u32,
}

impl RequestHeader {
    /// The header of a request of this kind. The reply has the same `id`.
    #[must_use]
    pub fn new(kind: RequestKind, id: u32) -> Self {
        Self { code: kind.code(), id }
    }

    /// Reads a header; none if the bytes are not a header of this version.
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let [VERSION, code, id @ ..] = bytes else { return None };
        Some(Self { code: *code, id: u32::from_le_bytes(id.try_into().ok()?) })
    }

    /// The kind of the request; none if the request does more than read the tree.
    #[must_use]
    pub fn kind(&self) -> Option<RequestKind> {
        RequestKind::ALL.into_iter().find(|kind| kind.code() == self.code)
    }

    /// Its bytes.
    #[must_use]
    pub fn bytes(&self) -> [u8; 6] {
        let [a, b, c, d] = self.id.to_le_bytes();
        [VERSION, self.code, a, b, c, d]
    }
}

/// The first part of the reply to a request.
#[must_use]
pub fn reply_header(request: RequestHeader, tree: TreeId) -> Vec<u8> {
    [&request.bytes()[..], &tree].concat()
}

/// The tree of the reply to a request; none if the header does not belong to such a reply.
pub(crate) fn tree_of_reply(request: RequestHeader, header: &[u8]) -> Option<TreeId> {
    header.strip_prefix(&request.bytes())?.try_into().ok()
}
