//! The words and operators of expressions.

use super::token::TokenKind;
use super::{BinaryOp, Expr, LogicOp, UnaryOp};
use crate::Datum;

/// Prefix operators bind more tightly than every infix operator.
pub(super) const UNARY_POWER: u8 = 13;

/// An operator between two expressions.
pub(super) enum Infix {
    Binary(BinaryOp),
    Logic(LogicOp),
    Choice,
}

/// Reserved words of ECMAScript.
const RESERVED: [&str; 80] = [
    "new",
    "function",
    "this",
    "delete",
    "class",
    "await",
    "yield",
    "async",
    "import",
    "super",
    "let",
    "var",
    "const",
    "if",
    "for",
    "while",
    "do",
    "return",
    "switch",
    "throw",
    "try",
    "catch",
    "break",
    "continue",
    "export",
    "enum",
    "extends",
    "static",
    "eval",
    "arguments",
    "globalThis",
    "Math",
    "JSON",
    "Date",
    "Object",
    "Array",
    "String",
    "Number",
    "Boolean",
    "Symbol",
    "BigInt",
    "Function",
    "RegExp",
    "Map",
    "Set",
    "WeakMap",
    "WeakSet",
    "WeakRef",
    "Promise",
    "Proxy",
    "Reflect",
    "Atomics",
    "DataView",
    "ArrayBuffer",
    "SharedArrayBuffer",
    "FinalizationRegistry",
    "Error",
    "EvalError",
    "RangeError",
    "ReferenceError",
    "SyntaxError",
    "TypeError",
    "URIError",
    "AggregateError",
    "Int8Array",
    "Uint8Array",
    "Int16Array",
    "Uint16Array",
    "Int32Array",
    "Uint32Array",
    "Float32Array",
    "Float64Array",
    "isNaN",
    "isFinite",
    "parseInt",
    "parseFloat",
    "encodeURI",
    "encodeURIComponent",
    "decodeURI",
    "decodeURIComponent",
];

/// Members that objects, arrays, strings, numbers or functions inherit.
const INHERITED: [&str; 94] = [
    "constructor",
    "hasOwnProperty",
    "isPrototypeOf",
    "propertyIsEnumerable",
    "toLocaleString",
    "toString",
    "valueOf",
    "__proto__",
    "__defineGetter__",
    "__defineSetter__",
    "__lookupGetter__",
    "__lookupSetter__",
    "at",
    "concat",
    "copyWithin",
    "entries",
    "every",
    "fill",
    "filter",
    "find",
    "findIndex",
    "findLast",
    "findLastIndex",
    "flat",
    "flatMap",
    "forEach",
    "includes",
    "indexOf",
    "join",
    "keys",
    "lastIndexOf",
    "map",
    "pop",
    "push",
    "reduce",
    "reduceRight",
    "reverse",
    "shift",
    "slice",
    "some",
    "sort",
    "splice",
    "toReversed",
    "toSorted",
    "toSpliced",
    "unshift",
    "values",
    "with",
    "charAt",
    "charCodeAt",
    "codePointAt",
    "endsWith",
    "isWellFormed",
    "localeCompare",
    "match",
    "matchAll",
    "normalize",
    "padEnd",
    "padStart",
    "repeat",
    "replace",
    "replaceAll",
    "search",
    "split",
    "startsWith",
    "substring",
    "substr",
    "toLocaleLowerCase",
    "toLocaleUpperCase",
    "toLowerCase",
    "toUpperCase",
    "toWellFormed",
    "trim",
    "trimEnd",
    "trimStart",
    "anchor",
    "big",
    "blink",
    "bold",
    "fixed",
    "link",
    "small",
    "strike",
    "sub",
    "sup",
    "toExponential",
    "toFixed",
    "toPrecision",
    "apply",
    "bind",
    "call",
    "caller",
    "arguments",
    "prototype",
];

/// Whether some values inherit a member with this name.
pub(super) fn is_inherited(name: &str) -> bool {
    INHERITED.contains(&name)
}

pub(super) fn is_reserved(word: &str) -> bool {
    RESERVED.contains(&word)
}

/// Whether a word is reserved.
pub(super) fn is_taken(word: &str) -> bool {
    ["In", "typeof", "void", "in", "instanceof", "else", "with", "case", "default", "finally"].contains(&word)
        || is_reserved(word)
        || system_name(word).is_some()
}

pub(super) fn system_name(name: &str) -> Option<Expr> {
    Some(match name {
        "true" => Expr::Constant(true.into()),
        "false" => Expr::Constant(false.into()),
        "null" => Expr::Constant(Datum::Null),
        "undefined" => Expr::Constant(Datum::Undefined),
        "NaN" => Expr::Constant(f64::NAN.into()),
        "Infinity" => Expr::Constant(f64::INFINITY.into()),
        "_event" => Expr::Event,
        "_name" => Expr::MachineName,
        "_sessionid" => Expr::SessionId,
        "_ioprocessors" => Expr::IoProcessors,
        "_x" => Expr::Object(Vec::new()),
        _ => return None,
    })
}

pub(super) fn prefix(kind: &TokenKind<'_>) -> Option<UnaryOp> {
    Some(match kind {
        TokenKind::Mark("!") => UnaryOp::Not,
        TokenKind::Mark("-") => UnaryOp::Minus,
        TokenKind::Mark("+") => UnaryOp::Plus,
        TokenKind::Mark("~") => UnaryOp::BitNot,
        TokenKind::Name("typeof") => UnaryOp::TypeOf,
        TokenKind::Name("void") => UnaryOp::Void,
        _ => return None,
    })
}

/// The binding power of an infix operator, and which operator it is. All but `?:` are left-associative.
pub(super) fn infix(kind: &TokenKind<'_>) -> Option<(u8, Infix)> {
    let TokenKind::Mark(mark) = kind else {
        return None;
    };
    Some(match *mark {
        "?" => (1, Infix::Choice),
        "??" => (2, Infix::Logic(LogicOp::Coalesce)),
        "||" => (3, Infix::Logic(LogicOp::Or)),
        "&&" => (4, Infix::Logic(LogicOp::And)),
        other => {
            let (power, op) = binary(other)?;
            (power, Infix::Binary(op))
        }
    })
}

pub(super) fn binary(mark: &str) -> Option<(u8, BinaryOp)> {
    Some(match mark {
        "|" => (5, BinaryOp::BitOr),
        "^" => (6, BinaryOp::BitXor),
        "&" => (7, BinaryOp::BitAnd),
        "==" => (8, BinaryOp::Equal),
        "!=" => (8, BinaryOp::NotEqual),
        "===" => (8, BinaryOp::Identical),
        "!==" => (8, BinaryOp::NotIdentical),
        "<" => (9, BinaryOp::Less),
        "<=" => (9, BinaryOp::LessEqual),
        ">" => (9, BinaryOp::Greater),
        ">=" => (9, BinaryOp::GreaterEqual),
        "<<" => (10, BinaryOp::ShiftLeft),
        ">>" => (10, BinaryOp::ShiftRight),
        ">>>" => (10, BinaryOp::ShiftRightUnsigned),
        "+" => (11, BinaryOp::Add),
        "-" => (11, BinaryOp::Subtract),
        "*" => (12, BinaryOp::Multiply),
        "/" => (12, BinaryOp::Divide),
        "%" => (12, BinaryOp::Remainder),
        _ => return None,
    })
}
