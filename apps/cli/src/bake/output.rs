//! What a bake writes.

use crate::{
    args::{BakeArgs, ToArg},
    failure::Failure,
    report::Reporter,
};
use conray::{
    Event, Session,
    scene::{Format, Origin},
    target::{self, AtlasMap, PngDepth},
};
use conray_bake::{
    BentSpace, Document, Origins, PngOptions, Sheets, Uvs, Written, bent_png, file_names, png,
    write_mapped_obj, write_model, write_mtl,
};
use std::{
    ffi::OsStr,
    path::{Path, PathBuf},
};

/// What the output is.
pub(super) enum Output {
    /// A model like the one that came in.
    Model(Document),
    /// PNG files.
    Png,
    /// EXR files.
    Exr,
    /// A PLY file with values at vertices.
    Ply,
    /// An OBJ file with values at vertices.
    Obj,
}

impl Output {
    /// What will be written, refused before any work where it cannot be; none where no output is named.
    pub(super) fn of(model: &Path, output: &Path) -> Result<Option<Self>, Failure> {
        if output.as_os_str().is_empty() {
            return Ok(None);
        }
        let request = |problem: String| Failure::Request(format!("-o {}: {problem}", output.display()));
        let ending =
            |path: &Path| path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let (from, to) = (ending(model), ending(output));
        let is_input = matches!((model.canonicalize(), output.canonicalize()), (Ok(a), Ok(b)) if a == b);
        match &to[..] {
            _ if is_input => Err(request("it is the model itself; choose another name".into())),
            "png" => Ok(Some(Self::Png)),
            "exr" => Ok(Some(Self::Exr)),
            "ply" => Ok(Some(Self::Ply)),
            "obj" => Ok(Some(Self::Obj)),
            "glb" | "gltf" if from == to => {
                let input = |problem: String| Failure::Input(format!("{}: {problem}", model.display()));
                let bytes = std::fs::read(model).map_err(|e| input(format!("cannot be read: {e}")))?;
                let format = Format::detect(model, &bytes);
                if format != Some(Format::Gltf) {
                    return Err(input("it is no glTF".into()));
                }
                Ok(Some(Self::Model(Document::open(&bytes).map_err(|e| input(e.to_string()))?)))
            }
            _ if matches!(&from[..], "glb" | "gltf") => {
                Err(request(format!("must end in .{from} as the model does, or in .png, .exr, .ply or .obj")))
            }
            _ => Err(request("must end in .png, .exr, .ply or .obj: only glTF is written back".into())),
        }
    }

    /// True where the values go to vertices, by what is asked for and what can hold them.
    pub(super) fn is_for_vertices(output: Option<&Self>, args: &BakeArgs) -> Result<bool, Failure> {
        let refuse = |what: &str| Err(Failure::Request(format!("--to: {what}")));
        match (args.to, output) {
            (Some(ToArg::Vertex), Some(Self::Png | Self::Exr)) => {
                refuse("images hold no vertices; choose .glb, .gltf, .ply or .obj for -o")
            }
            (Some(ToArg::Texture), Some(Self::Ply | Self::Obj)) => {
                refuse("no maps go into .ply and .obj; choose .png, .exr or a glTF for -o")
            }
            (to, Some(Self::Ply | Self::Obj)) => Ok(to != Some(ToArg::Texture)),
            (to, _) => Ok(to == Some(ToArg::Vertex)),
        }
    }

    /// Writes maps, and tells the files. `of` are the places in the model that instances come from, and the vertices of each.
    pub(super) fn write(
        self,
        args: &BakeArgs,
        sheets: &Sheets,
        maps: &[AtlasMap],
        of: (&[Origin], &[&[u32]]),
        session: &Session,
        reporter: &Reporter,
    ) -> Result<Vec<PathBuf>, Failure> {
        let to = args.output();
        let depth = if args.bits == "16" { PngDepth::Sixteen } else { PngDepth::Eight };
        let options = PngOptions { depth, look: args.look(), packs: args.pack };
        let stem = to.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let names = file_names(sheets);
        let mut files = Vec::new();
        if let Some(colours) = args.bent() {
            let beside = map_paths(&to.with_file_name(format!("{stem}.png")), &names);
            for (path, map) in beside.iter().zip(maps) {
                let bytes = bent_png(map, colours, depth);
                let name = path.file_stem().map(|name| name.to_string_lossy()).unwrap_or_default();
                let path = path.with_file_name(format!("{name}-bent.png"));
                target::write_atomically(&path, |out| out.write_all(&bytes))?;
                files.push(path);
            }
        }
        match self {
            Self::Model(document) => {
                let origins = Origins { instances: of.0, vertices: of.1 };
                let written = write_model(&to, &args.model(), document, &origins, sheets, maps, options)
                    .map_err(|e| Failure::Work(format!("{}: {e}", to.display())))?;
                tell_lacks(&written, reporter);
                files.extend(written.files);
            }
            // Refused before: these hold no maps.
            Self::Ply | Self::Obj => {}
            Self::Png | Self::Exr => {
                for (path, map) in map_paths(&to, &names).into_iter().zip(maps) {
                    if matches!(self, Self::Png) {
                        let bytes = png(map, options);
                        target::write_atomically(&path, |out| out.write_all(&bytes))?;
                    } else {
                        let mut attributes = conray::settings_text(&args.ao.settings());
                        attributes.push(("model".into(), args.model().display().to_string()));
                        attributes.push(("world-distance".into(), session.plan().distance.to_string()));
                        if args.bent().is_some_and(|bent| bent.space() == BentSpace::Tangent) {
                            attributes.push(("bent-space".into(), "tangent, y up".into()));
                        }
                        attributes.push(("version".into(), env!("CARGO_PKG_VERSION").into()));
                        target::write_exr(&path, &map.layers(), &attributes)?;
                    }
                    files.push(path);
                }
                if sheets.sheets.iter().any(|sheet| matches!(sheet.uvs, Uvs::New { .. })) {
                    files.extend(mapped_model(
                        args,
                        sheets,
                        &names,
                        &files[files.len() - maps.len()..],
                        session,
                    )?);
                }
            }
        }
        Ok(files)
    }
}

/// Files of maps: under the name asked for where there is one map, else with the map's name in it.
pub(super) fn map_paths(to: &Path, names: &[String]) -> Vec<PathBuf> {
    let part =
        |part: Option<&OsStr>| part.map(|part| part.to_string_lossy().into_owned()).unwrap_or_default();
    let (stem, ending) = (part(to.file_stem()), part(to.extension()));
    match names {
        [_] => vec![to.to_path_buf()],
        _ => names.iter().map(|name| to.with_file_name(format!("{stem}-{name}.{ending}"))).collect(),
    }
}

/// Warns of what a model was to have and has not.
pub(super) fn tell_lacks(written: &Written, reporter: &Reporter) {
    for map in &written.not_packed {
        reporter.event(Event::Warning { message: format!("occlusion is an image of its own: {map}") });
    }
    for name in &written.not_copied {
        let message = format!("{name}, which the model names, is not copied; copy it by hand");
        reporter.event(Event::Warning { message });
    }
}

/// The model with the UVs of its maps, where some of them are new: an OBJ and its materials beside the maps.
fn mapped_model(
    args: &BakeArgs,
    sheets: &Sheets,
    names: &[String],
    images: &[PathBuf],
    session: &Session,
) -> Result<[PathBuf; 2], Failure> {
    let to = args.output();
    let stem = to.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let beside = |ending: &str| to.with_file_name(format!("{stem}-mapped.{ending}"));
    let (model, library) = (beside("obj"), beside("mtl"));
    let name =
        |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let images: Vec<String> = images.iter().map(name).collect();
    write_mtl(&library, names, &images)?;
    write_mapped_obj(&model, session.geometry(), sheets, names, &name(&library), true)?;
    Ok([library, model])
}
