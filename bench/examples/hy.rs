use conray::{AoSettings, Control, Method};
use conray_bench::{Bench, judged};
fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let (w, h) = args[0].split_once('x').unwrap();
    let size = (w.parse().unwrap(), h.parse().unwrap());
    let truth: u32 = args[1].parse().unwrap();
    let budgets: Vec<u32> = args[2].split(',').map(|b| b.parse().unwrap()).collect();
    let reps: usize = args[3].parse().unwrap();
    for name in &args[4..] {
        let mut bench = Bench::new(judged(name).unwrap(), &AoSettings::default(), size, truth).unwrap();
        for &rays in &budgets {
            let methods: &[Method] =
                if std::env::var("HO").is_ok() { &[Method::Hybrid] } else { &[Method::Rays, Method::Hybrid] };
            for &method in methods {
                let mut times = vec![];
                let mut rmses = vec![];
                let mut exp = 0.0;
                let mut bias = 0.0;
                for seed in 0..reps {
                    bench
                        .session
                        .set_plan(&AoSettings {
                            method,
                            rays: Some(rays),
                            seed: seed as u32,
                            ..AoSettings::default()
                        })
                        .unwrap();
                    let o = bench.session.run_target(&bench.target, Control::none()).unwrap();
                    times.push(o.seconds);
                    let n = bench.truth.len().max(1) as f64;
                    rmses.push(
                        (o.estimates
                            .iter()
                            .zip(&bench.truth)
                            .map(|(e, t)| f64::from(e.visibility - t).powi(2))
                            .sum::<f64>()
                            / n)
                            .sqrt(),
                    );
                    bias += o
                        .estimates
                        .iter()
                        .zip(&bench.truth)
                        .map(|(e, t)| f64::from(e.visibility - t))
                        .sum::<f64>()
                        / n
                        / reps as f64;
                    exp = o.expected_rmse;
                }
                times.sort_by(f64::total_cmp);
                let rmse = rmses.iter().sum::<f64>() / reps as f64;
                println!(
                    "{name:12} {method:6} {rays:5} rmse {rmse:.5} time {:.4} (min {:.4}) exp/true {:.2} bias {bias:.5}",
                    times[reps / 2],
                    times[0],
                    exp / rmse
                );
            }
        }
    }
}
