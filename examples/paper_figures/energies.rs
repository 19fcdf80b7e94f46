//! Energies of a rollout over time.

use super::chart::{self, Axes};
use super::names::{self, Sample};
use super::style::{BLUE, GREEN, INK, ORANGE};
use super::{Answer, Area};
use hydroelastic::dynamics::{Diagnostics, State, World};
use plotters::prelude::*;
use std::ops::Range;

/// Diagnostics of some states, and their times (s).
pub struct Energies {
    times: Vec<f64>,
    reports: Vec<Diagnostics>,
}

impl Energies {
    /// Computes the diagnostics of states of a world.
    pub fn of<'a>(world: &World, states: impl Iterator<Item = &'a State> + Clone) -> Self {
        Self {
            times: states.clone().map(|state| state.time).collect(),
            reports: states
                .map(|state| world.diagnostics(state).expect("a state of this world"))
                .collect(),
        }
    }

    /// Returns kinetic, gravitational and contact energy in total (J). Gravitational energy is relative to its minimum.
    pub fn total(&self) -> Vec<f64> {
        let lowest = self.lowest();
        let reports = self.reports.iter();
        reports
            .map(|report| report.total_energy() - lowest)
            .collect()
    }

    fn lowest(&self) -> f64 {
        let weights = self
            .reports
            .iter()
            .map(|report| report.gravitational_energy);
        weights.fold(f64::INFINITY, f64::min)
    }

    /// Draws one curve per kind of energy over these times (s), with names in an area of `right` pixels on the right.
    pub fn draw(&self, area: &Area, times: Range<f64>, right: u32) -> Answer {
        let (lowest, total) = (self.lowest(), self.total());
        let highest = total.iter().copied().fold(0.0, f64::max);
        let axes = Axes {
            title: "Energies",
            x: ("time (s)", times),
            y: ("energy (J)", 0.0..1.1 * highest),
            right,
        };
        let mut chart = chart::on(area, axes)?;
        let of_kind = |energy: fn(&Diagnostics) -> f64, zero: f64| -> Vec<f64> {
            self.reports
                .iter()
                .map(|report| energy(report) - zero)
                .collect()
        };
        let curves = [
            (
                "gravitational",
                BLUE,
                of_kind(|report| report.gravitational_energy, lowest),
            ),
            (
                "kinetic",
                ORANGE,
                of_kind(|report| report.kinetic_energy, 0.0),
            ),
            (
                "contact",
                GREEN,
                of_kind(|report| report.contact_energy, 0.0),
            ),
            ("total", INK, total),
        ];
        for (_, color, energies) in &curves {
            let points = self.times.iter().copied().zip(energies.iter().copied());
            chart::line(
                &mut chart,
                color.stroke_width(3),
                &points.collect::<Vec<_>>(),
            )?;
        }
        let named = curves.map(|(name, color, _)| (Sample::Line(color.stroke_width(3)), name));
        names::draw(area, chart::beside(area, right)?, &named)
    }
}
