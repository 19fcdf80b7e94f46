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
    /// Mass properties of a link of a mechanism. The mass can be zero, and the inertia can be zero or the inertia of no solid, as in many
    /// URDF files. The total inertia that a joint moves must be positive.
    Link(MassProperties),
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
            Self::Properties(_) | Self::Link(_) => return self.without_volume(body),
        };
        check_mass_number(body, quantity, value)?;
        check_mass_number(body, "mass", density * volume)?;
        let properties = at_density(density).map_err(|_| WorldError::Mass {
            body: body.to_owned(),
            quantity: "inertia",
            value: f64::INFINITY,
        })?;
        check_center(body, &properties.center_of_mass)?;
        check_moments(body, &properties)?;
        Ok(properties)
    }

    /// Mass properties that do not depend on a shape.
    pub(super) fn without_volume(&self, body: &str) -> Result<MassProperties, WorldError> {
        match self {
            Self::Properties(properties) => {
                check_mass_number(body, "mass", properties.mass)?;
                check_center(body, &properties.center_of_mass)?;
                check_tensor(body, properties)?;
                check_moments(body, properties)?;
                Ok(*properties)
            }
            Self::Link(properties) => {
                let MassProperties { mass, inertia, .. } = *properties;
                if mass != 0.0 {
                    check_mass_number(body, "mass", mass)?;
                } else if inertia.amax() > 0.0 {
                    return Err(WorldError::MasslessInertia(body.to_owned()));
                }
                check_center(body, &properties.center_of_mass)?;
                check_tensor(body, properties)?;
                Ok(*properties)
            }
            Self::Density(_) | Self::Total(_) => Err(WorldError::NoVolume(body.to_owned())),
        }
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

/// Checks that an inertia matrix is finite and symmetric.
fn check_tensor(
    body: &str,
    MassProperties { inertia, .. }: &MassProperties,
) -> Result<(), WorldError> {
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
    Ok(())
}

/// Checks that the principal moments are those of a solid.
fn check_moments(
    body: &str,
    MassProperties { mass, inertia, .. }: &MassProperties,
) -> Result<(), WorldError> {
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

/// Checks that a body's mass, density, moment or radius of gyration is positive and finite.
pub(crate) fn check_mass_number(
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
