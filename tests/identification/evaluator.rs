use crate::tosses::{TRUTH, clean, noise, noisy, nuisances, plan, unknowns, world};
use hydroelastic::dynamics::Trajectory;
use hydroelastic::identification::{
    Checkpoint, Equations, Evaluated, Evaluator, Fit, Identification, IdentificationError,
    Measurement,
};
use nalgebra::vector;

/// Evaluator that simulates each measurement by itself, as a worker on another machine.
struct OneByOne<'a> {
    identification: &'a Identification,
    measurements: &'a [Measurement],
}

impl OneByOne<'_> {
    fn each<V>(
        &self,
        point: &Checkpoint,
        measurements: &[usize],
        value: impl Fn(&[Measurement], &Checkpoint) -> Evaluated<V>,
    ) -> Evaluated<V> {
        let one = |&index: &usize| {
            let point = Checkpoint {
                nuisances: vec![point.nuisances[index].clone()],
                ..point.clone()
            };
            let results = value(&self.measurements[index..=index], &point)?;
            Ok(results.into_iter().next().unwrap())
        };
        measurements.iter().map(one).collect()
    }
}

impl Evaluator for OneByOne<'_> {
    fn costs(&self, point: &Checkpoint, measurements: &[usize]) -> Evaluated<f64> {
        self.each(point, measurements, |measurements, point| {
            self.identification.costs(measurements, point)
        })
    }

    fn equations(&self, point: &Checkpoint, measurements: &[usize]) -> Evaluated<Equations> {
        let mut all = self.each(point, measurements, |measurements, point| {
            self.identification.equations(measurements, point)
        })?;
        for equations in all.iter_mut().flatten() {
            *equations = round_trip(equations);
        }
        Ok(all)
    }
}

/// Returns equations after a round trip through JSON. Without the feature `serde`, clones them.
fn round_trip(equations: &Equations) -> Equations {
    #[cfg(feature = "serde")]
    return serde_json::from_str(&serde_json::to_string(equations).unwrap()).unwrap();
    #[cfg(not(feature = "serde"))]
    return equations.clone();
}

/// Evaluator that returns an empty list or an error.
struct Broken {
    returns_empty: bool,
}

impl Evaluator for Broken {
    fn costs(&self, _: &Checkpoint, _: &[usize]) -> Evaluated<f64> {
        Ok(Vec::new())
    }

    fn equations(&self, _: &Checkpoint, _: &[usize]) -> Evaluated<Equations> {
        if self.returns_empty {
            return Ok(Vec::new());
        }
        Err(IdentificationError::Evaluation("no worker is left".into()))
    }
}

/// Returns the bits of the coordinates, the costs and the covariance of a fit.
fn bits(fit: &Fit) -> Vec<u64> {
    let Checkpoint {
        unknowns,
        nuisances,
        ..
    } = &fit.checkpoint;
    let costs = fit.measurements.iter().map(|measurement| measurement.cost);
    let numbers = unknowns.iter().chain(nuisances.iter().flatten()).copied();
    let numbers = numbers.chain(costs).chain(fit.covariance.iter().copied());
    numbers.chain([fit.cost]).map(f64::to_bits).collect()
}

#[test]
fn an_evaluator_and_the_threads_give_the_same_bits_and_errors() {
    let identification = Identification::new(&world([2e5, 0.5, 0.1]), &plan(), &unknowns());
    let identification = identification.unwrap().with_noise(noise());
    let identification = identification.with_nuisances(&nuisances()).unwrap();
    let identification = identification.with_horizons(&[0.15]).unwrap();
    let mut measurements = noisy(&clean(3), 2);
    let mut states = measurements[1].trajectory().states().to_vec();
    let pose = &mut states[0].bodies[0].pose;
    *pose = pose.with_translation(vector![0.0, 0.0, -1.0]);
    measurements[1] = Measurement::new("below", Trajectory::new(states).unwrap());
    let expected = identification.fit(&measurements).unwrap();
    let evaluator = OneByOne {
        identification: &identification,
        measurements: &measurements,
    };
    let start = identification.first_checkpoint(measurements.len());
    let fit = identification.resume_with(&measurements, start, &evaluator);
    let fit = fit.unwrap();
    assert_eq!(bits(&fit), bits(&expected));
    assert_eq!(fit.iterations, expected.iterations);
    for (measurement, expected) in fit.measurements.iter().zip(&expected.measurements) {
        assert_eq!(measurement.error, expected.error);
    }
    assert!(fit.measurements[1].error.is_some());
}

#[test]
fn errors_of_an_evaluator_end_a_fit() {
    let identification = Identification::new(&world(TRUTH), &plan(), &unknowns()).unwrap();
    let measurements = clean(1);
    let error = |returns_empty| {
        let start = identification.first_checkpoint(1);
        let evaluator = Broken { returns_empty };
        let fit = identification.resume_with(&measurements, start, &evaluator);
        fit.unwrap_err().to_string()
    };
    assert_eq!(error(false), "no worker is left");
    assert_eq!(error(true), "expected 1 equations, but found 0");
}
