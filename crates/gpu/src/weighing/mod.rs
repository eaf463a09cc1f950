//! Weighing of method `hybrid` on a device: the steps of crates/estimate/src/hybrid/weigh.rs, one kernel each.
//!
//! ```text
//! places once, tallies each time
//!    weigh_units, weigh_begin    how a unit errs on average; marks of places
//!    weigh_cells                 1 to 4: cells of 2 to 16 places a side
//!    weigh_guess                 0 to 4: what cells say; 0 to 3 again where no size said enough
//!    weigh_sums 2, 4             what rays tell of guesses, by cells
//!    weigh_everywhere, weigh     errors on average, then of each place -> known
//! ```
//!
//! What is asked and what is left out is decided on the device as the CPU does, so that one submission does for all.

mod structs;

use crate::{
    Gpu, GpuError,
    kernel::{Bound, GROUP, Kernel, Steps, bind, layout},
};
use bytemuck::bytes_of;
use conray_estimate::{BackendError, HybridConstants, Known, PlaceTally, PlaceWeigher, Places, RayErrors};
use std::sync::{Mutex, PoisonError};
pub(crate) use structs::{
    Counts, GpuCell, GpuPlace, GpuPlaceTally, GpuSums, LayerUniform, WeighingState, WeighingUniform,
};

/// Sizes of cells, places among them.
const SIZES: u32 = 5;
/// Sizes over whose cells errors are looked at; of the first one workgroups add theirs up.
const ERROR_SIZES: [u32; 2] = [2, 4];
/// Places that a thread of weigh_units sums.
const EACH: u32 = 16;

/// The kernels.
pub(crate) struct WeighKernels {
    /// Of what all of them read.
    pub(crate) shared: wgpu::BindGroupLayout,
    units: Kernel,
    begin: Kernel,
    cells: Kernel,
    guess: Kernel,
    sums: Kernel,
    everywhere: Kernel,
    weigh: Kernel,
}

impl WeighKernels {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        use Bound::{Read, Uniform, Write};
        let shared = layout(gpu, "places and tallies", &[Uniform, Read, Read]);
        let kernel = |name, asked: &[Bound]| Kernel::new(gpu, name, &shared, asked);
        Ok(Self {
            units: kernel("weigh_units", &[Write, Write])?,
            begin: kernel("weigh_begin", &[Read, Write, Write])?,
            cells: kernel("weigh_cells", &[Uniform, Write, Write])?,
            guess: kernel("weigh_guess", &[Uniform, Read, Write, Write, Write, Read, Write])?,
            sums: kernel("weigh_sums", &[Uniform, Read, Read, Read, Write, Write])?,
            everywhere: kernel("weigh_everywhere", &[Read, Read, Write])?,
            weigh: kernel("weigh", &[Read, Read, Read, Read, Read, Write])?,
            shared,
        })
    }
}

/// Weighs some places, on behalf of who keeps the device.
pub(crate) struct Weigher<'a> {
    gpu: &'a Gpu,
    kernels: &'a WeighKernels,
    work: Weighing,
    /// One weighing at a time: they share the buffers.
    turn: Mutex<()>,
}

/// Room for weighing some places.
pub(crate) struct Weighing {
    uniform: WeighingUniform,
    /// What all kernels read.
    pub(crate) shared: wgpu::BindGroup,
    pub(crate) buffers: Buffers,
}

pub(crate) struct Buffers {
    uniform: wgpu::Buffer,
    pub(crate) places: wgpu::Buffer,
    pub(crate) tallies: wgpu::Buffer,
    marks: wgpu::Buffer,
    unit_parts: wgpu::Buffer,
    state: wgpu::Buffer,
    counts: wgpu::Buffer,
    cells: wgpu::Buffer,
    heads: wgpu::Buffer,
    told: wgpu::Buffer,
    sums: wgpu::Buffer,
    sum_parts: wgpu::Buffer,
    pub(crate) known: wgpu::Buffer,
    /// Of each size, then of each second look.
    layers: [Vec<wgpu::Buffer>; 2],
}

/// Cells of a size.
fn cells_of(places: &WeighingUniform, size: u32) -> u32 {
    places.width.div_ceil(1 << size) * places.height.div_ceil(1 << size)
}

fn count_of(places: &WeighingUniform) -> u32 {
    places.stride * places.height
}

impl Weighing {
    /// For places that are written later.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], with the numbers, or a device that fails.
    pub(crate) fn new(gpu: &Gpu, kernels: &WeighKernels, uniform: WeighingUniform) -> Result<Self, GpuError> {
        let buffers = Buffers::new(gpu, &uniform)?;
        let shared = bind(gpu, &kernels.shared, &[&buffers.uniform, &buffers.places, &buffers.tallies]);
        Ok(Self { uniform, shared, buffers })
    }

    /// Says how the rays err that the next steps weigh.
    pub(crate) fn set_rays(&self, gpu: &Gpu, rays: &RayErrors) -> Result<(), GpuError> {
        gpu.write(&self.buffers.uniform, &[self.uniform.with_rays(rays)])
    }

    /// All that is done to weigh what the tallies hold by then.
    pub(crate) fn add_to(&self, steps: &mut Steps<'_>, kernels: &WeighKernels) -> Result<(), GpuError> {
        let Self { uniform, shared, buffers: b } = self;
        let count = count_of(uniform);
        let mut step = |kernel: &Kernel, asked: &[&wgpu::Buffer], threads: u32| {
            steps.add(kernel, shared, asked, threads.div_ceil(GROUP))
        };
        step(&kernels.units, &[&b.marks, &b.unit_parts], count.div_ceil(EACH))?;
        step(&kernels.begin, &[&b.unit_parts, &b.state, &b.counts], 1)?;
        let [first, again] = &b.layers;
        for size in 1..SIZES {
            let layer = &first[size as usize];
            step(&kernels.cells, &[layer, &b.cells, &b.marks], cells_of(uniform, size))?;
        }
        for layer in first.iter().chain(again) {
            let asked = [layer, &b.cells, &b.marks, &b.heads, &b.told, &b.state, &b.counts];
            step(&kernels.guess, &asked, count)?;
        }
        for size in ERROR_SIZES {
            let asked = [&first[size as usize], &b.marks, &b.told, &b.counts, &b.sums, &b.sum_parts];
            step(&kernels.sums, &asked, cells_of(uniform, size))?;
        }
        step(&kernels.everywhere, &[&b.sum_parts, &b.counts, &b.state], 1)?;
        step(&kernels.weigh, &[&b.cells, &b.heads, &b.told, &b.sums, &b.state, &b.known], count)
    }
}

impl<'a> Weigher<'a> {
    /// Uploads what is known of places without a ray; nothing where one of the buffers would be too large for the adapter.
    pub(crate) fn new(
        gpu: &'a Gpu,
        kernels: &'a WeighKernels,
        constants: &HybridConstants,
        places: &Places<'_>,
    ) -> Result<Option<Self>, GpuError> {
        let work = match Weighing::new(gpu, kernels, WeighingUniform::new(constants, places)) {
            Err(GpuError::TooLarge { .. }) => return Ok(None),
            made => made?,
        };
        gpu.write(&work.buffers.places, &GpuPlace::all(places))?;
        Ok(Some(Self { gpu, kernels, work, turn: Mutex::new(()) }))
    }

    fn weighed(&self, tallies: &[PlaceTally], rays: &RayErrors) -> Result<Known, GpuError> {
        let _turn = self.turn.lock().unwrap_or_else(PoisonError::into_inner);
        let packed: Vec<GpuPlaceTally> = tallies.iter().map(GpuPlaceTally::of).collect();
        let (gpu, buffers) = (self.gpu, &self.work.buffers);
        self.work.set_rays(gpu, rays)?;
        gpu.write(&buffers.tallies, &packed)?;
        let mut steps = Steps::new(gpu);
        self.work.add_to(&mut steps, self.kernels)?;
        steps.finish()?;
        let state: Vec<WeighingState> = gpu.read(&buffers.state, 1)?;
        let known: Vec<[f32; 4]> = gpu.read(&buffers.known, tallies.len())?;
        let column = |k: usize| known.iter().map(|known| known[k]).collect();
        Ok(Known {
            value: column(0),
            error2: column(1),
            guess_error2: column(2),
            unit_variance: column(3),
            unit: state[0].unit,
        })
    }
}

impl PlaceWeigher for Weigher<'_> {
    fn weigh(&self, tallies: &[PlaceTally], rays: &RayErrors) -> Result<Known, BackendError> {
        self.weighed(tallies, rays).map_err(|e| BackendError::Device(e.to_string()))
    }
}

impl Buffers {
    fn new(gpu: &Gpu, uniform: &WeighingUniform) -> Result<Self, GpuError> {
        let count = count_of(uniform) as usize;
        let unit_parts = (count as u32).div_ceil(EACH * GROUP) as usize;
        let cells: u32 = (1..SIZES).map(|size| cells_of(uniform, size)).sum();
        let sums: u32 = ERROR_SIZES.iter().map(|&size| cells_of(uniform, size)).sum();
        let sum_parts = cells_of(uniform, ERROR_SIZES[0]).div_ceil(GROUP) as usize;
        let of_sizes = SIZES as usize * count;
        let layer = |size, again| {
            let layer = LayerUniform { size, again, pad_a: 0, pad_b: 0 };
            gpu.buffer("size of cells", bytes_of(&layer), wgpu::BufferUsages::UNIFORM)
        };
        Ok(Self {
            uniform: gpu.buffer("constants", bytes_of(uniform), wgpu::BufferUsages::UNIFORM)?,
            places: gpu.room::<GpuPlace>("places", count)?,
            tallies: gpu.room::<GpuPlaceTally>("tallies of places", count)?,
            marks: gpu.answers::<u32>("marks of places", count)?,
            unit_parts: gpu.answers::<[f32; 2]>("parts of a sum", unit_parts)?,
            state: gpu.answers::<WeighingState>("what holds everywhere", 1)?,
            counts: gpu.answers::<Counts>("counts", 1)?,
            cells: gpu.answers::<GpuCell>("cells", cells as usize)?,
            heads: gpu.answers::<[f32; 2]>("guesses", of_sizes)?,
            told: gpu.answers::<[f32; 2]>("what rays tell of guesses", of_sizes)?,
            sums: gpu.answers::<GpuSums>("sums over cells", sums as usize)?,
            sum_parts: gpu.answers::<GpuSums>("parts of sums", sum_parts)?,
            known: gpu.answers::<[f32; 4]>("what is known of places", count)?,
            layers: [
                (0..SIZES).map(|size| layer(size, 0)).collect::<Result<_, _>>()?,
                (0..SIZES - 1).map(|size| layer(size, 1)).collect::<Result<_, _>>()?,
            ],
        })
    }
}
