//! `conray bake` to vertices.

use super::{
    job,
    output::{Output, tell_lacks},
    preview::FIRST_RAYS,
};
use crate::{
    args::BakeArgs,
    explain,
    failure::Failure,
    render::{observed, stop_if},
    report::{self, Reporter},
};
use conray::{Budget, Control, Session, Work, scene::Origin, target::Target};
use conray_bake::{
    Apart, Facing, Memory, Origins, Slots, VertexBake, VertexTarget, bake_vertices, objects, write_obj,
    write_ply, write_vertex_model,
};
use serde_json::json;
use std::{path::PathBuf, sync::atomic::AtomicBool};

/// What is baked.
pub(super) struct Of<'a> {
    pub(super) name: &'a str,
    pub(super) args: &'a BakeArgs,
    pub(super) session: &'a Session,
    pub(super) apart: &'a [Apart],
    pub(super) receivers: &'a [u32],
    pub(super) facing: &'a Facing,
    pub(super) origins: &'a [Origin],
    pub(super) vertices: &'a [&'a [u32]],
}

pub(super) fn run(
    of: &Of<'_>,
    output: Option<Output>,
    interrupted: &AtomicBool,
    reporter: &Reporter,
) -> Result<(), Failure> {
    let Of { name, args, session, apart, facing, .. } = *of;
    let slots = Slots::of(session, of.receivers, &objects(session.geometry(), of.origins));
    let target = VertexTarget::new(session, slots, &args.vertex.settings(), facing)?;
    let limit = args.ao.settings().max_memory;
    let memory = Memory::of_points(
        target.points().len() as u64,
        session.memory_bytes() + facing.memory_bytes(),
        limit,
    )
    .map_err(|needed| {
        Failure::Request(format!(
            "--max-memory: the points need {needed} bytes; allow more, or choose fewer --samples-per-triangle"
        ))
    })?;
    if args.dry_run {
        return plan(of, &target, memory, reporter);
    }
    stop_if(interrupted, "before anything was estimated; no file was written")?;
    let bake = |budget, control: Control<'_>, state| {
        Ok::<_, Failure>(bake_vertices(session, apart, &target, facing, budget, control, state)?)
    };
    if let Some(preview) = &args.preview {
        let first = bake(Budget::rays(FIRST_RAYS), Control::none(), None)?;
        write_ply(preview, session.geometry(), target.slots(), &first.values)?;
    }
    let mut baked = observed(interrupted, reporter, |control| {
        bake(session.plan().budget, control, args.state.as_deref())
    })?;
    let Some(work) = Work::of_parts(&baked.parts).filter(|work| work.points > 0) else {
        return Err(Failure::Input(format!("{}: no surface has an area", args.model().display())));
    };
    explain::stop_if_nothing(&work)?;
    let visibility = &baked.values.visibility;
    let mean = visibility.iter().map(|&value| f64::from(value)).sum::<f64>() / visibility.len() as f64;
    if let Some(preview) = &args.preview {
        write_ply(preview, session.geometry(), target.slots(), &baked.values)?;
    }
    let look = args.look();
    baked.values.visibility.iter_mut().for_each(|value| *value = look.of(*value));
    let files = write(of, &target, &baked, output, reporter)?;
    let missed = explain::missed(session.plan(), &work);
    let mut lines = vec![
        format!(
            "{name}: {} triangles, {} values, {} points, AO distance {}",
            session.geometry().triangle_count(),
            baked.values.visibility.len(),
            work.points,
            session.plan().distance
        ),
        format!(
            "mean visibility {mean:.4}, expected error of a point {:.4}, values off the surface by {:.4}",
            work.expected_rmse, baked.values.misfit
        ),
    ];
    if baked.buried > 0 {
        lines.push(format!("{} points lie inside other geometry and count for nothing", baked.buried));
    }
    lines.extend(report::work_lines(&args.ao.settings(), session.report(), &work));
    let shown: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
    lines.push(format!("wrote {}", shown.join(", ")));
    lines.extend(missed.clone());
    if args.ao.explain {
        baked.parts.iter().for_each(|part| lines.extend(explain::lines(session.plan(), part)));
    }
    let mut facts = report::work_json(&args.ao.settings(), session.report(), &work);
    facts["model"] = json!(name);
    facts["values"] = json!(baked.values.visibility.len());
    facts["misfit"] = json!(baked.values.misfit);
    facts["buried"] = json!(baked.buried);
    facts["mean_visibility"] = json!(mean);
    facts["files"] = json!(files);
    facts["job"] = job::given();
    reporter.summary(&lines, facts);
    stop_if(interrupted, "what was done by then has been written")?;
    explain::stop_if_failed(&work)?;
    explain::check(args.ao.strict, missed)
}

fn write(
    of: &Of<'_>,
    target: &VertexTarget,
    baked: &VertexBake,
    output: Option<Output>,
    reporter: &Reporter,
) -> Result<Vec<PathBuf>, Failure> {
    let (to, geometry, slots) = (of.args.output(), of.session.geometry(), target.slots());
    match output {
        Some(Output::Model(document)) => {
            let origins = Origins { instances: of.origins, vertices: of.vertices };
            let attribute = of.args.vertex.attribute();
            let written = write_vertex_model(
                &to,
                &of.args.model(),
                document,
                &origins,
                slots,
                &baked.values,
                attribute,
            )
            .map_err(|e| Failure::Work(format!("{}: {e}", to.display())))?;
            tell_lacks(&written, reporter);
            return Ok(written.files);
        }
        Some(Output::Ply) => write_ply(&to, geometry, slots, &baked.values)?,
        Some(Output::Obj) => write_obj(&to, geometry, slots, &baked.values)?,
        Some(Output::Png | Output::Exr) | None => return Ok(Vec::new()),
    }
    Ok(vec![to])
}

/// `--dry-run`: how much there is to do.
fn plan(of: &Of<'_>, target: &VertexTarget, memory: u64, reporter: &Reporter) -> Result<(), Failure> {
    let (points, values) = (target.points().len(), target.slots().count());
    let lines = [
        format!("{}: {values} values, {points} points, AO distance {}", of.name, of.session.plan().distance),
        format!("memory: about {}", report::bytes(memory)),
        "nothing was written".into(),
    ];
    let facts = json!({ "model": of.name, "values": values, "points": points, "memory_bytes": memory });
    reporter.summary(&lines, facts);
    Ok(())
}
