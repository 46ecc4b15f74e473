//! Finding the pictures that a model names. Models are moved between machines without the folders that they name, so a
//! picture is looked for in more than one place.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use tercio_mesh::io::relative;

use super::TextureError;

/// Folders beside a model in which exporters put textures, in lower case.
const SUBFOLDERS: [&str; 5] = ["textures", "texture", "tex", "maps", "images"];

/// Extensions that are tried in place of the one that is named.
const EXTENSIONS: [&str; 9] = ["png", "jpg", "jpeg", "tif", "tiff", "tga", "bmp", "webp", "gif"];

/// Of a folder with more entries, no others are looked at, so that a name costs a bounded time.
const MOST_ENTRIES: usize = 1 << 16;

/// Most names that are looked for; each takes up to a hundred file-system queries.
const MOST_NAMES: usize = 1 << 12;

/// No file system allows longer names.
const LONGEST_NAME: usize = 4096;

/// A file that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Where it is.
    pub path: PathBuf,
    /// Whether it has another extension than the one that is looked for.
    pub is_substitute: bool,
}

/// Looks for pictures in the folders of a model.
#[derive(Debug)]
pub struct Finder<'a> {
    folders: &'a [PathBuf],
    listings: HashMap<PathBuf, Listing>,
    names_left: usize,
}

impl<'a> Finder<'a> {
    /// In these folders, the first one first.
    pub fn new(folders: &'a [PathBuf]) -> Self {
        Self { folders, listings: HashMap::new(), names_left: MOST_NAMES }
    }

    /// Looks for `name`, which a file in the folder `library` names; that is relative to the model. Absolute names come
    /// from another machine, so only their last component is used.
    ///
    /// In each of the model's folders: the path as it is; then its last component in the path's folder, in `library`, in the
    /// model's folder and in folders for textures there, in upper or lower case. If nothing is found in any of them, a
    /// file of the same name with another extension.
    ///
    /// # Errors
    /// [`TextureError::NotFound`]; [`TextureError::NotAFile`] if there is only a folder or a device of that name.
    pub fn find(&mut self, library: &str, name: &str) -> Result<Found, TextureError> {
        if self.names_left == 0 {
            return Err(TextureError::TooMany { most: MOST_NAMES });
        }
        self.names_left -= 1;
        let name = relative(name);
        let library = if is_below(library) { library } else { "" };
        if name.is_empty() || name.len() + library.len() > LONGEST_NAME {
            return Err(TextureError::NotFound);
        }
        let path = Path::new(&name);
        let Some(last) = path.file_name().and_then(|last| last.to_str()).filter(|_| is_below(&name)) else {
            return Err(TextureError::NotFound);
        };
        let mut is_no_file = false;
        let folders = self.folders;
        for folder in folders {
            let exact = folder.join(library).join(path);
            match fs::metadata(&exact) {
                Ok(metadata) if metadata.is_file() => return Ok(Found { path: exact, is_substitute: false }),
                Ok(_) => is_no_file = true,
                Err(_) => {}
            }
            for place in self.places(folder, library, &exact) {
                if let Some(path) =
                    self.listing(&place).same(last).map(|n| place.join(n)).find(|p| p.is_file())
                {
                    return Ok(Found { path, is_substitute: false });
                }
            }
        }
        let stem = Path::new(last).file_stem().and_then(|stem| stem.to_str()).unwrap_or(last);
        for folder in folders {
            let exact = folder.join(library).join(path);
            for place in self.places(folder, library, &exact) {
                for extension in EXTENSIONS {
                    let name = format!("{stem}.{extension}");
                    let mut paths = self.listing(&place).same(&name).map(|n| place.join(n));
                    if let Some(path) = paths.find(|path| path.is_file()) {
                        return Ok(Found { path, is_substitute: true });
                    }
                }
            }
        }
        Err(if is_no_file { TextureError::NotAFile } else { TextureError::NotFound })
    }

    /// The folders in which the last component of a name is looked for.
    fn places(&mut self, folder: &Path, library: &str, exact: &Path) -> Vec<PathBuf> {
        let roots = [folder.join(library), folder.to_owned()];
        let mut places: Vec<PathBuf> = exact.parent().map(Path::to_owned).into_iter().collect();
        places.extend(roots.iter().cloned());
        for root in &roots {
            for name in SUBFOLDERS {
                places.extend(self.listing(root).same(name).map(|n| root.join(n)));
            }
        }
        let mut known: Vec<PathBuf> = Vec::new();
        places.into_iter().for_each(|place| {
            if !known.contains(&place) {
                known.push(place);
            }
        });
        known
    }

    fn listing(&mut self, folder: &Path) -> &Listing {
        self.listings.entry(folder.to_owned()).or_insert_with(|| Listing::of(folder))
    }
}

/// Is it a relative path? One that is not would replace the folder that it is joined to.
fn is_below(path: &str) -> bool {
    let path = Path::new(path);
    path.is_relative() && !path.has_root()
}

/// The names in a folder, sorted, by their lower case.
#[derive(Debug, Default)]
struct Listing {
    names: HashMap<String, Vec<String>>,
}

impl Listing {
    /// Empty if the folder cannot be read.
    fn of(folder: &Path) -> Self {
        // The current folder is written as nothing.
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let mut names: HashMap<String, Vec<String>> = HashMap::new();
        for entry in fs::read_dir(folder).into_iter().flatten().flatten().take(MOST_ENTRIES) {
            if let Ok(name) = entry.file_name().into_string() {
                names.entry(name.to_lowercase()).or_default().push(name);
            }
        }
        names.values_mut().for_each(|names| names.sort_unstable());
        Self { names }
    }

    /// The entries of this name, then those that differ in upper and lower case.
    fn same<'l>(&'l self, name: &'l str) -> impl Iterator<Item = &'l String> {
        let all = || self.names.get(&name.to_lowercase()).into_iter().flatten();
        all().filter(move |n| *n == name).chain(all().filter(move |n| *n != name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder with empty files.
    fn folder(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for file in files {
            let path = folder.path().join(file);
            fs::create_dir_all(path.parent().expect("a folder")).expect("room");
            fs::write(path, "").expect("room");
        }
        folder
    }

    /// The found file relative to the folder, with `~` before a substitute.
    fn found(root: &tempfile::TempDir, library: &str, name: &str) -> Option<String> {
        let folders = [root.path().to_owned()];
        let found = Finder::new(&folders).find(library, name).ok()?;
        let path = found.path.strip_prefix(root.path()).expect("inside").to_str().expect("text").to_owned();
        Some(if found.is_substitute { format!("~{path}") } else { path })
    }

    #[test]
    fn names_are_looked_for_beside_what_names_them() {
        let root = folder(&["a.png", "m/a.png", "m/sub/b.png", "c.png", "x/c.png"]);
        let is = |library, name, path: &str| assert_eq!(found(&root, library, name).as_deref(), Some(path));
        is("", "a.png", "a.png");
        is("m", "a.png", "m/a.png");
        is("m", "sub\\b.png", "m/sub/b.png");
        is("m", "../a.png", "m/../a.png");
        // Beside the model, if they are not beside the library.
        is("m", "c.png", "c.png");
        is("m", "gone/c.png", "c.png");
        // Paths of other machines.
        is("m", "C:\\art\\a.png", "m/a.png");
        is("", "/home/artist/a.png", "a.png");
        assert_eq!(found(&root, "", "d.png"), None);
        // Folders that no name leads to are not searched.
        assert_eq!(found(&root, "", "b.png"), None);
    }

    #[test]
    fn case_folders_for_textures_and_extensions_are_tried_in_this_order() {
        let is = |files: &[&str], name, path: Option<&str>| {
            let root = folder(files);
            assert_eq!(found(&root, "", name).as_deref(), path, "{name} in {files:?}");
        };
        is(&["A.PNG", "a.Png"], "a.png", Some("A.PNG"));
        is(&["A.PNG", "textures/a.png"], "a.png", Some("A.PNG"));
        is(&["Textures/Wood.JPG", "maps/wood.jpg"], "wood.jpg", Some("Textures/Wood.JPG"));
        is(&["tex/a.png", "images/a.png"], "x\\a.png", Some("tex/a.png"));
        is(&["a.png", "maps/a.tif"], "a.tif", Some("maps/a.tif"));
        is(&["a.jpg", "a.png"], "a.tif", Some("~a.png"));
        is(&["maps/A.jpeg"], "a.tif", Some("~maps/A.jpeg"));
        is(&["a.txt", "a"], "a.png", None);
        is(&["a.png/inside"], "a.png", None);
    }

    #[test]
    fn only_relative_paths_are_followed() {
        let (root, other) = (folder(&[]), folder(&["a.png"]));
        let outside = other.path().to_str().expect("text");
        assert_eq!(found(&root, outside, "a.png"), None);
        assert_eq!(found(&root, "", &format!("{outside}/a.png")), None);
        for name in ["", "/", "..", "a\0b", &"x".repeat(5000), "\"\""] {
            assert_eq!(found(&root, "", name), None, "{name:?}");
        }
        let folders = [root.path().to_owned(), other.path().to_owned()];
        let found = Finder::new(&folders).find("", "a.png").expect("the second folder");
        assert_eq!(found.path, other.path().join("a.png"));
        fs::create_dir(root.path().join("b.png")).expect("room");
        assert!(matches!(Finder::new(&folders).find("", "b.png"), Err(TextureError::NotAFile)));
    }

    #[test]
    fn the_number_of_names_is_limited() {
        let root = folder(&["a.png"]);
        let folders = [root.path().to_owned()];
        let mut finder = Finder::new(&folders);
        finder.names_left = 1;
        assert!(finder.find("", "a.png").is_ok());
        assert!(matches!(finder.find("", "a.png"), Err(TextureError::TooMany { .. })));
    }
}
