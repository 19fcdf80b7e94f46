//! Inputs of a contact computation: one set of poses, twists and material numbers, or a batch of n sets.

use crate::arrays::{Floats, Many, array, check_finite, copied, rows};
use crate::errors::value_error;
use crate::pair::Pair;
use crate::poses::{poses, twist_of};
use hydroelastic::contact::{ContactPair, SurfaceLaw};
use hydroelastic::nalgebra::SVector;
use hydroelastic::parallel;
use hydroelastic::spatial::Pose;
use pyo3::prelude::*;

/// Number of contacts in one task of a thread. Fast contacts take only a few µs.
const CHUNK: usize = 4;

/// Checked arguments of a call on a pair.
pub struct Inputs {
    poses: [Many<Pose>; 2],
    twists: [Many<[f64; 6]>; 2],
    moduli: Many<[f64; 2]>,
    law: Many<SurfaceLaw>,
    by_wrenches: Many<[f64; 12]>,
    is_moving: bool,
}

/// One contact to evaluate.
pub struct ContactItem<'s> {
    pub pair: ContactPair<'s>,
    /// Derivatives of a loss with respect to both wrenches.
    pub by_wrenches: SVector<f64, 12>,
    /// Index in the batch.
    pub index: usize,
}

/// Reads twists. The twist of a missing argument is zero.
fn twists(argument: Option<&Bound<'_, PyAny>>, name: &str) -> PyResult<Many<[f64; 6]>> {
    let Some(argument) = argument else {
        return Ok(Many::One([0.0; 6]));
    };
    rows(argument, name)?.mapped(name, |twist: &[f64; 6]| {
        if twist.iter().all(|number| number.is_finite()) {
            return Ok(*twist);
        }
        Err(value_error(format!(
            "a twist must be finite, but is {twist:?}"
        )))
    })
}

impl Inputs {
    /// Reads the arguments of a call on a pair. Without twists, bodies are at rest. `moduli` and `law` (dissipation and friction) replace
    /// those of the pair.
    pub fn of(
        pair: &Pair,
        [pose_a, pose_b]: [&Bound<'_, PyAny>; 2],
        [twist_a, twist_b]: [Option<&Bound<'_, PyAny>>; 2],
        moduli: Option<&Bound<'_, PyAny>>,
        law: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let law = match law {
            Some(law) => rows(law, "law")?,
            None => Many::One(pair.law.numbers()),
        };
        Ok(Self {
            poses: [poses(pose_a, "pose_a")?, poses(pose_b, "pose_b")?],
            twists: [twists(twist_a, "twist_a")?, twists(twist_b, "twist_b")?],
            moduli: match moduli {
                Some(moduli) => rows(moduli, "moduli")?,
                None => Many::One(pair.moduli_or_1()),
            },
            law: law.mapped("law", |numbers| pair.law.inner_with(*numbers))?,
            by_wrenches: Many::One([0.0; 12]),
            is_moving: twist_a.is_some() || twist_b.is_some(),
        })
    }

    /// Sets the pairs in motion even if no twist is given, because derivatives with respect to twists depend on the law.
    pub fn moving(self) -> Self {
        Self {
            is_moving: true,
            ..self
        }
    }

    /// Adds derivatives of a loss with respect to both wrenches.
    pub fn with_covectors(self, by_wrenches: &Bound<'_, PyAny>) -> PyResult<Self> {
        let by_wrenches =
            rows(by_wrenches, "by_wrenches")?.mapped("by_wrenches", |covector: &[f64; 12]| {
                check_finite(covector, "derivatives by wrenches")?;
                Ok(*covector)
            })?;
        Ok(Self {
            by_wrenches,
            ..self
        })
    }

    /// Number of contacts of a batch; `None` for a single contact.
    pub fn count(&self) -> PyResult<Option<usize>> {
        let [pose_a, pose_b] = &self.poses;
        let [twist_a, twist_b] = &self.twists;
        let counts = [
            ("pose_a", pose_a.count()),
            ("pose_b", pose_b.count()),
            ("twist_a", twist_a.count()),
            ("twist_b", twist_b.count()),
            ("moduli", self.moduli.count()),
            ("law", self.law.count()),
            ("by_wrenches", self.by_wrenches.count()),
        ];
        let mut present = counts
            .into_iter()
            .filter_map(|(name, count)| Some((name, count?)));
        let Some((first, expected)) = present.next() else {
            return Ok(None);
        };
        match present.find(|&(_, count)| count != expected) {
            None => Ok(Some(expected)),
            Some((name, count)) => Err(value_error(format!(
                "{first} is a batch of {expected}, but {name} one of {count}"
            ))),
        }
    }

    /// Creates the contact of an item.
    fn contact<'s>(&self, pair: &'s Pair, item: usize) -> PyResult<ContactItem<'s>> {
        let poses = self.poses.each_ref().map(|poses| *poses.at(item));
        let pair = pair.at(poses, *self.moduli.at(item))?;
        let twists = [0, 1].map(|side| twist_of(self.twists[side].at(item)));
        Ok(ContactItem {
            pair: if self.is_moving {
                pair.moving(*self.law.at(item), twists)
            } else {
                pair
            },
            by_wrenches: SVector::from(*self.by_wrenches.at(item)),
            index: item,
        })
    }

    /// Computes `width` numbers for each contact, without the GIL. All threads share a batch.
    pub fn compute(
        &self,
        py: Python<'_>,
        pair: &Pair,
        width: usize,
        write: impl Fn(&ContactItem<'_>, &mut [f64]) + Sync,
    ) -> PyResult<Results> {
        let count = self.count()?;
        let Some(length) = count else {
            let contact = self.contact(pair, 0)?;
            let mut numbers = vec![0.0; width];
            py.detach(|| write(&contact, &mut numbers));
            check_result(&numbers, None)?;
            return Ok(Results {
                numbers,
                width,
                count,
            });
        };
        let contacts = (0..length).map(|item| self.contact(pair, item));
        let contacts = contacts.collect::<PyResult<Vec<_>>>()?;
        let chunks: Vec<&[ContactItem<'_>]> = contacts.chunks(CHUNK).collect();
        let of_chunk = |chunk: &&[ContactItem<'_>]| {
            let mut numbers = vec![0.0; width * chunk.len()];
            for (contact, row) in chunk.iter().zip(numbers.chunks_mut(width.max(1))) {
                write(contact, row);
            }
            numbers
        };
        let numbers = py.detach(|| parallel::map(&chunks, of_chunk)).concat();
        for (item, numbers) in numbers.chunks(width.max(1)).enumerate() {
            check_result(numbers, Some(item))?;
        }
        Ok(Results {
            numbers,
            width,
            count,
        })
    }
}

/// Checks that the results of a contact are finite. `item` is its index in a batch.
fn check_result(numbers: &[f64], item: Option<usize>) -> PyResult<()> {
    if numbers.iter().all(|number| number.is_finite()) {
        return Ok(());
    }
    let item = item.map_or_else(String::new, |item| format!(" {item} of the batch"));
    Err(value_error(format!(
        "the result of contact{item} is not finite: a pose, a twist, a modulus, a number of the law or a derivative is too large"
    )))
}

/// Results of one contact or of each contact of a batch: the numbers of all result arrays, one array after another.
pub struct Results {
    numbers: Vec<f64>,
    width: usize,
    count: Option<usize>,
}

impl Results {
    /// Creates a result array of a shape whose numbers start at `first` in each contact. A batch has an additional first axis.
    pub fn array<'py>(
        &self,
        py: Python<'py>,
        first: usize,
        shape: &[usize],
    ) -> PyResult<Floats<'py>> {
        let range = first..first + shape.iter().product::<usize>();
        let Some(count) = self.count else {
            return copied(py, &self.numbers[range], shape);
        };
        let rows = (0..count).map(|item| &self.numbers[item * self.width..]);
        let values: Vec<f64> = rows.flat_map(|row| &row[range.clone()]).copied().collect();
        array(py, values, &[&[count], shape].concat())
    }
}
