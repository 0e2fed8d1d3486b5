//! The program under test: started, waited for, ended.

use std::{
    io::{BufRead, BufReader, Read},
    net::SocketAddr,
    process::{Child, ChildStdout, Command, ExitStatus, Output, Stdio},
};

use shared::protocol::Role;

use super::Client;

/// A running projector. It is killed when dropped.
pub(crate) struct Projector {
    child: Child,
    stdout: BufReader<ChildStdout>,
    address: SocketAddr,
}

fn command(arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_projector"));
    command
        .args(arguments.split_whitespace())
        .env_remove("WAYLAND_DISPLAY");
    command
}

/// Runs the program to its end with these variables; without any there is no display.
pub(crate) fn run(arguments: &str, environment: &[(&str, &str)]) -> Output {
    let mut command = command(arguments);
    let finished = command
        .env_remove("DISPLAY")
        .envs(environment.iter().copied())
        .output();
    finished.expect("the projector can be started")
}

impl Projector {
    /// Starts a projector on a free port and waits until it takes commands.
    pub(crate) fn start(arguments: &str, environment: &[(&str, &str)]) -> Self {
        let mut child = command(arguments)
            .args(["--listen", "127.0.0.1:0"])
            .envs(environment.iter().copied())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the projector can be started");
        let mut stdout = BufReader::new(child.stdout.take().expect("standard output is piped"));
        let mut line = String::new();
        stdout
            .read_line(&mut line)
            .expect("standard output is text");
        let address = line
            .trim_end()
            .strip_prefix("listening on ")
            .and_then(|a| a.parse().ok());
        let Some(address) = address else {
            child.kill().ok();
            panic!("the projector's first line is {line:?}");
        };
        Self {
            child,
            stdout,
            address,
        }
    }

    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }

    pub(crate) fn controller(&self) -> Client {
        Client::join(self.address(), Role::Controller, "test controller")
    }

    pub(crate) fn watcher(&self) -> Client {
        Client::join(self.address(), Role::Watcher, "test watcher")
    }

    /// Sends a signal, for example `TERM`.
    pub(crate) fn signal(&self, signal: &str) {
        let process = self.child.id().to_string();
        let sent = Command::new("kill").args(["-s", signal, &process]).status();
        assert!(sent.expect("kill can be started").success());
    }

    /// Waits for the end; gives the exit status and the rest of standard output.
    pub(crate) fn ended(mut self) -> (ExitStatus, String) {
        let mut rest = String::new();
        self.stdout
            .read_to_string(&mut rest)
            .expect("standard output is text");
        (self.child.wait().expect("the projector was started"), rest)
    }
}

impl Drop for Projector {
    fn drop(&mut self) {
        // It may have ended by itself.
        self.child.kill().ok();
        self.child.wait().ok();
    }
}
