//! `tercio lab eval`: evaluates any formula of the documents by its name.

use std::fmt::Write;
use std::process::ExitCode;

use anyhow::{Result, anyhow};
use clap::Args;
use serde_json::{Value as Json, json};
use tercio::image::Destination;
use tercio_lab::models::registry::{self, Arguments, Model, Parameter, Value};

use crate::output::{UsageError, write_text};

/// Evaluates a formula of the documents.
#[derive(Debug, Args)]
#[command(after_help = "\
Values are numbers in the unit that --list shows, numbers with a unit of their own ('14 MHz'),
or lists ('[[1, 31], [2, 95]]').

Examples:
  tercio lab eval --list
  tercio lab eval --list eldridge.5.6
  tercio lab eval eldridge.5.6
  tercio lab eval eldridge.5.6 n=4096 a=42 b=30
  tercio lab eval overlap.2.10 S=32 w=40 h=55 a=1041.5 --json

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Eval {
    /// The formula's name, as listed by --list.
    #[arg(value_name = "ID", required_unless_present = "list")]
    id: Option<String>,
    /// Values of its parameters.
    #[arg(value_name = "NAME=VALUE")]
    values: Vec<String>,
    /// Lists the formulas: place in the document, parameters with units, defaults and meanings, and assumptions; with
    /// ID, those whose name begins with it, or else those that mention it.
    #[arg(long)]
    list: bool,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
}

impl Eval {
    /// Runs the command.
    ///
    /// # Errors
    /// Unknown names, missing or invalid values.
    pub fn run(&self) -> Result<ExitCode> {
        let text = if self.list { self.list()? } else { self.evaluate()? };
        write_text(&Destination::Stdout, &text)?;
        Ok(ExitCode::SUCCESS)
    }

    fn evaluate(&self) -> Result<String> {
        let model = registry::find(self.id.as_deref().unwrap_or_default())?;
        let given = arguments(&self.values)?;
        let outcome = model.evaluate(&given)?;
        if self.json {
            let mut value = model_json(model);
            value["given"] = serde_json::to_value(&given)?;
            value["value"] = serde_json::to_value(&outcome)?;
            return Ok(format!("{value:#}\n"));
        }
        let unit = if model.unit.is_empty() { String::new() } else { format!(" {}", model.unit) };
        Ok(format!("{outcome}{unit}\n"))
    }

    fn list(&self) -> Result<String> {
        let prefix = self.id.as_deref().unwrap_or_default();
        let models = registry::search(prefix);
        if models.is_empty() {
            registry::find(prefix)?;
        }
        if self.json {
            let all: Json = models.iter().map(|m| model_json(m)).collect();
            return Ok(format!("{all:#}\n"));
        }
        Ok(models.iter().map(|model| model_text(model)).collect())
    }
}

/// A formula's place, parameters and assumptions.
fn model_text(model: &Model) -> String {
    let unit = if model.unit.is_empty() { String::new() } else { format!(" [{}]", model.unit) };
    let mut text = format!("{}{unit}  ({})\n    {}\n", model.id, model.source(), model.what);
    let heads: Vec<_> = model.parameters.iter().map(parameter_text).collect();
    let width = heads.iter().map(|h| h.chars().count()).max().unwrap_or(0);
    for (parameter, head) in model.parameters.iter().zip(&heads) {
        // Writing into a string cannot fail.
        let _ = writeln!(text, "    {head:width$}  {}", model.meaning(parameter.name));
    }
    model.assumptions().for_each(|a| text += &format!("    assumes: {a}\n"));
    text
}

/// Reads `name=value` pairs.
fn arguments(values: &[String]) -> Result<Arguments> {
    let mut all = Arguments::new();
    for pair in values {
        let usage = |what: String| UsageError(what);
        let (name, value) =
            pair.split_once('=').ok_or_else(|| usage(format!("expected NAME=VALUE, found '{pair}'")))?;
        let value = Value::from_argument(value).map_err(|e| anyhow!("{name}: {e}"))?;
        if all.insert(name.trim().to_owned(), value).is_some() {
            return Err(usage(format!("'{name}' is given twice")).into());
        }
    }
    Ok(all)
}

fn parameter_text(parameter: &Parameter) -> String {
    let form = (parameter.form)();
    // Lists have their brackets already.
    let form = if form.starts_with('[') { form } else { format!("[{form}]") };
    let form = parameter
        .at_least
        .map_or_else(|| form.clone(), |least| form.replace(']', &format!(", at least {least}]")));
    let default = parameter.default.map_or(String::new(), |d| format!(" = {}", Value::Number(d)));
    format!("{} {form}{default}", parameter.name)
}

fn model_json(model: &Model) -> Json {
    let parameter = |p: &Parameter| {
        let meaning = model.meaning(p.name);
        json!({
            "name": p.name, "unit": p.unit, "form": (p.form)(), "at_least": p.at_least, "default": p.default,
            "meaning": meaning,
        })
    };
    json!({
        "id": model.id,
        "place": model.source(),
        "what": model.what,
        "unit": model.unit,
        "parameters": model.parameters.iter().map(parameter).collect::<Json>(),
        "assumptions": model.assumptions().collect::<Json>(),
    })
}
