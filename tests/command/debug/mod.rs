//! `srp debug` and `srp tandem`: a session by commands, which is a golden (`BLESS=1` writes it), sessions of an editor
//! over the Debug Adapter Protocol, and engines in lock step.

mod values;

use super::{cache, folder, srp, write};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

const PROGRAM: &str = include_str!("main.c");
const COMMANDS: &str = include_str!("session.txt");

fn command(folder: &Path, args: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_srp"));
    command
        .current_dir(folder)
        .arg("debug")
        .args(args)
        .env("SRP_CACHE", cache())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    command.spawn().expect("the command can be started")
}

/// What a session by commands says, each command before its answer.
fn told(folder: &Path, args: &[&str], commands: &str) -> String {
    let mut child = command(folder, args);
    let mut input = child.stdin.take().expect("it has an input");
    let commands = commands.to_owned();
    let writer = std::thread::spawn(move || input.write_all(commands.as_bytes()));
    let output = child.wait_with_output().expect("it ends");
    let written = writer.join().expect("it does not panic");
    written.expect("the session reads its commands");
    assert!(output.status.success());
    String::from_utf8(output.stdout).expect("it is text")
}

#[test]
fn a_session_by_commands() {
    let folder = folder("debug-terminal");
    write(&folder, "main.c", PROGRAM);
    let args = ["main.c", "--no-auto-kernel", "--terminal"];
    let found = told(&folder, &args, COMMANDS);
    let golden = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/command/debug/session.out");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&golden, &found).expect("the golden can be written");
    }
    let expected = std::fs::read_to_string(&golden).unwrap_or_default();
    assert!(
        found == expected,
        "the session differs; BLESS=1 takes it up:\n{found}"
    );
}

/// The answers of a session to commands, one after another.
fn answers(folder: &Path, file: &str, commands: &[&str]) -> Vec<String> {
    let marked: Vec<String> = commands
        .iter()
        .map(|c| format!("{c}\nprint 123456\n"))
        .collect();
    let said = told(folder, &[file, "--terminal"], &marked.concat());
    let answers = said
        .split("123456\n")
        .map(|answer| answer.trim_end().to_owned());
    answers.take(commands.len()).collect()
}

#[test]
fn next_goes_from_an_iteration_to_the_one_behind_it() {
    let folder = folder("debug-next");
    write(&folder, "main.c", PROGRAM);
    let args = ["main.c", "--no-auto-kernel", "--terminal"];
    let commands = format!("break main#3\nrun\n{}", "next\n".repeat(30));
    let said = told(&folder, &args, &commands);
    let at = said.split("main#3 iteration ").skip(1);
    let iterations: Vec<u64> = at
        .filter_map(|rest| rest.split(',').next()?.parse().ok())
        .collect();
    let is_near = |pair: &[u64]| pair[1] == pair[0] || pair[1] == pair[0] + 1;
    assert!(iterations.windows(2).all(is_near), "{iterations:?}");
    assert!(iterations.last() > Some(&2), "{iterations:?}");
}

#[test]
fn a_variable_has_a_value_whatever_its_name() {
    let folder = folder("debug-names");
    let text = "float data[16];\nint main(void) {\n    float temporary_sum = 0.5f;\n    \
        for (int i = 0; i < 16; i++)\n        temporary_sum += data[i] + 1.5f;\n    \
        return (int)temporary_sum;\n}\n";
    write(&folder, "f.c", text);
    let commands = ["break f.c:6", "run", "print temporary_sum"];
    let said = answers(&folder, "f.c", &commands);
    assert_eq!(said[2], "24.5");
}

#[test]
fn aggregates_have_members_and_types() {
    let folder = folder("debug-aggregates");
    write(&folder, "f.c", include_str!("aggregates.c"));
    let cases = [
        ("break f.c:12", "breakpoint 1 at f.c:12"),
        (
            "print s",
            "{in = {x = 1, y = 2.5}, k = 3, c = \"ab\", b = 5, d = -2}",
        ),
        ("print p->in.y", "2.5"),
        (
            "print *p",
            "{in = {x = 1, y = 2.5}, k = 3, c = \"ab\", b = 5, d = -2}",
        ),
        ("print s.d", "-2"),
        ("print s.d == -2", "true"),
        ("print (*p).c[1]", "98 'b'"),
        ("print counts[1]", "2"),
        ("print grid", "{{1.0, 2.0}, {3.0, 4.5}}"),
        ("print grid[1][1] > 4.25", "true"),
        (
            "print s.nothing",
            "`s` is struct s, which has no member `nothing`",
        ),
        ("print s.in[0]", "`s.in` is struct v, which has no elements"),
        ("whatis s.in", "type = struct v"),
        ("whatis p", "type = struct s *"),
        ("whatis grid", "type = float [2][2]"),
        (
            "ptype s.in",
            "type = struct v\n  +0 int x\n  +4 float y\n  8 bytes",
        ),
        (
            "watch nowhere.x",
            "`nowhere` has a value nowhere: no operation makes a variable of this name, and no object \
          or register has it",
        ),
        ("watch counts[2]", ""),
        ("watch s.in.x", ""),
    ];
    let commands: Vec<&str> = cases.iter().map(|(command, _)| *command).collect();
    let said = answers(&folder, "f.c", &commands);
    for ((command, expected), said) in cases.iter().zip(&said) {
        assert!(expected.is_empty() || said == expected, "{command}: {said}");
    }
    assert!(
        said[17].starts_with("watch 2 of counts[2], 4 bytes at 0x"),
        "{}",
        said[17]
    );
    let counts = &answers(&folder, "f.c", &["print counts"])[0];
    assert!(counts.starts_with("{1, 2, 3, 0, "), "{counts}");
    assert!(
        counts.ends_with(", ... of 300}") && counts.matches(", ").count() == 200,
        "{counts}"
    );
    let watched = ["watch counts[2]", "watch s.in.x", "run", "continue"];
    let said = answers(&folder, "f.c", &watched);
    assert!(
        said[2].contains("watch 1: counts[2] was 3 and is 9"),
        "{}",
        said[2]
    );
    assert!(
        said[3].contains("watch 2: s.in.x was 1 and is 10"),
        "{}",
        said[3]
    );
}

/// An editor, as far as a session needs one.
struct Editor {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    seq: u64,
    /// The thread of the last stop.
    thread: u64,
    /// What the program has printed.
    output: String,
}

impl Editor {
    fn of(folder: &Path, args: &[&str]) -> Editor {
        let mut child = command(folder, args);
        let to = child.stdin.take().expect("it has an input");
        let from = child.stdout.take().expect("it has an output");
        let mut editor = Editor {
            child,
            to,
            from: BufReader::new(from),
            seq: 0,
            thread: 1,
            output: String::new(),
        };
        let can = editor.ask("initialize", json!({"adapterID": "srp"}));
        assert_eq!(can["supportsStepBack"], true);
        editor.event("initialized");
        editor.ask("launch", json!({"stopOnEntry": true}));
        editor
    }

    fn message(&mut self) -> Value {
        let mut length = 0;
        loop {
            let mut line = String::new();
            self.from.read_line(&mut line).expect("a header");
            if line == "\r\n" {
                break;
            }
            let (name, value) = line.split_once(": ").expect("a header");
            assert_eq!(name, "Content-Length");
            length = value.trim_end().parse().expect("a length");
        }
        let mut bytes = vec![0; length];
        self.from.read_exact(&mut bytes).expect("a message");
        serde_json::from_slice(&bytes).expect("JSON")
    }

    fn tell(&mut self, command: &str, arguments: Value) {
        self.seq += 1;
        let request =
            json!({"seq": self.seq, "type": "request", "command": command, "arguments": arguments});
        let text = request.to_string();
        write!(self.to, "Content-Length: {}\r\n\r\n{text}", text.len()).expect("it listens");
    }

    /// The body of the answer to a request.
    fn ask(&mut self, command: &str, arguments: Value) -> Value {
        self.tell(command, arguments);
        let answer = self.message();
        assert_eq!(answer["type"], "response", "{answer}");
        assert_eq!(answer["request_seq"], self.seq, "{answer}");
        assert_eq!(answer["success"], true, "{answer}");
        answer["body"].clone()
    }

    /// The body of the next event but for outputs, which is of this name.
    fn event(&mut self, name: &str) -> Value {
        loop {
            let event = self.message();
            if event["event"] == "output" {
                self.output += event["body"]["output"].as_str().expect("a text");
                continue;
            }
            assert_eq!(event["event"], name, "{event}");
            return event["body"].clone();
        }
    }

    /// Goes on, and stops for this reason.
    fn go(&mut self, command: &str, reason: &str) -> Value {
        self.ask(command, json!({"threadId": self.thread}));
        let stop = self.event("stopped");
        self.thread = stop["threadId"].as_u64().expect("a thread");
        assert_eq!(stop["reason"], reason, "{stop}");
        stop
    }

    fn frames(&mut self) -> Vec<Value> {
        let trace = self.ask("stackTrace", json!({"threadId": self.thread}));
        trace["stackFrames"].as_array().expect("frames").clone()
    }

    /// The value of an expression at the innermost frame.
    fn value(&mut self, expression: &str) -> String {
        let value = self.ask("evaluate", json!({"expression": expression}));
        value["result"].as_str().expect("a value").to_owned()
    }

    /// What is in a scope of a frame.
    fn scope(&mut self, frame: &Value, name: &str) -> Vec<Value> {
        let scopes = self.ask("scopes", json!({"frameId": frame["id"]}));
        let scopes = scopes["scopes"].as_array().expect("scopes").clone();
        let scope = scopes.iter().find(|scope| scope["name"] == name);
        let reference = &scope.expect("the scope is there")["variablesReference"];
        self.parts(reference)
    }

    fn parts(&mut self, reference: &Value) -> Vec<Value> {
        let variables = self.ask("variables", json!({"variablesReference": reference}));
        variables["variables"]
            .as_array()
            .expect("variables")
            .clone()
    }

    fn leave(mut self) {
        self.ask("disconnect", Value::Null);
        assert!(self.child.wait().expect("it ends").success());
    }
}

fn named<'v>(variables: &'v [Value], name: &str) -> &'v Value {
    let found = variables.iter().find(|variable| variable["name"] == name);
    found.unwrap_or_else(|| panic!("no {name} in {variables:?}"))
}

#[test]
fn an_editor_debugs_a_loop_on_the_array() {
    let folder = folder("debug-adapter");
    write(&folder, "main.c", PROGRAM);
    let file = folder.join("main.c").display().to_string();
    let mut editor = Editor::of(&folder, &["main.c", "--no-auto-kernel"]);
    let set = editor.ask(
        "setBreakpoints",
        json!({"source": {"path": file}, "breakpoints": [
            {"line": 18, "condition": "iteration == 17"}, {"line": 900}, {"line": 18, "condition": "1 +"},
            {"line": 18, "hitCondition": "> 5"}]}),
    );
    let verified: Vec<&Value> = (0..4).map(|i| &set["breakpoints"][i]["verified"]).collect();
    assert_eq!(verified, [true, false, false, false]);
    editor.ask("configurationDone", Value::Null);
    assert_eq!(editor.event("stopped")["reason"], "entry");
    assert_eq!(
        editor.ask("threads", Value::Null)["threads"][0]["name"],
        "core 0"
    );

    // a[17] is 18.
    editor.go("continue", "breakpoint");
    let frames = editor.frames();
    assert_eq!(frames[0]["line"], 18);
    assert!(
        frames[0]["source"]["path"]
            .as_str()
            .is_some_and(|p| p.ends_with("/main.c"))
    );
    let name = frames[0]["name"].as_str().expect("a name");
    assert!(name.starts_with("main#1 iteration 17, stage "), "{name}");
    let variables = editor.scope(&frames[0], "Variables");
    assert_eq!(named(&variables, "x")["value"], "36.0");
    let operations = editor.scope(&frames[0], "Operations");
    assert!(operations.iter().any(|o| {
        o["name"]
            .as_str()
            .is_some_and(|n| n.starts_with("17: x = fmul"))
    }));
    // The iteration behind it has got as far one cycle later.
    let next = frames.iter().find(|f| {
        f["name"]
            .as_str()
            .is_some_and(|n| n.contains("iteration 16"))
    });
    let variables = editor.scope(next.expect("it is on its way"), "Variables");
    assert_eq!(named(&variables, "y")["value"], "35.0");
    assert!(!editor.scope(&frames[0], "Registers").is_empty());
    let objects = editor.scope(&frames[0], "Objects in SRAM");
    let a = named(&objects, "a").clone();
    let elements = editor.parts(&a["variablesReference"]);
    assert_eq!(elements[17]["value"], "18.0f (0x41900000)");
    let memory = json!({"memoryReference": a["memoryReference"], "offset": 68, "count": 4});
    assert_eq!(editor.ask("readMemory", memory)["data"], "AACQQQ==");

    // Back over the lines of the iteration, and forth again.
    assert_eq!(editor.value("iteration"), "17");
    editor.go("next", "step");
    let ahead = editor.frames()[0].clone();
    assert!(
        ahead["line"] != 18
            && ahead["name"]
                .as_str()
                .is_some_and(|n| n.contains("iteration 17"))
    );
    editor.go("stepBack", "breakpoint");
    assert_eq!(editor.frames()[0]["line"], 18);

    // A watched word, a launch, a function, a cycle.
    editor.ask(
        "setBreakpoints",
        json!({"source": {"path": file}, "breakpoints": []}),
    );
    let info = editor.ask("dataBreakpointInfo", json!({"name": "b[3]"}));
    let data = json!({"breakpoints": [{"dataId": info["dataId"]}]});
    editor.ask("setDataBreakpoints", data);
    let stop = editor.go("continue", "data breakpoint");
    assert!(
        stop["text"]
            .as_str()
            .is_some_and(|t| t.ends_with("b[3] was 9.0 and is 18.0")),
        "{stop}"
    );
    editor.ask("setDataBreakpoints", json!({"breakpoints": []}));
    let functions =
        json!({"breakpoints": [{"name": "main#4"}, {"name": "hops"}, {"name": "cycle:1000"}]});
    editor.ask("setFunctionBreakpoints", functions);
    editor.go("continue", "breakpoint");
    assert_eq!(editor.value("b[3]"), "27.0");
    editor.go("continue", "breakpoint");
    let frames = editor.frames();
    assert_eq!(
        (&frames[0]["name"], &frames[1]["name"]),
        (&json!("hops"), &json!("main"))
    );
    editor.go("stepOut", "step");
    assert_eq!(editor.frames()[0]["name"], "main");
    let stop = editor.go("continue", "breakpoint");
    assert_eq!(stop["description"], "cycle 1000");
    editor.go("reverseContinue", "breakpoint");
    assert_eq!(editor.frames()[0]["name"], "hops");
    editor.ask("setFunctionBreakpoints", json!({"breakpoints": []}));
    editor.ask("continue", json!({"threadId": 1}));
    assert_eq!(editor.event("exited")["exitCode"], 6);
    assert_eq!(editor.output, "6 125\n");
    editor.event("terminated");
    editor.leave();
}

#[test]
fn what_is_no_message_is_refused() {
    let folder = folder("debug-message");
    write(&folder, "main.c", PROGRAM);
    let mut command = Command::new(env!("CARGO_BIN_EXE_srp"));
    command.current_dir(&folder).args(["debug", "main.c"]);
    command.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command
        .stderr(Stdio::piped())
        .spawn()
        .expect("it can be started");
    let mut input = child.stdin.take().expect("it has an input");
    input
        .write_all(b"Content-Length: 5\r\n\r\n{\"a\":")
        .expect("it listens");
    drop(input);
    let output = child.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("cannot read standard input"), "{said}");
}

#[test]
fn an_editor_debugs_a_frame() {
    let folder = folder("debug-frame");
    let mut editor = Editor::of(&folder, &["--frame", "--size", "32x24"]);
    let functions = json!({"breakpoints": [{"name": "shade_hit#2@0"}]});
    editor.ask("setFunctionBreakpoints", functions);
    editor.ask("configurationDone", Value::Null);
    editor.event("stopped");
    let threads = editor.ask("threads", Value::Null);
    assert_eq!(threads["threads"].as_array().map(Vec::len), Some(4));
    editor.go("continue", "breakpoint");
    let frames = editor.frames();
    let name = frames[0]["name"].as_str().expect("a name");
    assert!(name.starts_with("shade_hit#2 iteration 0,"), "{name}");
    let launched = editor.value("cycle");
    // The kernels come along: their text is the debugger's.
    let shader = frames[0]["source"].clone();
    let source = editor.ask(
        "source",
        json!({"sourceReference": shader["sourceReference"]}),
    );
    let text = source["content"].as_str().expect("a text");
    let line = 1 + text
        .lines()
        .position(|l| l.contains("float w = 1.0f - u - v;"))
        .expect("it is there");
    let breakpoints = json!({"source": shader,
        "breakpoints": [{"line": line + 1, "condition": "iteration == 17"}]});
    let set = editor.ask("setBreakpoints", breakpoints);
    assert_eq!(set["breakpoints"][0]["verified"], true);

    editor.go("continue", "breakpoint");
    let frames = editor.frames();
    let name = frames[0]["name"].as_str().expect("a name");
    assert!(name.contains("iteration 17,"), "{name}");
    assert_eq!(frames[0]["line"], set["breakpoints"][0]["line"]);
    assert_eq!(frames[0]["source"], shader);
    let (cycle, shown) = (editor.value("cycle"), editor.scope(&frames[0], "Variables"));
    assert!(!shown.is_empty());
    // The same state after other ways to it: on, back to the launch, on again.
    for _ in 0..3 {
        editor.go("next", "step");
    }
    assert_ne!(editor.value("cycle"), cycle);
    editor.go("reverseContinue", "breakpoint");
    assert_eq!(editor.value("cycle"), cycle);
    let frames = editor.frames();
    assert_eq!(editor.scope(&frames[0], "Variables"), shown);
    editor.go("reverseContinue", "breakpoint");
    assert_eq!(editor.value("cycle"), launched);
    editor.go("continue", "breakpoint");
    assert_eq!(editor.value("cycle"), cycle);
    let frames = editor.frames();
    assert_eq!(editor.scope(&frames[0], "Variables"), shown);

    // It is asked to stop while it runs.
    editor.ask(
        "setBreakpoints",
        json!({"source": shader, "breakpoints": []}),
    );
    editor.ask("setFunctionBreakpoints", json!({"breakpoints": []}));
    editor.ask("continue", json!({"threadId": 1}));
    editor.ask("pause", json!({"threadId": 1}));
    assert_eq!(editor.event("stopped")["reason"], "pause");
    editor.leave();
}

#[test]
fn engines_go_in_lock_step() {
    let folder = folder("tandem");
    write(&folder, "main.c", PROGRAM);
    for args in [
        &["tandem", "main.c"][..],
        &["tandem", "main.c", "--engine", "interp"],
        &["tandem", "--frame", "--size", "8x8", "--engine", "interp"],
    ] {
        let output = srp(&folder, args);
        let said = String::from_utf8_lossy(&output.stderr);
        if said.contains("there is no simulator") {
            println!("skipped: there is no rustc");
            continue;
        }
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert!(said.contains("cycles agreed on"), "{said}");
    }
}
