//! Options of pictures of several models, of scene files and of the configuration.

use std::path::PathBuf;

use clap::Args;

const WITH_HELP: &str = "\
Adds a model to the picture, with options of its own after semicolons: 'skin.stl;opacity=0.3;color=#e0b0a0'; several times.

The options are those of a model without --, as in the tables of a scene file: colour and opacity, data, lines and edges, \
textures, clipping, and its place. The other options of the command line belong to the first model, or to the whole picture. \
A semicolon in a name or value is doubled: ;;";

/// Several models in one picture.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Several models")]
pub struct SceneArgs {
    /// Adds a model to the picture, with options of its own: 'skin.stl;opacity=0.3;color=pink'; --help has more.
    #[arg(long, value_name = "FILE[;KEY=VALUE]", allow_hyphen_values = true, long_help = WITH_HELP)]
    with: Vec<String>,
    /// Draws all models in one picture, each in a colour of its own unless it has colours or there is a --color.
    #[arg(long)]
    together: bool,
    /// Writes the scene, all that the options say, as a scene file that draws the same picture: tercio render FILE.toml.
    #[arg(long, value_name = "FILE.toml")]
    pub save_scene: Option<PathBuf>,
    /// A file of defaults for all options, also by pattern of the model's name; none for no defaults [default: TERCIO_CONFIG, or
    /// tercio/config.toml in XDG_CONFIG_HOME or ~/.config].
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

impl SceneArgs {
    /// An option that is given, if any.
    pub fn given(&self) -> Option<&'static str> {
        let all = [
            (!self.with.is_empty(), "--with"),
            (self.together, "--together"),
            (self.save_scene.is_some(), "--save-scene"),
            (self.config.is_some(), "--config"),
        ];
        all.into_iter().find_map(|(is_given, name)| is_given.then_some(name))
    }
}
