//! Closed forms of impacts.

/// Returns the speed (m/s) after an impact with the dissipation d (s/m) of Hunt and Crossley, from the speed before the impact. The speed
/// does not depend on how the elastic force grows with depth. With G(v) = v/d − ln(1 + dv)/d², the speed v′ after the impact solves G(−v′)
/// = G(v).
pub fn rebound(speed: f64, dissipation: f64) -> f64 {
    if dissipation == 0.0 {
        return speed;
    }
    let potential = |v: f64| v / dissipation - (dissipation * v).ln_1p() / dissipation.powi(2);
    let (mut low, mut high) = (0.0, speed.min((1.0 - 1e-12) / dissipation));
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if potential(-middle) < potential(speed) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}
