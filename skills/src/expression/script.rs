//! Scripts: sequences of assignments.

use super::parse::Parser;
use super::token::{TokenKind, tokens};
use super::vocabulary::binary;
use super::{BinaryOp, Expr, ExpressionProblem, Location, Names, Parsed, Statement};

const DECLARATORS: [&str; 3] = ["var", "let", "const"];

/// Compiles a script.
pub(crate) fn script(source: &str, names: &Names) -> Parsed<Vec<Statement>> {
    let mut unknown = Vec::new();
    let outcome = tokens(source).and_then(|tokens| {
        let mut parser = Parser::new(&tokens, names);
        let mut statements = Vec::new();
        let result = loop {
            while parser.take_mark(";") {}
            if parser.peek().kind == TokenKind::End {
                break Ok(());
            }
            match statement(&mut parser, source) {
                Ok(statement) => statements.extend(statement),
                Err(problem) => break Err(problem),
            }
        };
        unknown = parser.unknown;
        result.map(|()| statements)
    });
    Parsed { outcome, unknown }
}

fn statement(parser: &mut Parser<'_, '_>, source: &str) -> Result<Option<Statement>, ExpressionProblem> {
    let declares = matches!(parser.peek().kind, TokenKind::Name(name) if DECLARATORS.contains(&name));
    if declares {
        parser.advance();
    }
    let start = parser.peek().span.start;
    let increment = step(parser);
    let left = parser.expression(0)?;
    let span = start..parser.taken_end();
    let increment = increment.or_else(|| step(parser));
    let statement = if let Some(op) = increment {
        // `x++` first converts x to a number, as `x - -1` does and `x + 1` does not.
        let opposite = if op == BinaryOp::Add { -1.0 } else { 1.0 };
        Some(Statement::Update(Location::from_expr(left, span)?, BinaryOp::Subtract, Expr::Constant(opposite.into())))
    } else if parser.take_mark("=") {
        let location = Location::from_expr(left, span)?;
        Some(Statement::Assign(location, parser.expression(0)?))
    } else if let Some(op) = update(parser) {
        let location = Location::from_expr(left, span)?;
        Some(Statement::Update(location, op, parser.expression(0)?))
    } else {
        (!declares).then_some(Statement::Evaluate(left))
    };
    end_statement(parser, source)?;
    Ok(statement)
}

/// `++` or `--`
fn step(parser: &mut Parser<'_, '_>) -> Option<BinaryOp> {
    if parser.take_mark("++") {
        Some(BinaryOp::Add)
    } else if parser.take_mark("--") {
        Some(BinaryOp::Subtract)
    } else {
        None
    }
}

/// `+=` and similar operators
fn update(parser: &mut Parser<'_, '_>) -> Option<BinaryOp> {
    let TokenKind::Mark(mark) = parser.peek().kind else {
        return None;
    };
    let (_, op) = binary(mark.strip_suffix('=')?)?;
    if matches!(mark, "<=" | ">=" | "==" | "!=") {
        return None;
    }
    parser.advance();
    Some(op)
}

/// A statement ends at a semicolon, at the end of the script, or at a line break.
fn end_statement(parser: &mut Parser<'_, '_>, source: &str) -> Result<(), ExpressionProblem> {
    let between = parser.taken_end()..parser.peek().span.start;
    let new_line = source.get(between).is_some_and(|gap| gap.contains('\n'));
    if new_line || parser.take_mark(";") { Ok(()) } else { parser.end() }
}
