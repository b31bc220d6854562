//! SCXML clause B.2: all of ECMAScript, with the engine.

use std::thread;
use std::time::Duration;

use proptest::prelude::*;
use skills::{Chart, Datum, Machine, Transcript};

use crate::bombs::scripts::outcomes;
use crate::diagnostics::in_short;
use crate::stage::{file, lenient, stage};

/// The value of an expression, among data.
fn value(expression: &str) -> Datum {
    value_with("", expression)
}

fn value_with(content: &str, expression: &str) -> Datum {
    let expression = expression.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    let stage = lenient(&format!(
        "<datamodel><data id='x' expr='5'/><data id='list' expr='[3, 1, 2]'/><data id='thing' expr='{{a: 1, b: {{c: 2}}}}'/><data id='result'/></datamodel>{content}
         <state id='s'><onentry><assign location='result' expr=\"{expression}\"/></onentry></state>"
    ));
    assert_eq!(stage.errors(), Vec::<&str>::new(), "{expression}: {:?}", stage.host.notes);
    stage.datum("result")
}

fn error(content: &str) -> String {
    let stage = lenient(&format!(
        "<datamodel><data id='x' expr='5'/></datamodel><state id='s'><onentry>{content}</onentry></state>"
    ));
    let reasons = stage.host.notes.iter().filter_map(|note| match note {
        skills::Note::Error { reason, .. } => Some(reason.clone()),
        _ => None,
    });
    reasons.collect::<Vec<_>>().join("; ")
}

#[test]
fn spec_b_2_functions_can_be_called() {
    for (expression, expected) in [
        ("Math.max(x, 7)", 7.0),
        ("[].concat(list, [4]).length", 4.0),
        ("parseInt('12px')", 12.0),
        ("list.map((item) => item * 2).reduce((sum, item) => sum + item, 0)", 12.0),
        ("(function (n) { return n < 2 ? 1 : n * arguments.callee })(1)", 1.0),
        ("`${x}${x}`.length", 2.0),
        ("thing?.b?.c", 2.0),
        ("/b+/.exec('abbc')[0].length", 2.0),
        ("++x", 6.0),
    ] {
        assert_eq!(value(expression), expected.into(), "{expression}");
    }
    assert_eq!(value("JSON.stringify(thing)"), r#"{"a":1,"b":{"c":2}}"#.into());
    assert_eq!(value("'name' in {name: 1} && list instanceof Array"), true.into());
    assert_eq!(value("Object.keys(thing).join()"), "a,b".into());
}

#[test]
fn spec_b_2_1_a_datum_may_be_a_function() {
    let stage = stage(
        "<datamodel><data id='double' expr='function (n) { return 2 * n }'/><data id='y' expr='double(4)'/></datamodel><state id='s'/>",
    );
    assert_eq!(stage.datum("y"), 8.0.into());
    assert_eq!(stage.datum("double"), Datum::Function("function (n) { return 2 * n }".into()));
}

#[test]
fn spec_5_8_a_script_declares_functions_and_variables() {
    let script = "<script>var rate = 3; function scaled(n) { return n * rate } class Thing { constructor() { this.n = 1 } } var thing1 = new Thing()</script>";
    assert_eq!(value_with(script, "scaled(x)"), 15.0.into());
    assert_eq!(value_with(script, "thing1.n + rate"), 4.0.into());
}

#[test]
fn spec_5_8_a_script_may_loop_and_branch() {
    let script = "<script>var sum = 0; for (let i = 0; i &lt; 5; i++) { if (i % 2) { continue } sum += i }</script>";
    assert_eq!(value_with(script, "sum"), 6.0.into());
}

#[test]
fn spec_b_2_an_expression_may_change_data() {
    let stage = stage(
        "<datamodel><data id='n' expr='1'/></datamodel><state id='s'><transition cond='++n == 2' target='t'/></state><state id='t'/>",
    );
    assert_eq!((stage.active(), stage.datum("n")), ("t".to_owned(), 2.0.into()));
}

#[test]
fn spec_b_2_methods_change_objects_for_every_holder() {
    let stage = stage(
        "<datamodel><data id='a' expr='[1]'/><data id='b' expr='a'/><data id='c' expr='{inner: a}'/></datamodel>
         <state id='s'><onentry><script>b.push(2)</script><assign location='b[0]' expr='9'/></onentry></state>",
    );
    assert_eq!(stage.datum("a").to_string(), "[9, 2]");
    assert_eq!(stage.datum("c").to_string(), r#"{"inner": [9, 2]}"#);
}

#[test]
fn spec_b_2_objects_are_equal_only_if_identical() {
    let data = "<script>var one = {n: 1}; var same = one; var other = {n: 1}</script>";
    assert_eq!(value_with(data, "[one == same, one == other, one === same].join()"), "true,false,true".into());
    assert_eq!(value_with(data, "one === same"), true.into());
}

#[test]
fn spec_b_2_in_is_a_function() {
    let stage = stage(
        "<state id='s'><transition cond=\"['t', 's'].some(In)\" target='ok'/></state><state id='t'/><state id='ok'/>",
    );
    assert_eq!(stage.active(), "ok");
}

#[test]
fn spec_5_10_system_variables_are_read_only() {
    for change in ["_event = 1", "_name = 'x'", "_sessionid += 'x'", "_ioprocessors = [].concat()", "_x = {}"] {
        let stage = lenient(&format!(
            "<state id='s'><onentry><raise event='e'/></onentry><transition event='e'><script>{change}; [].concat()</script></transition></state>"
        ));
        assert_eq!(stage.errors(), ["error.execution"], "{change}");
    }
    assert_eq!(value("[_name, typeof _sessionid, typeof _event].join()"), "test,string,undefined".into());
    let stage = lenient(
        "<datamodel><data id='n'/></datamodel><state id='s'><onentry><raise event='e'/></onentry><transition event='e'><script>n = Object.keys(_event).length; _event.name = 'f'</script></transition></state>",
    );
    assert_eq!(stage.errors(), ["error.execution"]);
}

#[test]
fn spec_b_2_a_thrown_error_is_an_error_of_execution_and_changes_nothing() {
    assert!(error("<script>x = 6; throw new TypeError('no')</script>").contains("TypeError: no"));
    let stage = lenient(
        "<datamodel><data id='x' expr='5'/></datamodel><state id='s'><onentry><script>x = 6; nothing()</script></onentry></state>",
    );
    assert_eq!(stage.datum("x"), 5.0.into());
}

#[test]
fn spec_b_2_xml_is_a_readable_object() {
    let data = "<datamodel><data id='books'><books xmlns=''><book title='one'/><book title='two'>text</book></books></data><data id='title' expr=\"books.getElementsByTagName('book')[1].getAttribute('title')\"/><data id='text' expr='books.lastChild.textContent.trim() || books.children[1].textContent'/></datamodel><state id='s'/>";
    let stage = stage(data);
    assert_eq!(stage.datum("title"), "two".into());
    assert_eq!(stage.datum("text"), "text".into());
    assert_eq!(stage.datum("books").to_string(), r#"<books><book title="one"/><book title="two">text</book></books>"#);
}

#[test]
fn values_that_data_cannot_hold_are_refused() {
    for (script, reason) in [
        ("x = new Map([[1, 2]])", "an object of this class cannot be kept in data"),
        ("x = Symbol('s')", "a symbol cannot be kept in data"),
        (
            "x = new Date(1500)",
            "a Date, only its number `getTime()` or its text `toISOString()`, cannot be kept in data",
        ),
        ("x = { at: new Date(1500) }", "a Date"),
        ("x = Math.max", "a built-in function cannot be kept in data"),
        ("x = {}; x.x = x", "a value may be nested at most 64 deep"),
        ("x = new Array(200000)", "a value may be nested at most 64 deep and have at most 100000 parts"),
    ] {
        let error = error(&format!("<script>{script}; [].concat()</script>"));
        assert!(error.contains(reason), "{script}: {error}");
    }
    assert_eq!(value("new Date(1500).getTime()"), 1500.0.into());
    for expression in ["f(10n)", "f(`${10n}`)", "f(2 ** 3)", "f(`${2 ** 3}`)", "f(0xffn)"] {
        let text = file("", &format!("<script>function f(n) {{ return n }} {expression}</script><state id='s'/>"));
        assert!(Chart::load("test.scxml", &text).is_err(), "{expression}");
    }
}

#[test]
fn a_date_that_would_become_data_gives_a_warning() {
    let warnings = |content: &str| {
        let data = "<datamodel><data id='x' expr='5'/></datamodel>";
        let text = file("", &format!("{data}<state id='s'><onentry>{content}</onentry></state>"));
        in_short(&text, Chart::load("test.scxml", &text).unwrap().warnings())
    };
    let script = |code: &str| warnings(&format!("<script>{code}</script>"));
    let expected = |date: &str| {
        format!(
            "«{date}» a `Date` cannot be kept in data\n    \
             keep its number, `getTime()` or `Date.now()`, or its text, `toISOString()`\n"
        )
    };
    for (code, date) in [
        ("x = new Date(1500)", "new Date(1500)"),
        ("var begun = new Date; x = begun.getTime()", "new Date"),
        ("x = new Date()\nx = 1", "new Date()"),
        ("x = { at: [1, new Date(Math.max(1, 2))] }", "new Date(Math.max(1, 2))"),
        ("if (x) { x = {}; x.at = new Date() }", "new Date()"),
    ] {
        assert_eq!(script(code), expected(date), "{code}");
    }
    assert_eq!(warnings("<assign location='x' expr='new Date(0)'/>"), expected("new Date(0)"));
    assert_eq!(warnings("<assign location='x' expr='{at: new Date(0)}'/>"), expected("new Date(0)"));
    for code in [
        "x = new Date().getTime()",
        "x = (new Date()).toISOString()",
        "x = Date.now()",
        "x = Date()",
        "x = new Date() - 5",
        "x = x == new Date(0)",
        "x = String(new Date())",
        "x = [new Date(0)].length",
        "x = 'new Date()'.slice(1)",
        "function later() { var now = new Date(); return now.getTime() } x = later()",
        "function at(now = new Date()) { return now.getTime() } x = at()",
    ] {
        assert_eq!(script(code), "", "{code}");
    }
    assert_eq!(warnings("<assign location='x' expr='new Date(0).getTime()'/>"), "");
}

#[test]
fn code_has_no_lasting_side_effects() {
    for script in [
        "undeclared = [].concat()",
        "this.leak = [].concat()",
        "globalThis.leak = 1",
        "[].constructor.constructor('return this')()",
        "(() => {}).constructor('leak = 1')()",
        "(function () { this.leak = 1 })()",
    ] {
        assert_ne!(error(&format!("<script>{script}</script>")), "", "{script}");
    }
    // If a script damages the engine's own objects, it damages only itself.
    for script in [
        "Array.prototype.first = 1",
        "Math.max = Math.min",
        "Object.prototype.toString = 1",
        "JSON = [].concat()",
        "Object.freeze(Object.prototype)",
        "Object.defineProperty(Array, 'x', {value: [].concat()})",
        "(function * () {})().__proto__.__proto__.__proto__.map = 1",
        "RegExp.prototype.exec = null",
        "Date.now = () => 1",
    ] {
        assert_eq!(error(&format!("<script>{script}; x = [1].concat(2).length</script>")), "", "{script}");
    }
    assert_eq!(value("typeof leak + typeof undeclared + typeof [].first"), "undefinedundefinedundefined".into());
    assert_eq!(value("[Math.max(1, 2), JSON.stringify({}), Date.now(), /a/.test('a')].join()"), "2,{},0,true".into());
    assert_eq!(
        value("(function () { function A() {} A.prototype.toString = () => 'mine'; return String(new A()) })()"),
        "mine".into()
    );
}

#[test]
fn thrown_errors_leave_no_trace() {
    let content = "<datamodel><data id='x'/></datamodel><state id='s'>
        <transition event='e'><script>throw 1</script></transition>
        <transition event='g'><script>x = [1].map(function (q) { return q }).length</script></transition></state>";
    let mut stage = lenient(content);
    for _ in 0..2_000 {
        stage.send("e");
    }
    let thrown = stage.errors().len();
    stage.send("g");
    assert_eq!((thrown, stage.errors().len(), stage.datum("x")), (2_000, 2_000, 1.0.into()));
}

/// On one thread, like a campaign's run after many others.
#[test]
#[ignore = "takes a minute: on demand"]
fn nothing_changes_after_a_hundred_thousand_errors_on_demand() {
    let mut thrower = lenient("<state id='s'><transition event='e'><script>throw 1</script></transition></state>");
    for _ in 0..100_000 {
        thrower.send("e");
    }
    assert_eq!(thrower.errors().len(), 100_000);
    let all = [
        spec_b_2_functions_can_be_called,
        spec_b_2_1_a_datum_may_be_a_function,
        spec_5_8_a_script_declares_functions_and_variables,
        spec_5_8_a_script_may_loop_and_branch,
        spec_b_2_an_expression_may_change_data,
        spec_b_2_methods_change_objects_for_every_holder,
        spec_b_2_objects_are_equal_only_if_identical,
        spec_b_2_in_is_a_function,
        spec_5_10_system_variables_are_read_only,
        spec_b_2_a_thrown_error_is_an_error_of_execution_and_changes_nothing,
        spec_b_2_xml_is_a_readable_object,
        values_that_data_cannot_hold_are_refused,
        code_has_no_lasting_side_effects,
        thrown_errors_leave_no_trace,
        promises_are_settled_before_a_script_has_ended,
        dates_do_not_depend_on_the_time_zone,
        endless_code_is_stopped_and_the_engine_stays_usable,
        time_and_random_numbers_are_those_of_the_run,
        mathematics_is_the_same_everywhere,
        machines_with_an_engine_are_values,
        deeply_nested_code_is_refused,
    ];
    all.into_iter().for_each(|holds: fn()| holds());
    let elsewhere = thread::spawn(outcomes).join().unwrap();
    assert_eq!(outcomes(), elsewhere);
}

#[test]
fn promises_are_settled_before_a_script_has_ended() {
    let script = "x = 0; Promise.resolve(2).then((y) => { x += y }); (async () => { await null; x += 40 })()";
    assert_eq!(value_with(&format!("<script>{script}</script>"), "[].concat(x)[0]"), 42.0.into());
}

#[test]
fn dates_do_not_depend_on_the_time_zone() {
    for (expression, expected) in [
        ("new Date(2020, 1, 2, 3, 4, 5).toISOString()", "2020-02-02T03:04:05.000Z"),
        ("new Date('2020-01-01T10:00:00').toISOString()", "2020-01-01T10:00:00.000Z"),
        ("new Date('Jan 1 2020').toISOString()", "2020-01-01T00:00:00.000Z"),
        ("new Date('2020-01-01T10:00:00+02:00').toISOString()", "2020-01-01T08:00:00.000Z"),
        ("String(new Date(0))", "Thu Jan 01 1970 00:00:00 GMT+0000 (UTC)"),
        ("Date()", "Thu Jan 01 1970 00:00:00 GMT+0000 (UTC)"),
        ("new Date(0).toLocaleString()", "Thu Jan 01 1970 00:00:00 GMT+0000 (UTC)"),
        ("String(new Date(NaN))", "Invalid Date"),
        ("(1234.5).toLocaleString()", "1234.5"),
    ] {
        assert_eq!(value(expression), expected.into(), "{expression}");
    }
}

#[test]
fn endless_code_is_stopped_and_the_engine_stays_usable() {
    for script in [
        "while (true) {}",
        "for (;;) { [].concat() }",
        "function f() { return f() } f()",
        "function g() { for (var i = 0; i &lt; 900000; i++) {} } for (;;) { g() }",
    ] {
        assert_ne!(error(&format!("<script>{script}</script>")), "", "{script}");
        assert_eq!(value("[].concat(list).length"), 3.0.into());
    }
}

#[test]
fn time_and_random_numbers_are_those_of_the_run() {
    let content = "<datamodel><data id='times' expr='[]'/><data id='numbers' expr='[]'/></datamodel>
        <state id='s'><onentry><send event='e' delay='1500ms'/></onentry><transition event='e'><script>times.push(Date.now(), new Date().getTimezoneOffset()); numbers.push(Math.random(), Math.random())</script></transition></state>";
    let run = || {
        let mut stage = stage(content);
        stage.at_ms(2000);
        (stage.datum("times").to_string(), stage.datum("numbers").to_string())
    };
    let (times, numbers) = run();
    assert_eq!(times, "[2000, 0]");
    assert_eq!((times, numbers.clone()), run());
    let text = file("", content);
    let mut machine = Machine::new(Chart::load("test.scxml", &text).unwrap());
    machine.set_seed(7);
    machine.start(Duration::ZERO, &mut Transcript::default());
    machine.fire_timers(Duration::from_secs(2), &mut Transcript::default());
    assert_ne!(machine.datum("numbers").unwrap().to_string(), numbers);
}

#[test]
fn mathematics_is_the_same_everywhere() {
    assert_eq!(value("Math.sin(1)"), libm_sin_1().into());
    assert_eq!(value("[Math.pow(1, Infinity), Math.hypot(3, 4), Math.pow(2, 10)].join()"), "NaN,5,1024".into());
    let stage = lenient("<datamodel><data id='x' expr='2 ** 3'/></datamodel><state id='s'/>");
    assert_eq!(stage.errors(), ["error.execution"]);
}

/// `libm::sin(1.0)`
fn libm_sin_1() -> f64 {
    0.841_470_984_807_896_5
}

#[test]
fn machines_with_an_engine_are_values() {
    let content = "<datamodel><data id='list' expr='[]'/></datamodel><state id='s'><transition event='e'><script>list.push(Math.random())</script></transition></state>";
    let mut one = stage(content);
    let mut copy = one.machine.clone();
    one.send("e");
    assert_ne!(one.machine, copy);
    copy.handle(skills::Event::external("e"), Duration::ZERO, &mut Transcript::default());
    assert_eq!(one.machine, copy);
}

#[test]
fn deeply_nested_code_is_refused() {
    for nested in ["(", "[", "!", "a=>", "x+", "new ", "if(x)", "`${", "x?x:", "x=", "{"] {
        let nested = nested.repeat(100_000);
        let escaped = nested.replace('&', "&amp;").replace('<', "&lt;");
        let text = file("", &format!("<script>f();{escaped}</script><state id='s'/>"));
        assert!(Chart::load("deep.scxml", &text).is_err());
    }
    for (nested, depth) in [("(", 35), ("[", 35), ("!", 200), ("- ", 200), ("typeof ", 200)] {
        let code = format!(
            "f({}1{})",
            nested.repeat(depth),
            ")]".chars()
                .find(|c| nested == "(" && *c == ')' || nested == "[" && *c == ']')
                .map_or(String::new(), |c| c.to_string().repeat(depth))
        );
        let text = file("", &format!("<script>function f(n) {{ return n }} {code}</script><state id='s'/>"));
        assert!(Chart::load("deep.scxml", &text).is_ok(), "{nested}");
    }
}

/// Expressions of the compiled subset.
fn expressions() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        Just("1".to_owned()),
        Just("0".to_owned()),
        Just("-2.5".to_owned()),
        Just("'7'".to_owned()),
        Just("''".to_owned()),
        Just("'b'".to_owned()),
        Just("true".to_owned()),
        Just("null".to_owned()),
        Just("undefined".to_owned()),
        Just("NaN".to_owned()),
        Just("x".to_owned()),
        Just("list".to_owned()),
        Just("alias".to_owned()),
        Just("thing".to_owned()),
        Just("thing.a".to_owned()),
        Just("thing.inner".to_owned()),
        Just("list[1]".to_owned()),
        Just("list.length".to_owned()),
        Just("'abc'.length".to_owned()),
        Just("[1, x]".to_owned()),
        Just("{a: x}".to_owned()),
        Just("_name".to_owned()),
        Just("_ioprocessors".to_owned()),
        Just("_event".to_owned()),
        Just("thing.missing".to_owned()),
        Just("x.y.z".to_owned()),
        Just("1e21".to_owned()),
        Just("0.1".to_owned()),
    ];
    leaf.prop_recursive(4, 24, 3, |inner| {
        let binary = prop_oneof![
            Just("+"),
            Just("-"),
            Just("*"),
            Just("/"),
            Just("%"),
            Just("<"),
            Just("<="),
            Just(">"),
            Just(">="),
            Just("=="),
            Just("!="),
            Just("==="),
            Just("!=="),
            Just("&"),
            Just("|"),
            Just("^"),
            Just("<<"),
            Just(">>"),
            Just(">>>"),
            Just("&&"),
            Just("||"),
        ];
        let unary = prop_oneof![Just("!"), Just("-"), Just("+"), Just("~"), Just("typeof "), Just("void ")];
        prop_oneof![
            (inner.clone(), binary, inner.clone()).prop_map(|(a, op, b)| format!("({a}) {op} ({b})")),
            (unary, inner.clone()).prop_map(|(op, a)| format!("{op}({a})")),
            (inner.clone(), inner.clone(), inner.clone()).prop_map(|(a, b, c)| format!("({a}) ? ({b}) : ({c})")),
            (inner.clone(), inner).prop_map(|(a, b)| format!("({a})[{b}]")),
        ]
    })
}

/// The value of an expression, alone or in a form that only the engine can evaluate.
fn outcome(expression: &str, by_engine: bool) -> Result<String, ()> {
    let escape = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    let expression = if by_engine { format!("((f) => f())(() => ({expression}))") } else { expression.to_owned() };
    let stage = lenient(&format!(
        "<datamodel><data id='x' expr='3'/><data id='list' expr='[10, 20]'/><data id='alias' expr='list'/><data id='thing' expr='{{a: 1, inner: {{b: 2}}}}'/><data id='result'/></datamodel>
         <state id='s'><onentry><assign location='result' expr=\"{}\"/></onentry></state>",
        escape(&expression)
    ));
    if stage.errors().is_empty() { Ok(stage.datum("result").to_string()) } else { Err(()) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]
    #[test]
    fn the_engine_and_the_compiled_subset_agree(expression in expressions()) {
        prop_assert_eq!(outcome(&expression, false), outcome(&expression, true), "{}", expression);
    }
}
