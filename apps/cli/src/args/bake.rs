//! Options of `conray bake`.

use super::{AoArgs, RunArgs, parse::parse_side_or_size};
use clap::{Args, ValueEnum, builder::PossibleValuesParser};
use conray::{Backs, Geometry, scene::Extras, target::MapSize};
use conray_bake::{
    BentColours, BentSpace, Facing, Ground, Look, MapExtent, NormalMaps, Normals, Scope, VertexAttribute,
    VertexSettings,
};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

#[derive(Args, Clone, Debug)]
pub(crate) struct BakeArgs {
    /// The model: .glb, .gltf or .obj, for vertices .ply and .stl too. The UVs that it has are used where they do not lie over each other; a glTF gets new ones where they do
    ///
    /// Several are baked one after the other, into a folder.
    #[arg(required_unless_present = "options")]
    model: Vec<PathBuf>,
    /// What to write: a model like the one given (.glb, .gltf), its occlusion textures set; .png, a map for each material; .exr, the same as
    /// 32-bit floats with expected errors and bent directions; or .ply or .obj, values at vertices. Of several models the folder: each glTF as it is named there, of others
    /// maps
    #[arg(short, long, value_name = "FILE", required_unless_present_any = ["options", "dry_run"])]
    output: Option<PathBuf>,
    /// What carries the values: textures, or the vertices; without it by the output: vertices for .ply and .obj
    #[arg(long, value_enum)]
    pub(crate) to: Option<ToArg>,
    /// Size of each map in texels, such as 2048 or 2048x1024
    #[arg(long, value_name = "N|WxH", default_value = "1024", value_parser = parse_side_or_size)]
    size: (u32, u32),
    /// Texels for each unit of length of the model, instead of a size: each map is as large as its surfaces need for that in the mean, up to 16384
    #[arg(long, value_name = "X", conflicts_with = "size", value_parser = parse_density, allow_negative_numbers = true)]
    density: Option<f32>,
    /// Makes no new UVs: refuses a model whose UVs lie over each other or reach over several tiles
    #[arg(long)]
    pub(crate) no_unwrap: bool,
    /// Texels by which islands are extended; without it until they meet
    #[arg(long, value_name = "N")]
    pub(crate) padding: Option<u32>,
    /// Divides each texel into N x N parts, each asked about by itself
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=8))]
    pub(crate) supersample: u32,
    /// Bits per sample of PNG maps
    #[arg(long, value_name = "8|16", default_value = "8", value_parser = PossibleValuesParser::new(["8", "16"]))]
    pub(crate) bits: String,
    /// Puts occlusion into the red channel of the image of roughness and metalness, 8 bits, where a material of a glTF reads both by the same UVs
    #[arg(long)]
    pub(crate) pack: bool,
    /// Writes bent directions too, as PNG files beside the output, -1 to 1 as black to white: in world space, or in tangent space with green up (glTF, OpenGL) or down
    /// (DirectX)
    #[arg(long, value_enum, value_name = "SPACE", num_args = 0..=1, default_missing_value = "world")]
    bent_normals: Option<BentArg>,
    /// Copies of a mesh share one map, each occluded by its own node alone
    #[arg(long)]
    pub(crate) shared: bool,
    /// Writes a picture of few rays first: .png for maps, one for each material, refined with each portion of the maps that is done; .ply for vertices
    #[arg(long, value_name = "FILE")]
    pub(crate) preview: Option<PathBuf>,
    /// Keeps the work in this folder, at the end and when interrupted, and goes on with what is there; only method hybrid. The same
    /// --rays or --error then gives the same bits as without interruption, another goes on from there
    #[arg(long, value_name = "FOLDER")]
    pub(crate) state: Option<PathBuf>,
    /// Prints what would be done - maps, texels, memory, time - and writes nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Takes options from a JSON file first, as the summary of --json has them under "job"; those given here come on top
    #[arg(long, value_name = "FILE")]
    pub(crate) job: Option<PathBuf>,
    /// Lists all options with their values and defaults, as JSON
    #[arg(long, value_name = "FORMAT", value_parser = PossibleValuesParser::new(["json"]), exclusive = true)]
    pub(crate) options: Option<String>,
    #[command(flatten)]
    pub(crate) vertex: VertexArgs,
    #[command(flatten)]
    scope: ScopeArgs,
    #[command(flatten)]
    look: LookArgs,
    #[command(flatten)]
    pub(crate) ao: AoArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// Space of bent directions, and where green points.
#[derive(ValueEnum, Clone, Copy, Debug)]
enum BentArg {
    World,
    Tangent,
    TangentDx,
}

/// What carries the values.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ToArg {
    Texture,
    Vertex,
}

/// How values come to vertices.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Vertices")]
pub(crate) struct VertexArgs {
    /// Where a glTF holds them: in COLOR_0 in place of its colours or times these, or in the attribute _AO
    #[arg(long, value_enum, default_value = "color")]
    attribute: AttributeArg,
    /// Points for each triangle in the mean, from 1 to 256, to which the values are fitted
    #[arg(long, value_name = "N", default_value_t = VertexSettings::default().samples_per_triangle, allow_negative_numbers = true)]
    samples_per_triangle: f32,
    /// How much kinks between triangles count against nearness to the points, from 0 to 1000
    #[arg(long, value_name = "X", default_value_t = VertexSettings::default().smoothness, allow_negative_numbers = true)]
    smoothness: f32,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum AttributeArg {
    Color,
    Multiply,
    Ao,
}

impl VertexArgs {
    pub(crate) fn settings(&self) -> VertexSettings {
        VertexSettings { samples_per_triangle: self.samples_per_triangle, smoothness: self.smoothness }
    }

    pub(crate) fn attribute(&self) -> VertexAttribute {
        match self.attribute {
            AttributeArg::Color => VertexAttribute::Color,
            AttributeArg::Multiply => VertexAttribute::MultipliedColor,
            AttributeArg::Ao => VertexAttribute::Ao,
        }
    }
}

/// Who takes part.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Scope")]
struct ScopeArgs {
    /// Only what has such a name occludes: of a node, a mesh or a material, * for any characters and ? for one; may repeat
    #[arg(long, value_name = "PATTERN")]
    occluders: Vec<String>,
    /// Only what has such a name is baked; may repeat
    #[arg(long, value_name = "PATTERN")]
    receivers: Vec<String>,
    /// Each object is occluded by itself alone: a node of a glTF, an object of an OBJ
    #[arg(long)]
    self_only: bool,
    /// Adds a ground that occludes, under the lowest point or at a height
    #[arg(long, value_name = "Y", num_args = 0..=1, default_missing_value = "lowest", value_parser = parse_ground, allow_negative_numbers = true)]
    ground: Option<Ground>,
    /// Rays pass the backs of surfaces: of those that are not said to be seen from both sides, as all in OBJ files are, or of all
    #[arg(long, value_name = "WHICH", num_args = 0..=1, default_missing_value = "one-sided")]
    ignore_backfaces: Option<BacksArg>,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum BacksArg {
    OneSided,
    All,
}

/// Where points look, and what is done for the looks.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Look")]
struct LookArgs {
    /// Normal about which the hemisphere is taken: that of the shading, of the triangle, or of the material's normal map
    #[arg(long, value_enum, default_value = "shading")]
    normal: NormalArg,
    /// Looks into the surface: how thick a body is, by the AO distance
    #[arg(long)]
    inside: bool,
    /// Multiplies occlusion in models and PNG files, from 0 to 10; 1 is the truth
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = parse_look, allow_negative_numbers = true)]
    intensity: f32,
    /// Raises visibility to a power in models and PNG files, from 0 to 10; 1 is the truth
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = parse_look, allow_negative_numbers = true)]
    power: f32,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum NormalArg {
    Shading,
    Geometric,
    Mapped,
}

impl BakeArgs {
    /// One bake for each model; where there are several, into the folder that is the output.
    pub(crate) fn each(&self) -> Vec<Self> {
        let of = |model: &PathBuf| {
            let is_gltf = matches!(extension(model).as_str(), "glb" | "gltf");
            let name = model.file_name().map(PathBuf::from).unwrap_or_default();
            let name = if is_gltf { name } else { name.with_extension("png") };
            let output = self.output.as_ref().map(|folder| folder.join(name));
            Self { model: vec![model.clone()], output, ..self.clone() }
        };
        if self.model.len() < 2 { vec![self.clone()] } else { self.model.iter().map(of).collect() }
    }

    /// The model; empty where only options are asked for.
    pub(crate) fn model(&self) -> PathBuf {
        self.model.first().cloned().unwrap_or_default()
    }

    /// The output; empty where nothing is written.
    pub(crate) fn output(&self) -> PathBuf {
        self.output.clone().unwrap_or_default()
    }

    /// How large maps are to be.
    pub(crate) fn extent(&self) -> MapExtent {
        let (width, height) = self.size;
        self.density.map_or(MapExtent::Size(MapSize { width, height }), MapExtent::Density)
    }

    /// The option that says it.
    pub(crate) fn extent_option(&self) -> &'static str {
        if self.density.is_some() { "--density" } else { "--size" }
    }

    pub(crate) fn scope(&self) -> Scope {
        let ScopeArgs { occluders, receivers, self_only, ground, ignore_backfaces } = &self.scope;
        Scope {
            occluders: occluders.clone(),
            receivers: receivers.clone(),
            self_only: *self_only || self.shared,
            ground: *ground,
            backs: match ignore_backfaces {
                None => Backs::Block,
                Some(BacksArg::OneSided) => Backs::PassOneSided,
                Some(BacksArg::All) => Backs::Pass,
            },
        }
    }

    /// How bent directions are written, where they are wanted.
    pub(crate) fn bent(&self) -> Option<BentColours> {
        self.bent_normals.map(|bent| match bent {
            BentArg::World => BentColours::World,
            BentArg::Tangent => BentColours::Tangent,
            BentArg::TangentDx => BentColours::TangentDown,
        })
    }

    /// What is read of the model beside what occludes.
    pub(crate) fn extras(&self) -> Extras {
        let normal_maps = self.look.normal == NormalArg::Mapped;
        let bent = self.bent().is_some_and(|bent| bent.space() == BentSpace::Tangent);
        Extras { tangents: normal_maps || bent, normal_maps }
    }

    /// Which way the points of instances look; nothing where normal maps are wanted and there are none.
    pub(crate) fn facing(&self, geometry: &Geometry, receivers: &[u32]) -> Option<Facing> {
        let normals = match self.look.normal {
            NormalArg::Shading => Normals::Shading,
            NormalArg::Geometric => Normals::Geometric,
            NormalArg::Mapped => {
                let maps = NormalMaps::of(geometry, receivers);
                if maps.is_empty() {
                    return None;
                }
                Normals::Mapped(Arc::new(maps))
            }
        };
        Some(Facing { normals, inside: self.look.inside })
    }

    pub(crate) fn look(&self) -> Look {
        Look { intensity: self.look.intensity, power: self.look.power }
    }
}

/// What a name ends in, in small letters.
fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

fn parse_ground(text: &str) -> Result<Ground, String> {
    match text {
        "lowest" => Ok(Ground::Lowest),
        _ => text
            .parse()
            .ok()
            .filter(|y: &f32| y.is_finite())
            .map(Ground::At)
            .ok_or_else(|| "expected a height in world units, or nothing for the lowest point".into()),
    }
}

fn parse_look(text: &str) -> Result<f32, String> {
    let value = text.parse().ok().filter(|x: &f32| (0.0..=10.0).contains(x));
    value.ok_or_else(|| "expected a number from 0 to 10".into())
}

fn parse_density(text: &str) -> Result<f32, String> {
    let value = text.parse().ok().filter(|x: &f32| *x > 0.0 && x.is_finite());
    value.ok_or_else(|| "expected texels for each unit of length, more than 0".into())
}
