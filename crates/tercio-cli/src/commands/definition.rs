//! What is made from the definition of the options: shell completions, manual pages, and the reference of options.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::Args;
use clap_complete::Shell;
use tercio::image::Destination;

use super::reference;
use crate::output::write_text;

/// Prints the completions of a shell.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  tercio completions bash > ~/.local/share/bash-completion/completions/tercio
  tercio completions zsh > ~/.zfunc/_tercio
  tercio completions fish > ~/.config/fish/completions/tercio.fish

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Completions {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    /// Runs the command.
    ///
    /// # Errors
    /// Standard output that cannot be written.
    pub fn run(&self) -> Result<ExitCode> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut crate::definition(), "tercio", &mut text);
        print(text)
    }
}

/// Prints a manual page.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  tercio man | man -l -
  tercio man render > tercio-render.1
  tercio man --all /usr/local/share/man/man1
  tercio man --markdown > options.md

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Man {
    /// The command, such as render [default: tercio itself].
    command: Option<String>,
    /// Writes the pages of tercio and of all its commands into this folder.
    #[arg(long, value_name = "FOLDER", conflicts_with = "command")]
    all: Option<PathBuf>,
    /// Prints the options of all commands as one page of Markdown.
    #[arg(long, conflicts_with_all = ["command", "all"])]
    markdown: bool,
}

impl Man {
    /// Runs the command.
    ///
    /// # Errors
    /// A command that does not exist; output that cannot be written.
    pub fn run(&self) -> Result<ExitCode> {
        let mut program = crate::definition();
        program.build();
        if self.markdown {
            return print(reference::page(&program).into_bytes());
        }
        if let Some(folder) = &self.all {
            let names = program.get_subcommands().filter(|command| !command.is_hide_set());
            let names: Vec<String> = names.map(|command| command.get_name().to_owned()).collect();
            for name in std::iter::once(None).chain(names.iter().map(Some)) {
                let file = name.map_or("tercio.1".into(), |name| format!("tercio-{name}.1"));
                let page = String::from_utf8(page(&program, name.map(String::as_str))?)?;
                write_text(&Destination::File(folder.join(file)), &page)?;
            }
            return Ok(ExitCode::SUCCESS);
        }
        print(page(&program, self.command.as_deref())?)
    }
}

fn page(program: &clap::Command, command: Option<&str>) -> Result<Vec<u8>> {
    let command = match command {
        None => program.clone(),
        Some(name) => match program.find_subcommand(name) {
            // Its name was made with that of the program, when that was built.
            Some(found) => found.clone(),
            None => {
                let names: Vec<_> = program.get_subcommands().map(clap::Command::get_name).collect();
                bail!("there is no command {name}: expected one of {}", names.join(", "))
            }
        },
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(command).render(&mut text)?;
    Ok(text)
}

fn print(text: Vec<u8>) -> Result<ExitCode> {
    write_text(&Destination::Stdout, &String::from_utf8(text)?)?;
    Ok(ExitCode::SUCCESS)
}
