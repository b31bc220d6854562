//! Requests and replies: the first part of each has a fixed size, and integers are little-endian.

/// The port on which programs answer, unless they are told otherwise.
pub const PORT: u16 = 1667;

/// The version of the protocol: the same since BehaviorTree.CPP 4.4.
const VERSION: u8 = 2;

/// What tells one tree from another: a program makes it at random when it begins to show a tree.
pub type TreeId = [u8; 16];

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RequestKind {
    /// The tree, as XML.
    FullTree,
    /// The status of all nodes.
    Status,
    /// The entries of the blackboards that the second part names.
    Blackboard,
    /// To begin or end to remember transitions, as the second part says.
    Recording,
    /// The transitions since they were asked for the last time.
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
    /// Asks for something; the reply has the same `id`.
    #[must_use]
    pub fn new(kind: RequestKind, id: u32) -> Self {
        Self { code: kind.code(), id }
    }

    /// Reads one; none if these are not the bytes of one.
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let [VERSION, code, id @ ..] = bytes else { return None };
        Some(Self { code: *code, id: u32::from_le_bytes(id.try_into().ok()?) })
    }

    /// What is asked for; none if it is anything else than to look at the tree.
    #[must_use]
    pub fn kind(&self) -> Option<RequestKind> {
        RequestKind::ALL.into_iter().find(|kind| kind.code() == self.code)
    }

    /// The bytes of it.
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

/// The tree that the reply to a request is about; none if it is no reply to it.
pub(crate) fn tree_of_reply(request: RequestHeader, header: &[u8]) -> Option<TreeId> {
    header.strip_prefix(&request.bytes())?.try_into().ok()
}
