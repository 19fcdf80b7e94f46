use super::WorldError;
use super::inertia::PrincipalInertia;
use crate::mesh::DensityError;
use crate::spatial::MassProperties;
use nalgebra::Vector3;

/// Tolerance of the asymmetry of an inertia matrix, relative to its largest entry. Rotations of the
/// matrix cause an asymmetry of this size.
const SYMMETRY: f64 = 1e-9;

/// Mass of a dynamic body.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Mass {
    /// Uniform density (kg/m³).
    Density(f64),
    /// Total mass (kg), distributed uniformly over the volume.
    Total(f64),
    /// Explicit mass, center of mass and inertia.
    Properties(MassProperties),
}

impl Mass {
    /// Mass properties of a body with this volume (m³), from its mass properties at a density (kg/m³).
    pub(super) fn properties(
        &self,
        body: &str,
        volume: f64,
        at_density: impl Fn(f64) -> Result<MassProperties, DensityError>,
    ) -> Result<MassProperties, WorldError> {
        let (quantity, value, density) = match *self {
            Self::Density(density) => ("density", density, density),
            Self::Total(mass) => ("mass", mass, mass / volume),
            Self::Properties(properties) => ("mass", properties.mass, properties.mass / volume),
        };
        check_mass_number(body, quantity, value)?;
        check_mass_number(body, "mass", density * volume)?;
        let properties = match *self {
            Self::Properties(properties) => properties,
            Self::Density(_) | Self::Total(_) => at_density(density).map_err(|_| {
                let (body, value) = (body.to_owned(), f64::INFINITY);
                let quantity = "inertia";
                WorldError::Mass {
                    body,
                    quantity,
                    value,
                }
            })?,
        };
        check_center(body, &properties.center_of_mass)?;
        check_inertia(body, &properties)?;
        Ok(properties)
    }
}

fn check_center(body: &str, center_of_mass: &Vector3<f64>) -> Result<(), WorldError> {
    match center_of_mass.iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(&value) => Err(WorldError::CenterOfMass {
            body: body.to_owned(),
            value,
        }),
    }
}

fn check_inertia(body: &str, properties: &MassProperties) -> Result<(), WorldError> {
    let MassProperties { mass, inertia, .. } = properties;
    if let Some(&value) = inertia.iter().find(|value| !value.is_finite()) {
        check_mass_number(body, "inertia", value)?;
    }
    let difference = (inertia - inertia.transpose()).amax();
    if difference > SYMMETRY * inertia.amax() {
        return Err(WorldError::AsymmetricInertia {
            body: body.to_owned(),
            difference,
        });
    }
    let principal = PrincipalInertia::of(inertia / *mass);
    let [smallest, middle, largest] = principal.moments.into();
    check_mass_number(
        body,
        "smallest principal moment of inertia",
        smallest * mass,
    )?;
    if principal.is_of_solid() {
        return Ok(());
    }
    Err(WorldError::ImpossibleInertia {
        body: body.to_owned(),
        largest: largest * mass,
        others: (smallest + middle) * mass,
    })
}

/// Checks that a body's mass, density or moment is positive and finite.
pub(super) fn check_mass_number(
    body: &str,
    quantity: &'static str,
    value: f64,
) -> Result<(), WorldError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(WorldError::Mass {
        body: body.to_owned(),
        quantity,
        value,
    })
}
