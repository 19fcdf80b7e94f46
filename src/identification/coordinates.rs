use super::error::{check_count, check_scale};
use super::unknown::Scale;
use super::{IdentificationError, Nuisance, Unknown};
use crate::gradient::{Experiment, Parameter};
use crate::spatial::left_jacobian;
use nalgebra::{DMatrix, DVector, Vector3};

/// Map from the coordinates of unknowns or of nuisances to changes of parameters.
#[derive(Debug, Clone, Default)]
pub(super) struct Coordinates {
    /// Changed parameters, each once.
    pub parameters: Vec<Parameter>,
    /// Values of the numbers of the parameters in the world of the template. Zero for orientations and for nuisances, whose values are
    /// changes.
    references: Vec<f64>,
    entries: Vec<Coordinate>,
}

/// Coordinate of an unknown, or of a component of a nuisance.
#[derive(Debug, Clone)]
struct Coordinate {
    name: String,
    scale: Scale,
    /// Coordinate of the initial guess.
    start: f64,
    /// Mean and standard deviation of the prior.
    prior: Option<[f64; 2]>,
    /// Indices of the numbers that have the value of the coordinate.
    numbers: Vec<usize>,
}

impl Coordinates {
    /// Coordinates of unknowns, with the values of the template as the initial guess.
    ///
    /// # Errors
    /// - If the world does not have a parameter or a component.
    /// - If a guess or the mean of a prior is out of range, or the deviation of a prior is not between 1e-150 and 1e150.
    /// - If two unknowns set the same number.
    pub fn of_unknowns(
        unknowns: &[Unknown],
        template: &Experiment,
    ) -> Result<Self, IdentificationError> {
        let parameters = unknowns.iter().flat_map(|unknown| &unknown.numbers);
        let mut all = Self::of_parameters(parameters.map(|(parameter, _)| parameter));
        all.references = template.values(&all.parameters)?.as_slice().to_vec();
        all.zero_orientations();
        for unknown in unknowns {
            let coordinate = all.of_unknown(unknown)?;
            all.check_distinct(&coordinate)?;
            all.entries.push(coordinate);
        }
        Ok(all)
    }

    /// Coordinates of nuisances: changes with the mean zero.
    ///
    /// # Errors
    /// - If the world does not have a parameter or a component, or a deviation is not between 1e-150 and 1e150.
    /// - If two nuisances change the same number.
    pub fn of_nuisances(
        nuisances: &[Nuisance],
        template: &Experiment,
    ) -> Result<Self, IdentificationError> {
        let mut all = Self::of_parameters(nuisances.iter().map(|nuisance| &nuisance.parameter));
        // Checks that the world has the parameters.
        template.values(&all.parameters)?;
        for nuisance in nuisances {
            let parameter = &nuisance.parameter;
            check_scale(format!("the deviation of {parameter}"), nuisance.deviation)?;
            let components = match nuisance.component {
                Some(component) => component..component + 1,
                None => 0..parameter.dimension(),
            };
            for component in components {
                all.add_nuisance(nuisance, component)?;
            }
        }
        Ok(all)
    }

    fn add_nuisance(
        &mut self,
        Nuisance {
            parameter,
            deviation,
            ..
        }: &Nuisance,
        component: usize,
    ) -> Result<(), IdentificationError> {
        let number = self.number(parameter, component)?;
        if self.entries.iter().any(|entry| entry.numbers == [number]) {
            let parameter = parameter.to_string();
            return Err(IdentificationError::DuplicateNuisance {
                parameter,
                component,
            });
        }
        self.entries.push(Coordinate {
            name: format!("{parameter} {component}"),
            scale: Scale::Linear,
            start: 0.0,
            prior: Some([0.0, *deviation]),
            numbers: vec![number],
        });
        Ok(())
    }

    /// Distinct parameters, with references of zero and without coordinates.
    fn of_parameters<'p>(parameters: impl Iterator<Item = &'p Parameter>) -> Self {
        let mut all = Self::default();
        for parameter in parameters {
            if !all.parameters.contains(parameter) {
                all.parameters.push(parameter.clone());
            }
        }
        let count = all.parameters.iter().map(Parameter::dimension).sum();
        all.references = vec![0.0; count];
        all
    }

    /// Sets the references of orientations to zero, because their values are changes.
    fn zero_orientations(&mut self) {
        let mut first = 0;
        for parameter in &self.parameters {
            let numbers = first..first + parameter.dimension();
            first = numbers.end;
            if parameter.is_orientation() {
                self.references[numbers].fill(0.0);
            }
        }
    }

    fn of_unknown(&self, unknown: &Unknown) -> Result<Coordinate, IdentificationError> {
        let numbers = unknown.numbers.iter();
        let numbers = numbers.map(|(parameter, component)| self.number(parameter, *component));
        let numbers = numbers.collect::<Result<Vec<_>, _>>()?;
        let (scale, name) = (unknown.scale, unknown.name.clone());
        let prior = match unknown.prior {
            None => None,
            Some((value, deviation)) => {
                check_scale(format!("the deviation of the prior of {name:?}"), deviation)?;
                Some([
                    scale.checked(("the mean of the prior", &name), value)?,
                    deviation,
                ])
            }
        };
        let start = scale.checked(("the initial guess", &name), self.references[numbers[0]])?;
        Ok(Coordinate {
            name,
            scale,
            start,
            prior,
            numbers,
        })
    }

    /// Index of a component of a parameter among all numbers.
    fn number(&self, wanted: &Parameter, component: usize) -> Result<usize, IdentificationError> {
        let dimension = wanted.dimension();
        if component >= dimension {
            let parameter = wanted.to_string();
            return Err(IdentificationError::NoComponent {
                parameter,
                component,
                dimension,
            });
        }
        let before = self
            .parameters
            .iter()
            .take_while(|&parameter| parameter != wanted);
        Ok(before.map(Parameter::dimension).sum::<usize>() + component)
    }

    /// Checks that no earlier coordinate sets a number of a coordinate.
    fn check_distinct(&self, coordinate: &Coordinate) -> Result<(), IdentificationError> {
        let shares = |earlier: &&Coordinate| {
            let mut numbers = earlier.numbers.iter();
            numbers.any(|number| coordinate.numbers.contains(number))
        };
        match self.entries.iter().find(shares) {
            None => Ok(()),
            Some(earlier) => Err(IdentificationError::DuplicateUnknown {
                unknowns: [&earlier.name, &coordinate.name].map(Clone::clone),
            }),
        }
    }

    /// Number of coordinates.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Names of the coordinates.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries
            .iter()
            .map(|coordinate| coordinate.name.as_str())
    }

    /// Coordinates of the initial guess.
    pub fn start(&self) -> DVector<f64> {
        let starts = self.entries.iter().map(|coordinate| coordinate.start);
        DVector::from_iterator(self.len(), starts)
    }

    /// Values at coordinates.
    pub fn values(&self, at: &DVector<f64>) -> Vec<f64> {
        let pairs = self.entries.iter().zip(at.iter());
        pairs
            .map(|(coordinate, &at)| coordinate.scale.value(at)[0])
            .collect()
    }

    /// Coordinates of values.
    ///
    /// # Errors
    /// If the number of values is wrong, or a value is out of range.
    pub fn of_values(&self, values: &[f64]) -> Result<DVector<f64>, IdentificationError> {
        check_count("values", values.len(), self.len())?;
        let pairs = self.entries.iter().zip(values);
        let coordinates = pairs
            .map(|(entry, &value)| entry.scale.checked(("the given value", &entry.name), value));
        Ok(DVector::from_vec(coordinates.collect::<Result<_, _>>()?))
    }

    /// Mean and standard deviation of the prior of each coordinate.
    pub fn priors(&self) -> impl Iterator<Item = Option<[f64; 2]>> {
        self.entries.iter().map(|coordinate| coordinate.prior)
    }

    /// Changes of the numbers of the parameters from the template.
    pub fn changes(&self, at: &DVector<f64>) -> Vec<f64> {
        let mut changes = vec![0.0; self.references.len()];
        for (coordinate, value) in self.entries.iter().zip(self.values(at)) {
            for &number in &coordinate.numbers {
                changes[number] = value - self.references[number];
            }
        }
        changes
    }

    /// Derivatives of small changes of the parameters with respect to the coordinates: a row for each number of a parameter.
    ///
    /// For an orientation, exp\[θ + δ\] ≈ exp\[J(θ)·δ\]·exp\[θ\] to first order in δ, with the change θ and the left Jacobian J.
    pub fn jacobian(&self, at: &DVector<f64>) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(self.references.len(), self.len());
        for (column, coordinate) in self.entries.iter().enumerate() {
            let [_, slope] = coordinate.scale.value(at[column]);
            for &number in &coordinate.numbers {
                jacobian[(number, column)] = slope;
            }
        }
        let changes = self.changes(at);
        let mut first = 0;
        for parameter in &self.parameters {
            if parameter.is_orientation() {
                let change = Vector3::from_column_slice(&changes[first..first + 3]);
                let turned = left_jacobian(&change) * jacobian.rows(first, 3);
                jacobian.rows_mut(first, 3).copy_from(&turned);
            }
            first += parameter.dimension();
        }
        jacobian
    }
}
